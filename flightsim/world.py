"""A scene and a vehicle compiled into one MuJoCo model, ready to step.

Integrator: MuJoCo's default, semi-implicit Euler. The only moving body is free, without joint
damping or springs, and its forces are held over a step; implicit variants differ from it in nothing
here, and RK4 evaluates everything four times. Contacts use elliptic friction cones with a raised
`impratio`, which keeps a landed vehicle from creeping down a slope.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from aeroscene.scene import Scene
from aeroscene.shapes import MATERIALS, Primitive, scene_primitives
from autonomy.model.quadrotor import GRAVITY_MPS2
from flightsim.sensors.sky import HORIZON_RGB, ZENITH_RGB
from flightsim.vehicles.airframe import Airframe
from flightsim.vehicles.builder import VEHICLE_BODY, add_vehicle
from flightsim.world_geometry import STATIC_CONTACT, StaticGeometry

VEHICLE_ID = -1
"""In `World.geom_object_id`: the vehicle's own geoms."""
GROUND_ID = -2
"""In `World.geom_object_id`: the ground plane."""

_GROUND_MATERIALS = ("ground", "grass", "concrete")

# The vehicle is let down from this height, so that the uphill legs clear a sloping surface; what
# it touches up there deeper than the tolerance, it is inside of.
_LOWERING_M = 0.05
_PENETRATION_TOLERANCE_M = 0.01
_SETTLE_S = 1.0
_MAX_SETTLE_DRIFT_M = 0.10
_MAX_START_TILT_RAD = math.radians(20.0)


class WorldError(ValueError):
    """A scene and a vehicle that make no world, such as an impossible start."""


@dataclass(frozen=True, eq=False)
class World:
    """A compiled scene with one vehicle in it (or none)."""

    model: mujoco.MjModel
    scene: Scene
    airframe: Airframe
    geom_object_id: np.ndarray
    """(ngeom,) int32: id of the scene object, `VEHICLE_ID` or `GROUND_ID`."""
    vehicle_body_id: int
    """-1 in a world without a vehicle."""
    rest_qpos: np.ndarray
    """(nq,) of the vehicle standing on its legs at the start."""

    def new_data(self) -> mujoco.MjData:
        """State at time zero: the vehicle at the start, at rest on its legs."""
        data = mujoco.MjData(self.model)
        data.qpos[:] = self.rest_qpos
        mujoco.mj_forward(self.model, data)
        return data


def build_world(
    scene: Scene,
    airframe: Airframe,
    *,
    physics_hz: int = 500,
    vehicle: bool = True,
    extra: Sequence[Primitive] = (),
) -> World:
    """Compile a scene with a vehicle standing at its start.

    Args:
        scene: What stands where, and the start.
        airframe: The vehicle; also its cameras.
        physics_hz: Steps per second, Hz.
        vehicle: False leaves the vehicle out, for pictures of the scene alone.
        extra: Solids that stand there beside the scene's objects.

    Raises:
        WorldError: If the start is inside something or no place to stand.
    """
    spec = _new_spec(scene, physics_hz)
    geometry = StaticGeometry(spec, MATERIALS)
    _add_ground(spec, geometry)
    object_ids = [GROUND_ID, *geometry.add([*scene_primitives(scene), *extra])]
    if vehicle:
        x, y, z = scene.start_position_enu_m
        stand_enu_m = (x, y, z + airframe.leg_length_m + _LOWERING_M)
        add_vehicle(spec, airframe, stand_enu_m, scene.start_yaw_rad)
    model = spec.compile()
    _enable_sleep(model)
    geom_object_id = np.full(model.ngeom, VEHICLE_ID, dtype=np.int32)
    geom_object_id[: len(object_ids)] = object_ids
    return World(
        model=model,
        scene=scene,
        airframe=airframe,
        geom_object_id=geom_object_id,
        vehicle_body_id=mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, VEHICLE_BODY),
        rest_qpos=_settle(model, scene, geom_object_id) if vehicle else model.qpos0.copy(),
    )


def _new_spec(scene: Scene, physics_hz: int) -> mujoco.MjSpec:
    spec = mujoco.MjSpec()
    spec.modelname = scene.scene_id
    spec.option.timestep = 1.0 / physics_hz
    spec.option.gravity = (0.0, 0.0, -GRAVITY_MPS2)
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    _set_view(spec, scene)
    _add_sky_and_sun(spec)
    return spec


