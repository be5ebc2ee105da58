"""A vehicle of the run as AirSim's clients know it: a name, a frame of its own, what it touched."""

from __future__ import annotations

from dataclasses import dataclass, field

import msgspec
import mujoco
import numpy as np

from autonomy.types import Vector3
from flightsim.testbench import Vehicle
from flightsim.world import FIRST_MATE_ID, FIRST_MOVER_ID, GROUND_ID, NEIGHBOUR_ID, World
from scenarios.airsim.flyer import Flyer
from scenarios.airsim.frames import ned, stamp
from scenarios.airsim.messages import Collision, Vector3r
from scenarios.airsim.methods import RpcError
from scenarios.airsim.rangers import Rangers


@dataclass(frozen=True, kw_only=True, eq=False)
class Craft:
    """A vehicle with its name and its origin."""

    name: str
    vehicle: Vehicle
    flyer: Flyer
    origin_enu_m: Vector3
    """Place of the vehicle at the start: origin of its local frame, north-east-down."""
    contacts: Contacts
    rangers: Rangers
    """Its distance sensors and lidars."""

    def local(self, position_enu_m: Vector3) -> Vector3r:
        """A position of the scene in the vehicle's local frame."""
        x, y, z = position_enu_m
        ox, oy, oz = self.origin_enu_m
        return ned((x - ox, y - oy, z - oz))

    def scene_enu_m(self, position: Vector3r) -> Vector3:
        """A position of the vehicle's local frame in the scene.

        Raises:
            RpcError: If it is not finite.
        """
        if not position.is_finite:
            raise RpcError("position is not finite; valid: numbers in metres")
        ox, oy, oz = self.origin_enu_m
        return (ox + position.y_val, oy + position.x_val, oz - position.z_val)


class Contacts:
    """Remembers the last thing that a vehicle touched; call `on_tick` after each tick."""

    def __init__(self, vehicle: Vehicle, origin_enu_m: Vector3, names: Names) -> None:
        self._plant, self._origin, self._names = vehicle.plant, origin_enu_m, names
        self._last = Collision()
        self._has_new = False

    def on_tick(self) -> None:
        """Look at the contacts, if there are any."""
        if not self._plant.contact_ticks:
            return
        found = _contact(self._plant.world, self._plant.data)
        if found is None:
            return
        object_id, position, normal, depth_m = found
        truth = self._plant.truth
        self._has_new = True
        self._last = Collision(
            has_collided=True,
            penetration_depth=depth_m,
            time_stamp=stamp(truth.time_us),
            normal=ned(normal),
            impact_point=self._local(position),
            position=self._local(truth.position_enu_m),
            object_name=self._names.of(object_id),
            object_id=object_id,
        )

    @property
    def last(self) -> Collision:
        """The last thing that was touched, whether or not anybody has asked."""
        return self._last

    def take(self) -> Collision:
        """The same; it counts as a collision only until somebody takes it."""
        taken = msgspec.structs.replace(self._last, has_collided=self._has_new)
        self._has_new = False
        return taken

    def _local(self, position: Vector3) -> Vector3r:
        x, y, z = position
        ox, oy, oz = self._origin
        return ned((x - ox, y - oy, z - oz))


def _contact(world: World, data: mujoco.MjData) -> tuple[int, Vector3, Vector3, float] | None:
    """Object, point, normal towards the vehicle and depth of the deepest contact now."""
    model, body = world.model, world.vehicle_body_id
    best: tuple[int, Vector3, Vector3, float] | None = None
    for contact in data.contact[: data.ncon]:
        first, second = contact.geom.tolist()
        is_first = model.geom_bodyid[first] == body
        if not is_first and model.geom_bodyid[second] != body:
            continue
        other = second if is_first else first
        depth_m = float(-contact.dist)
        if best is not None and depth_m <= best[3]:
            continue
        normal = np.asarray(contact.frame[:3]) * (-1.0 if is_first else 1.0)
        x, y, z = contact.pos.tolist()
        nx, ny, nz = normal.tolist()
        best = (int(world.geom_object_id[other]), (x, y, z), (nx, ny, nz), depth_m)
    return best


@dataclass(kw_only=True, eq=False)
class Names:
    """Names of what is in the world, as AirSim's clients use them."""

    world: World
    vehicles: list[str] = field(default_factory=list)

    def of(self, object_id: int) -> str:
        """Name of a thing by its id."""
        if object_id == GROUND_ID:
            return "Ground"
        if object_id == NEIGHBOUR_ID:
            return "Surroundings"
        if object_id <= FIRST_MATE_ID:
            return self.vehicles[FIRST_MATE_ID - object_id]
        if object_id <= FIRST_MOVER_ID:
            return self.world.name_of(object_id).replace(" ", "_")
        if object_id < 0:
            return self.vehicles[0]
        return self._objects.get(object_id, f"object_{object_id}")

    def __post_init__(self) -> None:
        self._objects = {
            each.id: f"{each.category.replace(' ', '_')}_{each.id}"
            for each in self.world.scene.objects
        }

    @property
    def objects(self) -> dict[int, str]:
        """Names of the scene's objects by their ids."""
        return self._objects
