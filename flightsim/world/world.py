"""A scene and its vehicles compiled into one MuJoCo model, ready to step.

Physics, rays and lidars share this model, and a second one for drawing is built from the same
parts, so all see the same world. Ids of objects are attached to its geoms, by which hits and pixels
have names. Several vehicles share one `World` each as its own view: in it the vehicle's geoms are
its own, and the others are things that it sees.

The integrator is MuJoCo's default, semi-implicit Euler. The moving bodies are free, without joint
damping or springs, and their forces are constant over a step, so implicit variants make no
difference. Elliptic friction cones with a raised `impratio` keep a landed vehicle from creeping
downhill.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from jaxtyping import Bool, Int

from aeroscene.neighbourhood import NEIGHBOUR_OBJECT_ID, neighbours_of
from aeroscene.scene import Scene
from aeroscene.solids.shapes import Primitive, scene_primitives
from autonomy.model.quadrotor import GRAVITY_MPS2
from flightsim.environment.motion import start_poses
from flightsim.environment.movers import MovingObstacle, mover_name
from flightsim.environment.traffic import TrafficCfg, plan_traffic
from flightsim.looks.drawing import add_looks, set_view
from flightsim.looks.geom_groups import GeomGroup
from flightsim.looks.light import AFTERNOON, Light
from flightsim.looks.movers import MoverSet
from flightsim.looks.surfaces import Detail
from flightsim.vehicles.airframe import Airframe
from flightsim.vehicles.builder import part_name, vehicle_name
from flightsim.vehicles.contact_filter import enable_mover_contacts, enable_vehicle_contacts
from flightsim.world.geometry import SurfaceProbe, add_solids
from flightsim.world.ground import add_ground, add_ground_beyond
from flightsim.world.rays import RayTree
from flightsim.world.starts import (
    PlacedVehicle,
    WorldError,
    add_vehicles,
    inside_of,
    place_vehicles,
    settle,
)

VEHICLE_ID, GROUND_ID = -1, -2
"""Ids of the vehicle's own geoms and of the ground in `World.geom_object_id`."""
GROUND_NAME = "the ground"
"""Name of the ground, as `World.name_of` gives it."""
NEIGHBOUR_ID = NEIGHBOUR_OBJECT_ID
"""Id of the houses and trees around the site, in `World.geom_object_id`; -3 is the sky."""
NEIGHBOUR_NAME = "the surroundings"
FIRST_MOVER_ID = -10
"""Id of the first moving obstacle in `World.geom_object_id`; the next ones count down."""
FIRST_MATE_ID = -100
"""Id of the first vehicle of a world in the view of another; the next ones count down."""


