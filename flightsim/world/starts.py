"""Where vehicles stand at first: free places around a scene's start, and how they come to rest."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from jaxtyping import Float

from aeroscene.scene import Scene
from aeroscene.scene.catalogue import WATER
from aeroscene.solids.shapes import Primitive
from autonomy.types import Vector3
from flightsim.vehicles.airframe import Airframe
from flightsim.vehicles.builder import add_vehicle
from flightsim.world.geometry import SurfaceProbe

APART_M = 3.0
"""Least distance between two starts."""
WITHIN_M = 15.0
"""Greatest distance of a start from the scene's own."""
LOWERING_M = 0.05
"""Height from which a vehicle is lowered, so that its uphill legs clear a sloping surface."""

_GRID_M = 1.0
_HIGHEST_STEP_M = 0.3
"""Difference in height from the scene's start up to which another place is beside it."""
_UNEVEN_M = 0.05
"""Greatest difference in height beneath a vehicle."""
_ROOM_M = 0.5
"""Free air around a vehicle at its start."""
_HEADROOM_M = 2.5
_LEVELS_M = (0.15, 0.5, 1.5)
"""Heights over the surface at which there must be room."""
_N_AROUND = 12

# A contact up there deeper than the tolerance means that the vehicle is inside something.
_PENETRATION_TOLERANCE_M = 0.01
_SETTLE_S = 1.0
_MAX_DRIFT_M = 0.10
_MAX_TILT_RAD = math.radians(20.0)


class WorldError(ValueError):
    """A scene and its vehicles make no valid world, for example by an impossible start."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PlacedVehicle:
    """A vehicle at its start."""

    airframe: Airframe
    stand_enu_m: Vector3
    """Point of the surface that it stands on."""
    yaw_rad: float

    @property
    def lowered_from_enu_m(self) -> Vector3:
        """Where its centre of mass is before it is lowered onto its legs."""
        x, y, z = self.stand_enu_m
        return (x, y, z + self.airframe.leg_length_m + LOWERING_M)


def place_vehicles(
    scene: Scene, airframes: Sequence[Airframe], solids: Sequence[Primitive]
) -> tuple[PlacedVehicle, ...]:
    """Stand the first vehicle on the scene's start, the others on the nearest free places.

    A place is free where the surface is about as high as the start's and even, where there is room
    around and above a vehicle, and nothing but air between it and the start.

    Args:
        scene: Scene with its start.
        airframes: The vehicles.
        solids: All static solids of the scene.

    Raises:
        WorldError: If there are fewer places than vehicles.
    """
    first, yaw_rad = scene.start_position_enu_m, scene.start_yaw_rad
    places: list[Vector3] = [first][: len(airframes)]
    if len(airframes) > 1:
        radius_m = max(airframe.collision_radius_m for airframe in airframes)
        apart_m = max(APART_M, 2.0 * (radius_m + _ROOM_M))
        for place in _free_places(scene, solids, radius_m):
            if len(places) == len(airframes):
                break
            if min(math.dist(place, taken) for taken in places) >= apart_m:
                places.append(place)
    if len(places) < len(airframes):
        raise WorldError(
            f"vehicles {len(airframes)}: the start of scene {scene.scene_id!r} has room for "
            f"{len(places)} at least {APART_M:g} m apart within {WITHIN_M:g} m; "
            f"valid: 1 to {len(places)}"
        )
    return tuple(
        PlacedVehicle(airframe=airframe, stand_enu_m=place, yaw_rad=yaw_rad)
        for airframe, place in zip(airframes, places, strict=True)
    )


def _free_places(scene: Scene, solids: Sequence[Primitive], radius_m: float) -> Iterator[Vector3]:
    """Free places beside a scene's start, the nearest first."""
    colliding = [solid for solid in solids if solid.collides]
    probe = SurfaceProbe(scene.relief, colliding)
    start = np.array(scene.start_position_enu_m)
    low, high = np.array(scene.extent_min_enu_m), np.array(scene.extent_max_enu_m)
    waters = {o.id for o in scene.objects if o.category in WATER}
    around_rad = np.linspace(0.0, math.tau, _N_AROUND, endpoint=False)
    ring = np.column_stack([np.cos(around_rad), np.sin(around_rad), np.zeros(_N_AROUND)])
    feet_m = np.vstack([np.zeros(3), radius_m * ring])
    n = math.floor(WITHIN_M / _GRID_M)
    steps = [_GRID_M * k for k in range(-n, n + 1)]
    shifts = [shift for shift in itertools.product(steps, steps) if math.hypot(*shift) <= WITHIN_M]
    for dx, dy in sorted(shifts, key=lambda shift: (math.hypot(*shift), shift)):
        middle = start + np.array([dx, dy, _HIGHEST_STEP_M])
        is_within = np.all(middle[:2] - radius_m >= low[:2]) and np.all(
            middle[:2] + radius_m <= high[:2]
        )
        if not is_within or math.hypot(dx, dy) < APART_M:
            continue
        heights_m, hit = probe.surfaces(middle + feet_m)
        is_even = np.ptp(heights_m) <= _UNEVEN_M and start[2] - heights_m[0] <= _HIGHEST_STEP_M
        on = {colliding[geom - 1].object_id for geom in hit.tolist() if geom > 0}
        if not is_even or on & waters:  # A NaN is not even.
            continue
        place = np.array([middle[0], middle[1], heights_m.max()])
        if _has_room(probe, place, radius_m, ring) and _is_in_sight(probe, start, place):
            x, y, z = place.tolist()
            yield (x, y, z)


