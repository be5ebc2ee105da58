"""A scene and a vehicle compiled into one MuJoCo model, ready to step.

Integrator: MuJoCo's default, semi-implicit Euler. The only moving body is free, without joint
damping or springs, and its forces are constant over a step; implicit variants make no difference
here, and RK4 evaluates everything four times. Contacts use elliptic friction cones with a raised
`impratio`, which keeps a landed vehicle from creeping down a slope.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from aeroscene.scene import Scene
from aeroscene.solids.shapes import MATERIALS, Primitive, scene_primitives
from autonomy.model.quadrotor import GRAVITY_MPS2
from flightsim.environment.motion import start_poses
from flightsim.environment.movers import MovingObstacle, mover_name
from flightsim.environment.traffic import TrafficCfg, plan_traffic
from flightsim.looks.drawing import add_looks, set_view
from flightsim.looks.movers import MOVER_CONTACT_BIT, MoverSet
from flightsim.looks.surfaces import Detail
from flightsim.looks.surroundings import GROUND_MATERIAL
from flightsim.vehicles.airframe import Airframe
from flightsim.vehicles.builder import VEHICLE_BODY, add_vehicle
from flightsim.world_geometry import STATIC_CONTACT, SurfaceProbe, add_solids, friction
from flightsim.world_rays import RayTree

VEHICLE_ID = -1
"""Id of the vehicle's own geoms in `World.geom_object_id`."""
GROUND_ID = -2
"""Id of the ground plane in `World.geom_object_id`."""
FIRST_MOVER_ID = -10
"""Id of the first moving obstacle in `World.geom_object_id`; the next ones count down."""

# The vehicle is lowered from this height, so that the uphill legs clear a sloping surface. A
# contact up there deeper than the tolerance means that it is inside something.
_LOWERING_M = 0.05
_PENETRATION_TOLERANCE_M = 0.01
_SETTLE_S = 1.0
_MAX_SETTLE_DRIFT_M = 0.10
_MAX_START_TILT_RAD = math.radians(20.0)


class WorldError(ValueError):
    """A scene and a vehicle make no valid world, for example by an impossible start."""


@dataclass(frozen=True, eq=False)
class World:
    """A compiled scene with one vehicle in it (or none)."""

    model: mujoco.MjModel
    scene: Scene
    airframe: Airframe
    solids: tuple[Primitive, ...]
    """All static solids: geom 0 is the ground, geom 1 + i is solid i."""
    obstacles: tuple[MovingObstacle, ...]
    """All movers: mocap body i is obstacle i."""
    movers: MoverSet
    """Appearance of the movers."""
    rays: RayTree
    """By which rays find its geoms."""
    geom_object_id: np.ndarray
    """Id (ngeom,) int32 of the scene object, `VEHICLE_ID`, `GROUND_ID`, or id of a mover."""
    vehicle_body_id: int
    """Body of the vehicle, -1 in a world without one."""
    rest_qpos: np.ndarray
    """Configuration (nq,) of the vehicle standing on its legs at the start."""

    def new_looks(self, detail: Detail) -> mujoco.MjModel:
        """Build a drawing model of the same world; `qpos` and mocap poses mean the same in it."""
        spec = mujoco.MjSpec()
        set_view(spec, self.scene)
        add_looks(spec, self.scene, self.solids, detail)
        if self.vehicle_body_id >= 0:
            add_vehicle_at_start(spec, self.scene, self.airframe)
        self.movers.add_looks(spec)
        return spec.compile()

    def mover_body_id(self, index: int) -> int:
        """Body of a moving obstacle."""
        name = mover_name(index, self.obstacles)
        return mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_BODY, name)

    def name_of(self, object_id: int) -> str:
        """Name of a thing by its id in `geom_object_id`, such as "object 12 (tree)"."""
        if object_id == VEHICLE_ID:
            return "the vehicle"
        if object_id <= FIRST_MOVER_ID:
            return mover_name(FIRST_MOVER_ID - object_id, self.obstacles)
        return _describe(self.scene, object_id)

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
    traffic: TrafficCfg | Sequence[MovingObstacle] = (),
) -> World:
    """Compile a scene with a vehicle standing at its start.

    Args:
        scene: Objects and the start.
        airframe: Vehicle with its cameras.
        physics_hz: Steps per second.
        vehicle: Whether to add the vehicle; False is for pictures of the scene alone.
        extra: Solids besides the scene's objects.
        traffic: Movers on their paths, or the number of movers to find paths for.

    Raises:
        WorldError: If the start is inside something or not a place to stand.
        TrafficError: If the scene has no room for the traffic.
    """
    solids = (*scene_primitives(scene), *extra)
    spec = new_spec(scene, physics_hz)
    add_ground(spec)
    add_solids(spec, solids)
    if vehicle:
        add_vehicle_at_start(spec, scene, airframe)
    if isinstance(traffic, TrafficCfg):
        traffic = plan_traffic(traffic, scene, solids, SurfaceProbe(solids).height_m)
    movers = MoverSet(traffic)
    if len(movers):
        _let_vehicle_touch_movers(spec)
        movers.add_solids(spec)
    model = spec.compile()
    _enable_sleep(model)
    _put_movers(model, traffic)
    geom_object_id = np.full(model.ngeom, VEHICLE_ID, dtype=np.int32)
    geom_object_id[: 1 + len(solids)] = [GROUND_ID, *(solid.object_id for solid in solids)]
    is_mover = model.body_mocapid[model.geom_bodyid] >= 0
    geom_object_id[is_mover] = FIRST_MOVER_ID - np.arange(len(movers))
    return World(
        model=model,
        solids=solids,
        obstacles=tuple(traffic),
        movers=movers,
        scene=scene,
        airframe=airframe,
        rays=RayTree.of(model),
        geom_object_id=geom_object_id,
        vehicle_body_id=mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, VEHICLE_BODY),
        rest_qpos=_settle(model, scene, geom_object_id) if vehicle else model.qpos0.copy(),
    )