@dataclass(frozen=True, eq=False)
class World:
    """A compiled scene in the view of one vehicle, alone or among others, or without any."""

    model: mujoco.MjModel
    scene: Scene
    """The scene, with this vehicle's start."""
    solids: tuple[Primitive, ...]
    """All static solids: geom 0 is the ground, geom 1 + i is solid i. The ground beyond the grid of
    a relief and the neighbours of the site follow."""
    obstacles: tuple[MovingObstacle, ...]
    """All movers: mocap body i is obstacle i."""
    movers: MoverSet
    """Appearance of the movers."""
    rays: RayTree
    """Index for the rays of the plant: the geoms of the site, without its neighbours."""
    wide_rays: RayTree
    """Index for the beams of lidars, with the neighbours of the site."""
    geom_object_id: np.ndarray
    """Id (ngeom,) int32 of a scene object, `VEHICLE_ID`, `GROUND_ID`, `NEIGHBOUR_ID`, or of a mover
    or another vehicle."""
    vehicle_body_id: int
    """Body of the vehicle, -1 in a world without one."""
    rest_qpos: np.ndarray
    """Configuration (nq,) of all vehicles standing on their legs at their starts."""
    vehicles: tuple[PlacedVehicle, ...] = ()
    """All vehicles in it."""
    number: int = 0
    """Number of this one among them."""
    light: Light = AFTERNOON
    """Light of its pictures."""

    @property
    def n_vehicles(self) -> int:
        """Number of vehicles in it."""
        return len(self.vehicles)

    @property
    def airframe(self) -> Airframe:
        """Airframe of this vehicle."""
        return self.vehicles[self.number].airframe

    @property
    def views(self) -> tuple[World, ...]:
        """The world in the view of each of its vehicles, in their order."""
        return tuple(self._as_of(number) for number in range(self.n_vehicles))

    @property
    def qpos_address(self) -> int:
        """Index at which the pose of the vehicle (7,) begins in a configuration."""
        return int(self.model.jnt_qposadr[self.model.body_jntadr[self.vehicle_body_id]])

    def _as_of(self, number: int) -> World:
        """Return the world in the view of the vehicle with a number; both share the model."""
        if number == self.number:
            return self
        vehicle, ids = self.vehicles[number], self.geom_object_id.copy()
        # The two swap roles: this one becomes another vehicle, and that one the vehicle.
        ids[self.geom_object_id == VEHICLE_ID] = FIRST_MATE_ID - self.number
        ids[self.geom_object_id == FIRST_MATE_ID - number] = VEHICLE_ID
        return replace(
            self,
            scene=replace(self.scene, start_position_enu_m=vehicle.stand_enu_m),
            geom_object_id=ids,
            vehicle_body_id=self.model.body(vehicle_name(number)).id,
            number=number,
        )

    def camera_name(self, camera: str) -> str:
        """Return the name that one of the vehicle's cameras has in the model."""
        return part_name(self.number, camera)

    def is_of_mate(self, model: mujoco.MjModel) -> Bool[np.ndarray, " ngeom"]:
        """Return True for each geom that belongs to another vehicle.

        Args:
            model: A model of this world, to fly or to draw.
        """
        names = [vehicle_name(k) for k in range(self.n_vehicles) if k != self.number]
        bodies = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name) for name in names]
        return np.isin(model.geom_bodyid, bodies)

    def as_seen(self) -> mujoco.MjModel:
        """Return the model for the vehicle's cameras, which draw the other vehicles as movers."""
        # A copy, since each vehicle hides itself and shows the others.
        if self.n_vehicles < 2:
            return self.model
        return self._with_visible_mates(copy.copy(self.model))

    def new_looks(self, detail: Detail) -> mujoco.MjModel:
        """Build a drawing model of the same world; `qpos` and mocap poses mean the same in it.

        Args:
            detail: Fineness of the looks.
        """
        spec = mujoco.MjSpec()
        set_view(spec, self.scene, self.light)
        add_looks(spec, self.scene, self.solids, detail, self.light)
        add_vehicles(spec, self.vehicles)
        self.movers.add_looks(spec)
        return self._with_visible_mates(spec.compile())

    def _with_visible_mates(self, model: mujoco.MjModel) -> mujoco.MjModel:
        # Cameras leave out the group of vehicles' looks, so that none sees the one that carries it.
        is_shown = self.is_of_mate(model) & (model.geom_group == GeomGroup.VEHICLE_LOOKS)
        model.geom_group[is_shown] = GeomGroup.MOVING
        return model

    def mover_body_id(self, index: int) -> int:
        """Return the body of a moving obstacle."""
        name = mover_name(index, self.obstacles)
        return mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_BODY, name)

    def name_of(self, object_id: int) -> str:
        """Return the name of a thing by its id in `geom_object_id`, such as "object 12 (tree)".

        Args:
            object_id: Any id that occurs there.
        """
        if object_id == VEHICLE_ID:
            return "the vehicle"
        if object_id <= FIRST_MATE_ID:
            return f"vehicle {FIRST_MATE_ID - object_id + 1}"
        if object_id <= FIRST_MOVER_ID:
            return mover_name(FIRST_MOVER_ID - object_id, self.obstacles)
        return _describe(self.scene, object_id)

    def new_data(self) -> mujoco.MjData:
        """Return the state at time zero: the vehicles at their starts, at rest on their legs."""
        data = mujoco.MjData(self.model)
        data.qpos[:] = self.rest_qpos
        mujoco.mj_forward(self.model, data)
        return data


def build_world(
    scene: Scene,
    *airframes: Airframe,
    physics_hz: int = 500,
    extra: Sequence[Primitive] = (),
    traffic: TrafficCfg | Sequence[MovingObstacle] = (),
    light: Light = AFTERNOON,
) -> World:
    """Compile a scene with its vehicles, the first at the scene's start, the others beside it.

    Args:
        scene: Objects and the start.
        airframes: Vehicles with their cameras; none for pictures of the scene alone.
        physics_hz: Steps per second.
        extra: Solids besides the scene's objects.
        traffic: Movers on their paths, or the number of movers to find paths for.
        light: Light of pictures; it changes nothing else.

    Returns:
        The world in the view of the first vehicle; `World.views` has that of each.

    Raises:
        WorldError: If a vehicle has no room at its start, is inside something or cannot stand.
        TrafficError: If the scene has no room for the traffic.
    """
    solids = (*scene_primitives(scene), *extra)
    vehicles = place_vehicles(scene, airframes, solids)
    spec = new_spec(scene, physics_hz)
    # `_geom_ids` relies on this order of the static geoms.
    add_ground(spec, scene.relief)
    add_solids(spec, solids)
    add_ground_beyond(spec, scene.relief)
    neighbours = [part for part in neighbours_of(scene) if part.collides]
    add_solids(spec, neighbours, "neighbour")
    add_vehicles(spec, vehicles)
    if isinstance(traffic, TrafficCfg):
        stands = [vehicle.stand_enu_m for vehicle in vehicles]
        probe = SurfaceProbe(scene.relief, solids)
        traffic = plan_traffic(traffic, scene, solids, probe.height_m, stands)
    movers = MoverSet(traffic)
    if len(vehicles) > 1:
        enable_vehicle_contacts(spec, len(vehicles))
    if len(movers):
        enable_mover_contacts(spec, len(vehicles))
        movers.add_solids(spec)
    model = _compiled(spec, scene, airframes)
    _enable_sleep(model)
    _put_movers(model, traffic)
    bodies = [model.body(vehicle_name(k)).id for k in range(len(vehicles))]
    ids = _geom_ids(model, solids, len(neighbours), bodies)
    # Without neighbours both indices are one, and its memory is shared.
    wide_rays, is_neighbour = RayTree.from_model(model), ids == NEIGHBOUR_ID
    for vehicle, body in zip(vehicles, bodies, strict=True):
        if (geom := inside_of(model, body)) is not None:
            where = f"{vehicle.stand_enu_m} puts the vehicle inside"
            what = f"{where} {_describe(scene, int(ids[geom]))}"
            raise WorldError(f"start_position_enu_m {what}; valid: a free point on a surface")
    return World(
        model=model,
        solids=solids,
        obstacles=tuple(traffic),
        movers=movers,
        scene=scene,
        rays=RayTree.from_model(model, is_neighbour) if is_neighbour.any() else wide_rays,
        wide_rays=wide_rays,
        geom_object_id=ids,
        vehicle_body_id=bodies[0] if bodies else -1,
        rest_qpos=settle(model, vehicles, bodies) if vehicles else model.qpos0.copy(),
        vehicles=vehicles,
        light=light,
    )


