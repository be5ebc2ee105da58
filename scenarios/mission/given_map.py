"""Map of a scene that is given before the flight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aeroscene.scene import Scene
from aeroscene.solids.field_cache import kept_distance_field
from aeroscene.solids.freespace import reachable
from aeroscene.solids.shapes import scene_primitives
from autonomy.planning import DistanceField, Obstacles
from scenarios.mission.obstacles import distance_field, scene_obstacles


@dataclass(frozen=True, kw_only=True, eq=False)
class GivenMap:
    """Obstacles and free space of a scene, given before the flight."""

    obstacles: Obstacles
    field: DistanceField
    is_reachable: np.ndarray
    """Cells of the field that the vehicle can fly to from the start."""


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
