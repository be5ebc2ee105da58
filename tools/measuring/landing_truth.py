"""True landing ground of a vehicle, by vertical rays onto the solids of the physics.

The pilot's own map is not asked: a fault in its judgement would confirm itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from autonomy.perception import LandingNeeds
from flightsim.cameras.raycast_mesh import geom_triangles
from flightsim.looks.geom_groups import GeomGroup
from flightsim.looks.rays import RayScene
from flightsim.world import World

_SPACING_M = 0.03  # between two rays


@dataclass(frozen=True, kw_only=True, eq=False)
class TrueGround:
    """True ground under a vehicle at n places."""

    slope_rad: Float[np.ndarray, " n"]
    """Slope of the least-squares plane under the feet."""
    roughness_m: Float[np.ndarray, " n"]
    """Height range about that plane."""
    rise_m: Float[np.ndarray, " n"]
    """Greatest rise above that plane under the whole vehicle, including overhangs below the start
    of the rays."""
    is_safe: Bool[np.ndarray, " n"]


class ExactGround:
    """Solids of a world, probed from above; all of them as triangles."""

    def __init__(self, world: World) -> None:
        model, data = world.model, world.new_data()
        parts = [
            geom_triangles(model, g) @ data.geom_xmat[g].reshape(3, 3).T + data.geom_xpos[g]
            for g in np.flatnonzero(model.geom_group == GeomGroup.SCENE).tolist()
        ]
        self._rays = RayScene(np.concatenate(parts))

    def judge(
        self, places_enu_m: Float[np.ndarray, "n 2"], from_m: float, needs: LandingNeeds
    ) -> TrueGround:
        """Judge places for a vehicle's centre.

        Args:
            places_enu_m: Horizontal positions, n x 2.
            from_m: Height at which the rays start; what hangs above it is not seen.
            needs: Needs of the vehicle, with or without margin.
        """
        offsets = _disc(needs.body_radius_m)
        points = (places_enu_m[:, None] + offsets).reshape(-1, 2)
        eyes = np.column_stack([points, np.full(len(points), from_m)])
        down = np.broadcast_to(np.array([0.0, 0.0, -1.0]), eyes.shape)
        height = from_m - self._rays.first_hits(eyes, down).distance.astype(float)
        height = height.reshape(len(places_enu_m), len(offsets))
        # Feet may end up anywhere in the circle, because the heading at touchdown is free.
        is_foot = np.hypot(*offsets.T) <= needs.footprint_radius_m
        design = np.column_stack([np.ones(len(offsets)), offsets])
        # One pseudo-inverse serves all places: the rays lie alike about each.
        plane = np.linalg.pinv(design[is_foot]) @ height[:, is_foot].T
        above = height - (design @ plane).T
        slope = np.arctan(np.hypot(plane[1], plane[2]))
        roughness = np.ptp(above[:, is_foot], axis=1)
        rise = above.max(axis=1)
        return TrueGround(
            slope_rad=slope,
            roughness_m=roughness,
            rise_m=rise,
            is_safe=(slope <= needs.max_slope_rad)
            & (roughness <= needs.max_roughness_m)
            & (rise <= needs.max_rise_m),
        )


def _disc(radius_m: float) -> Float[np.ndarray, "k 2"]:
    reach = int(radius_m / _SPACING_M)
    axis = _SPACING_M * np.arange(-reach, reach + 1)
    grid = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    return grid[np.hypot(*grid.T) <= radius_m]