def _geom_ids(
    model: mujoco.MjModel, solids: Sequence[Primitive], n_neighbours: int, bodies: Sequence[int]
) -> Int[np.ndarray, " geoms"]:
    """Return the id of each geom's owner: an object, the ground, a neighbour, a vehicle or a mover.

    Args:
        model: Compiled world.
        solids: Static solids of the scene, in the order of their geoms.
        n_neighbours: Number of solids around the site, the last of the static geoms.
        bodies: Bodies of the vehicles.
    """
    ids = np.zeros(model.ngeom, dtype=np.int32)
    n_static = int(np.count_nonzero(model.geom_bodyid == 0))
    # The ground, the solids, the ground beyond a relief's grid, the neighbours.
    ids[:n_static] = GROUND_ID
    ids[1 : 1 + len(solids)] = [solid.object_id for solid in solids]
    ids[n_static - n_neighbours : n_static] = NEIGHBOUR_ID
    for k, body in enumerate(bodies):
        ids[model.geom_bodyid == body] = FIRST_MATE_ID - k if k else VEHICLE_ID
    is_mover = model.body_mocapid[model.geom_bodyid] >= 0  # each mover is one geom
    ids[is_mover] = FIRST_MOVER_ID - np.arange(np.count_nonzero(is_mover))
    return ids


def _compiled(spec: mujoco.MjSpec, scene: Scene, airframes: Sequence[Airframe]) -> mujoco.MjModel:
    try:
        return spec.compile()
    except ValueError as error:
        reason = " ".join(str(error).split()).removeprefix("Error: ")
        who = f" with vehicle {airframes[0].name!r}" if airframes else ""
        raise WorldError(
            f"scene {scene.scene_id!r}{who} cannot be built: {reason}; "
            "valid: files of shapes that MuJoCo reads"
        ) from None


def new_spec(scene: Scene, physics_hz: int) -> mujoco.MjSpec:
    """Create an empty world with the solver's settings, light and sky.

    Args:
        scene: Scene, for its name, light and sky.
        physics_hz: Steps per second.
    """
    spec = mujoco.MjSpec()
    spec.modelname = scene.scene_id
    spec.option.timestep = 1.0 / physics_hz
    spec.option.gravity = (0.0, 0.0, -GRAVITY_MPS2)
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    set_view(spec, scene)
    return spec


def _put_movers(model: mujoco.MjModel, obstacles: Sequence[MovingObstacle]) -> None:
    """Place the movers at their poses at time zero."""
    if obstacles:
        is_mover = model.body_mocapid >= 0
        model.body_pos[is_mover], model.body_quat[is_mover] = start_poses(obstacles)


def _enable_sleep(model: mujoco.MjModel) -> None:
    """Skip the kinematics of geoms that never move; the vehicle itself never sleeps.

    The flight is bit-identical to one without sleeping, and a step twice as fast with 600 geoms.
    """
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP
    model.tree_sleep_policy[:] = mujoco.mjtSleepPolicy.mjSLEEP_NEVER


def _describe(scene: Scene, object_id: int) -> str:
    if object_id == GROUND_ID:
        return GROUND_NAME
    if object_id == NEIGHBOUR_ID:
        return NEIGHBOUR_NAME
    if object_id <= FIRST_MOVER_ID:
        return f"moving obstacle {FIRST_MOVER_ID - object_id}"
    category = next((o.category for o in scene.objects if o.id == object_id), "unknown")
    return f"object {object_id} ({category})"
