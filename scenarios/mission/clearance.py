"""Clearance of a path that was flown."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from aeroscene.scene import Scene
from aeroscene.solids.shapes import scene_primitives
from flightsim.vehicles.airframe import Airframe
from scenarios.mission.obstacles import scene_obstacles
from scenarios.mission.surroundings import sphere_radius_m


def flown_clearance_m(
    scene: Scene, airframe: Airframe, positions_enu_m: Float[np.ndarray, "n 3"], away_m: float
) -> float | None:
    """Return the least distance between a vehicle's sphere and the scene along a path.

    Args:
        scene: Scene that was flown in.
        airframe: Vehicle that flew.
        positions_enu_m: Centres of the vehicle, in the order of time.
        away_m: Positions nearer to the first or the last one do not count, because take-off and
            landing must come near to a surface.

    Returns:
        The distance, or None if no position counts.
    """
    ends = positions_enu_m[[0, -1]] if len(positions_enu_m) else np.zeros((0, 3))
    from_ends = np.linalg.norm(positions_enu_m[:, None] - ends[None], axis=2)
    counted = positions_enu_m[(from_ends >= away_m).all(axis=1)]
    if not len(ends) or not len(counted):
        return None
    # The exact solids, not the map that the pilot had: the figure judges the flight by the truth.
    obstacles = scene_obstacles(scene, scene_primitives(scene))
    return float(obstacles.signed_distance(counted)[0].min()) - sphere_radius_m(airframe)
