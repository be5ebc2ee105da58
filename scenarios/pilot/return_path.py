"""Check whether the autopilot's own return, which knows no map, would meet anything."""

from __future__ import annotations

import math

import numpy as np

from autonomy.types import Vector3
from scenarios.mission.surroundings import Surroundings

_STEP_M = 0.5
_MARGIN_M = 0.3
"""Distance beyond the vehicle's sphere, because nothing guides it beside its straight lines."""


def is_return_path_free(world: Surroundings, here_enu_m: Vector3, home_enu_m: Vector3) -> bool:
    """Return whether all straight lines of a return are free, at whatever height it flies.

    A return rises, flies level to home and sinks. How far it rises is a parameter of the autopilot,
    so the whole upright plane above here and home must be free, up to the top of the scene.

    Args:
        world: Map of the place. Space that a growing map has not seen counts as blocked.
        here_enu_m: Position of the vehicle.
        home_enu_m: Point above the start, below which the vehicle may land.
    """
    (x, y, z), (x_home, y_home, z_home) = here_enu_m, home_enu_m
    top_m = max(world.scene.extent_max_enu_m[2], z, z_home)
    n_across = 1 + math.ceil(math.hypot(x_home - x, y_home - y) / _STEP_M)
    share = np.linspace(0.0, 1.0, n_across)
    heights = np.append(np.arange(min(z, z_home), top_m, _STEP_M), top_m)
    across, up = (axis.ravel() for axis in np.meshgrid(share, heights))
    points = np.column_stack([x + across * (x_home - x), y + across * (y_home - y), up])
    # A return never sinks before it is above home.
    points = points[(up >= z) | (across >= 1.0)]
    return bool(np.all(world.map.rough_distance_m(points) > world.radius_m + _MARGIN_M))
