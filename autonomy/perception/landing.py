"""Landing sites: slope, roughness and room on an elevation map, and the best site on it.

A cell is safe as the vehicle's centre under two conditions. Within the circle that holds its feet,
everything was observed in several frames that agree, the fitted plane is level enough and nothing
stands out of it or drops below it. Within the circle that holds the whole vehicle, nothing rises
above that plane into the rotors. An unseen cell counts as high as the lines of sight over it allow:
beyond the edge of a roof, where the roof itself hides the ground, that is below the roof; elsewhere
it is unbounded.

The part of a height that noise may explain does not count. Otherwise the extremes of noise among a
hundred cells would make every floor rough. So that nothing hides in the noise, heights that are too
uncertain make a place unsafe. Means over three by three cells, which have a third of the noise, are
judged beside the cells themselves. An object that is too small for both is seen on the way down.

The camera sees the ground beneath an eave or a branch that is itself out of view. Such an overhang
shows from above that place: look again there before descending, and on the way down.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float

from autonomy.perception.criteria import Ground, first_lack, is_safe
from autonomy.perception.elevation import ElevationMap
from autonomy.perception.needs import LandingNeeds
from autonomy.perception.windows import (
    clearance,
    disc,
    extremes,
    fit_planes,
    highest,
    moment_m2,
    smoothed,
)
from autonomy.types import Vector3

_SIGMAS = 2.5
"""Standard deviations of noise that are subtracted from the extremes under the feet."""
_SAME_SURFACE = 1.6
"""Limit of the difference of neighbouring heights, over the noise, for them to lie on one surface.
"""
_DISTANCE_PRICE = 0.1
"""Price in metres of room for each metre of distance from the preferred point."""


@dataclass(frozen=True, kw_only=True, slots=True)
class LandingSite:
    """Point to touch down on."""

    position_enu_m: Vector3
    """Position on the plane under the feet, in the frame of the estimate."""
    slope_rad: float
    roughness_m: float
    """Height range about the plane under the feet."""
    clearance_m: float
    """Distance to the nearest cell that is unsafe as a centre, or not allowed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LandingMap(Ground):
    """Layers of the ground, cell by cell; rows along north, columns along east."""

    surface_m: Float[np.ndarray, "n n"]
    """Height of the plane under the feet, ENU. It is NaN, as all layers that follow from it, unless
    everything under the feet was observed."""
    height_m: Float[np.ndarray, "n n"]
    """Height of the surface; meaningless if nothing was seen."""
    is_observed: Bool[np.ndarray, "n n"]
    is_safe: Bool[np.ndarray, "n n"]
    clearance_m: Float[np.ndarray, "n n"]
    """Distance to the nearest cell that is unsafe or not allowed; 0 in those."""
    enough_clearance_m: float
    """Clearance beyond which the cost stays the same."""
    axes_enu_m: tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]
    """East coordinates of the columns and north coordinates of the rows."""

    @cached_property
    def cells_enu_m(self) -> Float[np.ndarray, "m 3"]:
        """Observed cells as points, ENU."""
        east, north = self.axes_enu_m
        rows, columns = np.nonzero(self.is_observed)
        return np.column_stack([east[columns], north[rows], self.height_m[self.is_observed]])

    @cached_property
    def cost(self) -> Float[np.ndarray, " m"]:
        """Cost of each observed cell: 0 with much room, 1 if unsafe or not allowed."""
        room = self.clearance_m[self.is_observed]
        share = np.minimum(room / self.enough_clearance_m, 1.0)
        return np.where(room > 0, 0.5 * (1.0 - share), 1.0)


def assess(
    elevation: ElevationMap, needs: LandingNeeds, is_allowed: Bool[np.ndarray, "n n"] | None = None
) -> LandingMap:
    """Judge every cell of an elevation map as a place for the vehicle's centre.

    Args:
        elevation: Map of the ground.
        needs: Needs of the vehicle.
        is_allowed: True for cells on which landing is allowed; None for all.
    """
    observed = elevation.is_observed
    # Heights about their mean, so that single precision keeps every digit that matters.
    level = float(np.mean(elevation.height_m[observed], dtype=float)) if observed.any() else 0.0
    plane, ground = _ground(elevation, needs, level)
    safe = is_safe(ground, needs)
    usable = safe if is_allowed is None else safe & is_allowed
    return LandingMap(
        **vars(ground),
        surface_m=plane[0].astype(float) + level,
        height_m=elevation.height_m.copy(),
        is_observed=observed,
        is_safe=safe,
        clearance_m=clearance(usable, elevation.resolution_m),
        enough_clearance_m=needs.enough_clearance_m,
        axes_enu_m=elevation.cell_centres(),
    )