def _set_view(spec: mujoco.MjSpec, scene: Scene) -> None:
    """Clip planes and the tessellation that keeps software rendering fast."""
    low, high = np.array(scene.extent_min_enu_m), np.array(scene.extent_max_enu_m)
    diagonal_m = float(np.linalg.norm(high - low))
    spec.stat.center = (low + high) / 2
    spec.stat.extent = diagonal_m / 2
    visual: Any = spec.visual
    visual.map.znear = 0.03 / spec.stat.extent
    visual.map.zfar = 12.0
    visual.quality.offsamples = 0
    visual.quality.numslices = 14
    visual.quality.numstacks = 8
    visual.quality.numquads = 1
    # No shadows but in fine pictures, whose renderer sets its own; a map costs start-up time.
    visual.quality.shadowsize = 0
    visual.global_.offwidth = 1920
    visual.global_.offheight = 1080
    visual.headlight.ambient = (0.42, 0.43, 0.46)
    visual.headlight.diffuse = (0.10, 0.10, 0.10)
    visual.headlight.specular = (0.0, 0.0, 0.0)


def _add_sky_and_sun(spec: mujoco.MjSpec) -> None:
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=ZENITH_RGB,
        rgb2=HORIZON_RGB,
        width=128,
        height=768,
    )
    spec.worldbody.add_light(
        name="sun",
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=(0.0, 0.0, 100.0),
        dir=(0.45, 0.30, -0.84),
        diffuse=(0.58, 0.56, 0.50),
        specular=(0.15, 0.15, 0.15),
        ambient=(0.0, 0.0, 0.0),
        castshadow=True,
    )


def _add_ground(spec: mujoco.MjSpec, geometry: StaticGeometry) -> None:
    name = next(name for name in _GROUND_MATERIALS if name in MATERIALS)
    spec.worldbody.add_geom(
        name="ground",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        # Zero: without end. The third number is MuJoCo's spacing for drawing it.
        size=(0.0, 0.0, 1.0),
        material=geometry.surface(name),
        friction=(MATERIALS[name].friction, 0.005, 0.0001),
        **STATIC_CONTACT,
    )


def _enable_sleep(model: mujoco.MjModel) -> None:
    """Skip the kinematics of geoms that never move; the vehicle itself never sleeps.

    Bit-identical to the same world without sleeping, and twice as fast with 600 geoms.
    """
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP
    model.tree_sleep_policy[:] = mujoco.mjtSleepPolicy.mjSLEEP_NEVER


def _settle(model: mujoco.MjModel, scene: Scene, geom_object_id: np.ndarray) -> np.ndarray:
    """Let the vehicle down onto the start and return where it comes to rest, (nq,)."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    _check_not_inside(data, scene, geom_object_id)
    for _ in range(round(_SETTLE_S / model.opt.timestep)):
        mujoco.mj_step(model, data)
    drift_m = float(np.linalg.norm(data.qpos[:3] - model.qpos0[:3] + (0.0, 0.0, _LOWERING_M)))
    _, x, y, _ = data.qpos[3:7]
    tilt_rad = math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (x * x + y * y))))
    if drift_m > _MAX_SETTLE_DRIFT_M or tilt_rad > _MAX_START_TILT_RAD:
        raise WorldError(
            f"start_position_enu_m {scene.start_position_enu_m} is no place to stand (the vehicle "
            f"moved {drift_m:.2f} m and tilted {math.degrees(tilt_rad):.0f} degrees), "
            "valid: a point on a flat surface"
        )
    return data.qpos.copy()


def _check_not_inside(data: mujoco.MjData, scene: Scene, geom_object_id: np.ndarray) -> None:
    for contact in data.contact[: data.ncon] if data.ncon else ():
        if contact.dist < -_PENETRATION_TOLERANCE_M:
            ids = geom_object_id[contact.geom].tolist()
            object_id = next(i for i in ids if i != VEHICLE_ID)
            raise WorldError(
                f"start_position_enu_m {scene.start_position_enu_m} puts the vehicle inside "
                f"{_describe(scene, object_id)}, valid: a free point on a surface"
            )


def _describe(scene: Scene, object_id: int) -> str:
    if object_id == GROUND_ID:
        return "the ground"
    category = next((o.category for o in scene.objects if o.id == object_id), "unknown")
    return f"object {object_id} ({category})"