def new_spec(scene: Scene, physics_hz: int) -> mujoco.MjSpec:
    """Create an empty world with the solver's settings, light and sky."""
    spec = mujoco.MjSpec()
    spec.modelname = scene.scene_id
    spec.option.timestep = 1.0 / physics_hz
    spec.option.gravity = (0.0, 0.0, -GRAVITY_MPS2)
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    set_view(spec, scene)
    return spec


def add_vehicle_at_start(spec: mujoco.MjSpec, scene: Scene, airframe: Airframe) -> None:
    """Add the vehicle just above the scene's start."""
    x, y, z = scene.start_position_enu_m
    stand_enu_m = (x, y, z + airframe.leg_length_m + _LOWERING_M)
    add_vehicle(spec, airframe, stand_enu_m, scene.start_yaw_rad)


def _let_vehicle_touch_movers(spec: mujoco.MjSpec) -> None:
    body = spec.body(VEHICLE_BODY)
    for geom in () if body is None else body.geoms:
        if geom.contype:
            geom.contype |= MOVER_CONTACT_BIT


def _put_movers(model: mujoco.MjModel, obstacles: Sequence[MovingObstacle]) -> None:
    """Place the movers at their poses at time zero."""
    if obstacles:
        is_mover = model.body_mocapid >= 0
        model.body_pos[is_mover], model.body_quat[is_mover] = start_poses(obstacles)


def add_ground(spec: mujoco.MjSpec) -> None:
    """Add the plane z = 0, which is geom "ground"."""
    spec.worldbody.add_geom(
        name="ground",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        # Zero is infinite. The third number is MuJoCo's grid spacing for drawing.
        size=(0.0, 0.0, 1.0),
        rgba=MATERIALS[GROUND_MATERIAL].rgba,
        friction=friction(GROUND_MATERIAL),
        **STATIC_CONTACT,
    )


def _enable_sleep(model: mujoco.MjModel) -> None:
    """Skip the kinematics of geoms that never move; the vehicle itself never sleeps.

    Bit-identical to the same world without sleeping, and twice as fast with 600 geoms.
    """
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP
    model.tree_sleep_policy[:] = mujoco.mjtSleepPolicy.mjSLEEP_NEVER


def _settle(model: mujoco.MjModel, scene: Scene, geom_object_id: np.ndarray) -> np.ndarray:
    """Lower the vehicle onto the start and return its resting configuration, (nq,)."""
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
    if object_id <= FIRST_MOVER_ID:
        return f"moving obstacle {FIRST_MOVER_ID - object_id}"
    category = next((o.category for o in scene.objects if o.id == object_id), "unknown")
    return f"object {object_id} ({category})"