def _ground(
    elevation: ElevationMap, needs: LandingNeeds, level_m: float
) -> tuple[Float[np.ndarray, "3 n n"], Ground]:
    """Planes under the feet (height, rise to east and north) and each cell's surroundings."""
    step = elevation.resolution_m
    known = elevation.n_frames >= needs.min_frames
    foot = disc(needs.footprint_radius_m, step)
    height = np.where(known, elevation.height_m - level_m, np.float32(0))
    variance = np.where(known, elevation.variance_m2, np.float32(0))
    fit = fit_planes(height, variance, known, foot, step)
    plane, sigma = fit.plane, np.sqrt(fit.variance_m2)
    noise = np.float32(_SIGMAS) * np.sqrt(variance)
    # Over three by three cells the noise falls to a third, so smaller steps show.
    mean = smoothed(height, noise, known, _SAME_SURFACE)
    top = np.maximum(elevation.top_m - level_m - noise, mean - noise / 3)
    bottom = np.minimum(elevation.bottom_m - level_m + noise, mean + noise / 3)
    above, below = extremes(top, bottom, plane, foot, step)
    seen_noise = np.float32(_SIGMAS) * np.sqrt(elevation.variance_m2)
    ceiling = (
        elevation.ceiling_m - level_m - np.where(elevation.is_observed, seen_noise, np.float32(0))
    )
    return plane, Ground(
        slope_rad=np.arctan(np.hypot(plane[1], plane[2])),
        slope_sigma_rad=sigma / math.sqrt(moment_m2(foot, step)),
        # Zero times the plane carries its NaN into the roughness.
        roughness_m=np.maximum(above + below, 0.0) + 0.0 * plane[0],
        sigma_m=sigma,
        rise_m=highest(ceiling, plane, disc(needs.body_radius_m, step), step),
    )


def choose_site(
    landing: LandingMap, elevation: ElevationMap, needs: LandingNeeds, preferred_enu_m: Vector3
) -> LandingSite | None:
    """Choose the best site to touch down on; None if there is no safe one.

    The score is clearance up to `needs.enough_clearance_m`, less a small price of the distance from
    `preferred_enu_m`.
    """
    east, north = elevation.cell_centres()
    away = np.hypot(east[None, :] - preferred_enu_m[0], north[:, None] - preferred_enu_m[1])
    score = np.minimum(landing.clearance_m, needs.enough_clearance_m) - _DISTANCE_PRICE * away
    score = np.where(landing.clearance_m > 0, score, -np.inf)
    best = np.unravel_index(int(np.argmax(score)), score.shape)
    if score[best] == -np.inf:
        return None
    row, column = best
    return site_at(landing, elevation, (float(east[column]), float(north[row]), 0.0))


def site_at(
    landing: LandingMap, elevation: ElevationMap, place_enu_m: Vector3
) -> LandingSite | None:
    """Site at a position by the present map, safe or not; None if it was not observed."""
    cell = elevation.cell(*place_enu_m[:2])
    if not _is_known(landing, cell):
        return None
    return LandingSite(
        position_enu_m=(place_enu_m[0], place_enu_m[1], float(landing.surface_m[cell])),
        slope_rad=float(landing.slope_rad[cell]),
        roughness_m=float(landing.roughness_m[cell]),
        clearance_m=float(landing.clearance_m[cell]),
    )


def objection(
    landing: LandingMap, elevation: ElevationMap, needs: LandingNeeds, place_enu_m: Vector3
) -> str | None:
    """Reason why a position is not safe by the present map; None if it is safe.

    The reason is a sentence for the log, with the measured value and the limit.
    """
    cell = elevation.cell(*place_enu_m[:2])
    if not _is_known(landing, cell):
        return f"not all of the ground under the feet was observed in {needs.min_frames} frames"
    return first_lack(landing.at(cell), needs)


def _is_known(landing: LandingMap, cell: tuple[int, int]) -> bool:
    n = len(landing.surface_m)
    return all(0 <= i < n for i in cell) and bool(np.isfinite(landing.surface_m[cell]))