def _has_room(
    probe: SurfaceProbe,
    place_enu_m: Float[np.ndarray, 3],
    radius_m: float,
    ring: Float[np.ndarray, "n 3"],
) -> bool:
    """Whether nothing is beside a place or above it."""
    up = np.array([0.0, 0.0, 1.0])
    for level_m in _LEVELS_M:
        eye = place_enu_m + level_m * up
        if any(probe.distance_m(eye, way) < radius_m + _ROOM_M for way in ring):
            return False
    eyes = place_enu_m + _LEVELS_M[0] * up + np.vstack([np.zeros(3), radius_m * ring])
    return all(probe.distance_m(eye, up) >= _HEADROOM_M for eye in eyes)


def _is_in_sight(
    probe: SurfaceProbe, start_enu_m: Float[np.ndarray, 3], place_enu_m: Float[np.ndarray, 3]
) -> bool:
    """Whether there is nothing but air from one place to another, at two heights."""
    for level_m in _LEVELS_M[1:]:
        eye = start_enu_m + np.array([0.0, 0.0, level_m])
        way = place_enu_m - start_enu_m
        length_m = float(np.linalg.norm(way))
        if probe.distance_m(eye, way / length_m) < length_m:
            return False
    return True


def add_vehicles(spec: mujoco.MjSpec, vehicles: Sequence[PlacedVehicle]) -> None:
    """Add vehicles just above their starts."""
    for number, each in enumerate(vehicles):
        add_vehicle(spec, each.airframe, each.lowered_from_enu_m, each.yaw_rad, number=number)


def settle(
    model: mujoco.MjModel, vehicles: Sequence[PlacedVehicle], bodies: Sequence[int]
) -> Float[np.ndarray, " nq"]:
    """Lower vehicles onto their starts and return the configuration in which they rest.

    Args:
        model: World with the vehicles as they are lowered.
        vehicles: The vehicles.
        bodies: Body of each in the model.

    Raises:
        WorldError: If one does not stay where it was put.
    """
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for _ in range(round(_SETTLE_S / model.opt.timestep)):
        mujoco.mj_step(model, data)
    for vehicle, body in zip(vehicles, bodies, strict=True):
        at = model.jnt_qposadr[model.body_jntadr[body]]
        moved = data.qpos[at : at + 3] - model.qpos0[at : at + 3] + (0.0, 0.0, LOWERING_M)
        drift_m = float(np.linalg.norm(moved))
        _, x, y, _ = data.qpos[at + 3 : at + 7]
        tilt_rad = math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (x * x + y * y))))
        if drift_m > _MAX_DRIFT_M or tilt_rad > _MAX_TILT_RAD:
            raise WorldError(
                f"start_position_enu_m {vehicle.stand_enu_m} is no place to stand (the vehicle "
                f"moved {drift_m:.2f} m and tilted {math.degrees(tilt_rad):.0f} degrees); "
                "valid: a point on a flat surface"
            )
    return data.qpos.copy()


def inside_of(model: mujoco.MjModel, body: int) -> int | None:
    """Geom that a vehicle is inside of before it is lowered; None if it is free."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for contact in data.contact[: data.ncon] if data.ncon else ():
        bodies = model.geom_bodyid[contact.geom].tolist()
        if contact.dist < -_PENETRATION_TOLERANCE_M and body in bodies:
            return int(contact.geom[1 - bodies.index(body)])
    return None
