"""The maps of a scene that a flight may begin with: all of it, or nothing but the start."""

from __future__ import annotations

from aeroscene.scene import Scene
from aeroscene.solids.field_cache import kept_distance_field
from aeroscene.solids.freespace import reachable
from aeroscene.solids.shapes import scene_primitives
from autonomy.mapping import GivenMap, SeenMap, SeenMapCfg
from flightsim.vehicles.airframe import Airframe
from scenarios.mission.obstacles import distance_field, scene_obstacles


def given_map(scene: Scene, radius_m: float, resolution_m: float) -> GivenMap:
    """Obstacles and free space of a scene.

    Args:
        scene: Scene to fly in.
        radius_m: Radius of the vehicle's sphere.
        resolution_m: Resolution of the distance field.

    Raises:
        NoFreeSpaceError: If the vehicle cannot leave the start.
    """
    primitives = scene_primitives(scene)
    voxels = kept_distance_field(scene, resolution_m, primitives)
    return GivenMap(
        obstacles=scene_obstacles(scene, primitives),
        field=distance_field(voxels),
        is_reachable=reachable(voxels, scene.start_position_enu_m, radius_m),
    )


def unseen_map(scene: Scene, airframe: Airframe, resolution_m: float) -> SeenMap:
    """A map of a flight volume in which nothing was seen; the air above the start is free."""
    camera = next(mount for mount in airframe.cameras if mount.name == "forward")
    cfg = SeenMapCfg(
        resolution_m=resolution_m,
        camera_pitch_down_rad=camera.pitch_down_rad,
        camera_vertical_fov_rad=camera.vertical_fov_rad,
    )
    growing = SeenMap(scene.extent_min_enu_m, scene.extent_max_enu_m, cfg)
    growing.assume_free_column(scene.start_position_enu_m)
    return growing
