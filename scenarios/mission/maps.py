"""Maps with which a flight may begin: the whole scene, or only the air above the start.

Both kinds answer the same questions (`autonomy.mapping`), so a pilot plans in either in the same
way. A large scene gets a coarse map of everything and fine cells only along searched paths.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aeroscene.scene import Scene
from aeroscene.solids.field_cache import cached_distance_field, cached_wide_field
from aeroscene.solids.freespace import reachable, start_cell
from aeroscene.solids.shapes import Primitive, scene_primitives
from aeroscene.solids.wide_field import is_wide
from autonomy.mapping import GivenMap, SeenMap, SeenMapCfg, WideMap
from flightsim.vehicles.airframe import Airframe
from scenarios.mission.obstacles import distance_field, scene_obstacles

_COARSE_CELLS = 4
"""Edge of a coarse cell of a large scene, in fine cells."""


def given_map(scene: Scene, radius_m: float, resolution_m: float) -> GivenMap | WideMap:
    """Build the map of a scene that is given before the flight.

    In a large scene only the distances that plans ask for are computed, because its whole field
    would take gigabytes.

    Args:
        scene: Scene to fly in.
        radius_m: Radius of the vehicle's sphere.
        resolution_m: Resolution of the distance field.

    Raises:
        NoFreeSpaceError: If the vehicle cannot leave the start.
    """
    primitives = scene_primitives(scene)
    if is_wide(scene, resolution_m):
        return _wide_map(scene, radius_m, resolution_m, primitives)
    voxels = cached_distance_field(scene, resolution_m, primitives)
    return GivenMap(
        obstacles=scene_obstacles(scene, primitives),
        field=distance_field(voxels),
        is_reachable=reachable(voxels, scene.start_position_enu_m, radius_m),
    )


def _wide_map(
    scene: Scene, radius_m: float, resolution_m: float, primitives: Sequence[Primitive]
) -> WideMap:
    wide = cached_wide_field(scene, resolution_m, primitives)
    wide.build_about(np.array([scene.start_position_enu_m]), 0.0)
    # Only for its error: the cell must have room for the vehicle.
    start_cell(wide.field, scene.start_position_enu_m, radius_m)
    coarse = cached_distance_field(scene, _COARSE_CELLS * resolution_m, primitives)
    return WideMap(
        obstacles=scene_obstacles(scene, primitives),
        field=distance_field(wide.field),
        coarse=distance_field(coarse),
        radius_m=radius_m,
        build=wide.build_about,
    )


def unseen_map(scene: Scene, airframe: Airframe, resolution_m: float) -> SeenMap:
    """Build an empty map of a flight volume, with free air above the start.

    It grows with the images of the forward camera that it is given.
    """
    camera = next(mount for mount in airframe.cameras if mount.name == "forward")
    cfg = SeenMapCfg(
        resolution_m=resolution_m,
        camera_pitch_down_rad=camera.pitch_down_rad,
        camera_vertical_fov_rad=camera.vertical_fov_rad,
    )
    growing = SeenMap(scene.extent_min_enu_m, scene.extent_max_enu_m, cfg)
    growing.assume_free_column(scene.start_position_enu_m)
    return growing
