"""Compiles every kernel by using it once, so that nothing compiles in a flight.

A cold kernel takes seconds. In a flight with real clients that is a pause in which they time out.
Calling the real code compiles for exactly the types that a flight uses, without a list of
signatures to maintain.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from aeroscene.sources import load_scene
from autonomy.jit import announce_if_cold
from autonomy.mapping import Agenda, SeenMap, SeenMapCfg, plan_towards
from autonomy.perception import MapAnchor, MapMatcher, MoverTracker, SurfaceMatcher
from autonomy.planning import Craft, FlightLimits, PlannerCfg
from autonomy.planning.obstacles import Obstacles
from autonomy.planning.openings import narrow_cells, opening_at
from autonomy.types import FlatReference
from flightsim.cameras.depth_noise import DEPTH_CAMERAS, measured_depth
from flightsim.cameras.image_batch import cast_images, example_arguments
from flightsim.looks.rays import RayScene
from flightsim.looks.sky import fill_sky
from flightsim.mavlink.client.telemetry import Telemetry
from flightsim.mavlink.streaming import compile_streaming
from flightsim.plant import compile_kernels
from flightsim.plant.rays import RAYS_DTYPE, cast_rays
from flightsim.vehicles.catalogue import airframe_by_name
from scenarios.mission.mission import Mission, plan_mission
from scenarios.mission.surroundings import MapSource
from scenarios.pilot.depth_frames import camera_mount, posed_image
from scenarios.pilot.landing_watch import CAMERA, LandingWatch

PILOT_MODULES = (
    "autonomy.perception.cell_distances",
    "autonomy.perception.depth_image",
    "autonomy.perception.elevation",
    "autonomy.perception.foreground",
    "autonomy.perception.point_spread",
    "autonomy.perception.rasterise",
    "autonomy.perception.registration",
    "autonomy.perception.solid_index",
    "autonomy.perception.windows",
    "autonomy.planning.clearance",
    "autonomy.planning.corridor",
    "autonomy.planning.feasibility",
    "autonomy.planning.search",
    "autonomy.planning.solids",
    "autonomy.planning.widest_path",
)
"""Modules with kernels that only our own pilot uses."""
EXPLORING_MODULES = (
    "autonomy.mapping.cell_states",
    "autonomy.mapping.distances",
    "autonomy.mapping.rays",
    "autonomy.mapping.renewal",
    "autonomy.mapping.views",
    "autonomy.perception.seen_surfaces",
    "autonomy.perception.surface_match",
)
"""Modules with kernels that only a flight with a growing map uses."""
FOLLOWING_MODULES = ("autonomy.perception.mover_track", "autonomy.perception.sighting")
"""Modules with kernels that only a flight among movers uses."""
SCENE = "42"
VEHICLE = "iris"


@dataclass(frozen=True, kw_only=True, eq=False)
class _Frame:
    """Frame of a camera in front of a plane."""

    depth_m: np.ndarray
    fx: float = 208.0
    fy: float = 208.0
    cx: float = 159.5
    cy: float = 119.5


def announce_pilot_kernels(
    map_source: MapSource = "truth", *, expects_traffic: bool = False
) -> None:
    """Announce it if our pilot's first flight is going to compile.

    Kernels for exploring and for following movers are compiled at once.

    Args:
        map_source: "truth" for a given map, "onboard" for one that grows.
        expects_traffic: True if the pilot follows movers.
    """
    announce_if_cold(PILOT_MODULES, "planning and perception kernels", 12.0)
    if map_source == "onboard":
        announce_if_cold(EXPLORING_MODULES, "mapping kernels", 12.0)
        explore_once()
    if expects_traffic:
        announce_if_cold(FOLLOWING_MODULES, "kernels for what moves", 4.0)
        follow_once()


def follow_once() -> None:
    """See something move before a wall, and then see that it is gone."""
    tracker, mount = MoverTracker(), camera_mount(airframe_by_name(VEHICLE), "forward")
    telemetry = Telemetry(position_enu_m=(0.0, 0.0, 2.0), quat_wxyz=(1.0, 0.0, 0.0, 0.0))
    wall_m = np.full((240, 320), 6.0, dtype=np.float32)
    shown_m = wall_m.copy()
    shown_m[80:160, 140:180] = 3.0
    # Twice to confirm and predict it, then the empty wall, which ends the track.
    for number, depth_m in enumerate((shown_m, shown_m, wall_m)):
        image = posed_image(_Frame(depth_m=depth_m), mount, telemetry)
        tracker.update(0.2 * number, image, lambda points: np.where(points[:, 0] < 4.0, 3.0, 0.0))


def explore_once() -> None:
    """Look about in a small place, so that nothing compiles while a map grows in flight."""
    airframe = airframe_by_name(VEHICLE)
    seen = SeenMap((-4.0, -4.0, 0.0), (12.0, 4.0, 8.0))
    seen.assume_free_column((0.0, 0.0, 0.0))
    telemetry = Telemetry(position_enu_m=(0.0, 0.0, 2.0), quat_wxyz=(1.0, 0.0, 0.0, 0.0))
    wall = _Frame(depth_m=np.full((240, 320), 6.0, dtype=np.float32))
    image = posed_image(wall, camera_mount(airframe, "forward"), telemetry)
    seen.observe(image)
    seen.observe(image)
    seen.be_at(telemetry.position_enu_m, airframe.collision_radius_m, sole_m=0.1)
    # A wide map searches in blocks, which large places alone need.
    wide = SeenMap((-4.0, -4.0, 0.0), (12.0, 4.0, 8.0), SeenMapCfg(most_whole_cells=1))
    wide.observe(image)
    here = wide.cells(np.array(telemetry.position_enu_m))
    wide.route_in(wide.search_block(here), airframe.collision_radius_m)
    anchor = MapAnchor(SurfaceMatcher((-4.0, -4.0, 0.0), (12.0, 4.0, 8.0)))
    anchor.stand_at(0.0, telemetry.position_enu_m, telemetry.position_enu_m)
    anchor.update(0.0, image)
    anchor.update(0.2, image)
    seen.distance_to_seen_m(np.array([telemetry.position_enu_m]))
    cfg = PlannerCfg(vehicle_radius_m=airframe.collision_radius_m)
    agenda = Agenda()
    # Ahead is free; above nothing was seen, so the planner seeks a viewpoint there.
    for height_m, goal_enu_m in ((2.0, (3.0, 0.0, 2.0)), (2.7, (0.0, 0.0, 6.5))):
        start = FlatReference(position_enu_m=(0.0, 0.0, height_m))
        craft = Craft(FlightLimits(), airframe.quadrotor, cfg)
        plan_towards(seen, agenda, start, goal_enu_m, craft)


def measure_once() -> None:
    """Use kernels that only some runs need: images, depth errors, openings, lidar."""
    flat_m = np.full((240, 320), 6.0, dtype=np.float32)
    measured_depth(flat_m, _Frame.fx, DEPTH_CAMERAS["d435"], np.random.default_rng(0))
    narrow_cells(np.ones((3, 3, 3), dtype=np.bool_), 0.2)
    opening_at((0.0, 0.0, 1.0), Obstacles.boxes(np.zeros((1, 3)), np.eye(1, 4), np.ones((1, 3))))
    cast_rays(np.zeros(1, RAYS_DTYPE), np.zeros((0, 6)), -1, np.zeros(0))
    RayScene(np.eye(3)[None]).is_hidden(np.zeros(3), np.ones((1, 3)))
    cast_images(*example_arguments())
    fill_sky(np.zeros((1, 1, 3), np.uint8), flat_m[:1, :1], np.eye(3), _Frame.fx)


def arrange_once() -> None:
    """Part two boxes in every way that generated scenes use, and flood free space.

    Nothing compiles then when a scene is made.
    """
    # Imported here: a flight imports this module, and makes no scene.
    from aeroscene.feasibility.least_change import least_change
    from aeroscene.feasibility.place_search import BLOCK, first_free, nearest_free
    from aeroscene.solids.flood import flooded

    least_change(np.eye(2), np.ones(2), np.ones(2), 1)
    box = np.array([(0.0, 0.0, 0.5, 0.5, 1.0, 0.0, 0.0, 1.0)], dtype=BLOCK)
    region = np.array([0.0, 0.0, 4.0, 4.0, 1.0, 0.0])
    nearest_free(box, box, region, np.array([-4.0, -4.0, 4.0, 4.0]), 4.0, 0.0)
    first_free(box, box, np.zeros((1, 2)))
    flooded(np.ones((2, 2, 2), dtype=np.float32), np.float32(0.5), 0, 0, 0)


def compile_everything(progress: Callable[[str, float], None]) -> None:
    """Compile everything that is not in the cache yet, and keep it there.

    Args:
        progress: Called with the present part and the share that is done, 0 to 1.
    """
    progress("flight kernels", 0.0)
    compile_kernels()
    compile_streaming()
    measure_once()
    progress("planning kernels", 0.35)
    mission = plan_mission(load_scene(SCENE), airframe_by_name(VEHICLE))
    mission.surroundings.brake(mission.trajectory, 0.0)
    progress("landing perception kernels", 0.6)
    _look_at_flat_ground(mission)
    follow_once()
    progress("mapping kernels", 0.8)
    explore_once()
    progress("scene kernels", 0.95)
    arrange_once()
    progress("done", 1.0)


def _look_at_flat_ground(mission: Mission) -> None:
    height_m = mission.hover_enu_m[2] - mission.area.centroid[2]
    depth_m = np.full((240, 320), height_m, dtype=np.float32)
    watch = LandingWatch(mission.surroundings, mission.area, mission.hover_enu_m)
    telemetry = Telemetry(position_enu_m=mission.hover_enu_m, quat_wxyz=(1.0, 0.0, 0.0, 0.0))
    mount = camera_mount(mission.surroundings.airframe, CAMERA)
    image = posed_image(_Frame(depth_m=depth_m), mount, telemetry)
    watch.fuse(0, image)
    MapAnchor(MapMatcher(mission.surroundings.obstacles)).update(0.0, image)
    site = watch.choose()
    if site is not None:
        watch.objection(site)
