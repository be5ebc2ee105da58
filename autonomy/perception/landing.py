"""Where to land: slope, roughness and room on an elevation map, and the best place on it.

A cell is safe as the vehicle's centre when, within the square that holds its feet, everything was
observed, the fitted plane is level enough and nothing stands out of it, and when within the
circle that holds the whole vehicle nothing rises above the surface into the rotors. Beyond an
edge, cells that the surface itself hides from the camera cannot hold anything that rises above
it, so there it is enough that they were in view.

Over a fully observed square window the least-squares plane separates into two correlations, so
slope and residual come from four filters; the place that is chosen is then fitted once more,
point by point over the disc of its feet, and refused if it is worse than it looked.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from autonomy.model.quadrotor import Vector3
from autonomy.perception.elevation import ElevationMap

_ENOUGH_CLEARANCE_M = 0.8
"""Room beyond this makes a place no better."""
_DISTANCE_PRICE = 0.1
"""Metres of room that a metre nearer to the preferred point is worth."""
_MAX_CANDIDATES = 30


@dataclass(frozen=True, kw_only=True, slots=True)
class LandingNeeds:
    """What a vehicle needs to stand safely."""

    footprint_radius_m: float
    """Of its feet, plus the scatter of a touchdown."""
    body_radius_m: float
    """Of all of it, plus the scatter of a touchdown."""
    max_slope_rad: float = math.radians(10.0)
    max_roughness_m: float = 0.06
    """Largest height range about the plane under the feet."""
    max_rise_m: float = 0.06
    """How far things within the body's radius may rise above the surface: below the rotors."""


@dataclass(frozen=True, kw_only=True, slots=True)
class LandingSite:
    """A place to touch down."""

    position_enu_m: Vector3
    """On the surface, in the frame of the estimate."""
    slope_rad: float
    roughness_m: float
    """Height range about the plane under the feet."""
    clearance_m: float
    """Distance from here to the nearest place that is unsafe as a centre."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LandingMap:
    """What is known about every cell; rows along north, columns along east."""

    slope_rad: Float[np.ndarray, "n n"]
    roughness_m: Float[np.ndarray, "n n"]
    is_observed: Bool[np.ndarray, "n n"]
    is_safe: Bool[np.ndarray, "n n"]
    clearance_m: Float[np.ndarray, "n n"]
    """Distance to the nearest cell that is unsafe or not allowed."""
    cells_enu_m: Float[np.ndarray, "m 3"]
    """The observed cells as points."""
    cost: Float[np.ndarray, " m"]
    """Of each of those, from 0 with much room to 1 where it is unsafe."""


def assess(
    elevation: ElevationMap,
    needs: LandingNeeds,
    is_allowed: Bool[np.ndarray, "n n"] | None = None,
) -> LandingMap:
    """Judge every cell as a place for the vehicle's centre.

    Args:
        elevation: What was seen.
        needs: Of the vehicle.
        is_allowed: Cells that may be landed on; all of them if None.
    """
    import cv2  # noqa: PLC0415 - loads only where something lands

    resolution = elevation.resolution_m
    foot, body = (_square(r, resolution) for r in (needs.footprint_radius_m, needs.body_radius_m))
    slope, residual, spread = _fit_planes(elevation, foot)
    observed = elevation.is_observed
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (body, body))
    is_surveyed = _all_within(observed, np.ones((foot, foot), np.uint8))
    is_surveyed &= _all_within(elevation.is_in_view | observed, disc)
    # What was never seen rises nowhere here: the two lines above have dealt with it.
    top = np.where(observed, elevation.top_m, -np.inf).astype(np.float32)
    rise = cv2.dilate(top, disc) - elevation.height_m - np.tan(slope) * needs.body_radius_m
    roughness = np.maximum(spread, 4.0 * residual)
    is_safe = (
        is_surveyed
        & (slope <= needs.max_slope_rad)
        & (roughness <= needs.max_roughness_m)
        & (rise <= needs.max_rise_m)
    )
    allowed = is_safe if is_allowed is None else is_safe & is_allowed
    # The border of the map is the border of what is known.
    padded = cv2.copyMakeBorder(allowed.astype(np.uint8), 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    clearance = cv2.distanceTransform(padded, cv2.DIST_L2, 5)[1:-1, 1:-1] * resolution
    rows, columns = np.nonzero(observed)
    east, north = elevation.cell_centres()
    cost = np.where(is_safe, 0.5 * (1.0 - np.minimum(clearance / _ENOUGH_CLEARANCE_M, 1.0)), 1.0)
    return LandingMap(
        slope_rad=slope,
        roughness_m=roughness,
        is_observed=observed,
        is_safe=is_safe,
        clearance_m=clearance,
        cells_enu_m=np.column_stack([east[columns], north[rows], elevation.height_m[rows, columns]]),
        cost=cost[rows, columns],
    )


def choose_site(
    landing: LandingMap,
    elevation: ElevationMap,
    needs: LandingNeeds,
    preferred_enu_m: Vector3,
) -> LandingSite | None:
    """The best place to touch down, None if there is no safe one.

    Room counts up to a limit, closeness to the preferred point a little.
    """
    east, north = elevation.cell_centres()
    away = np.hypot(east[None, :] - preferred_enu_m[0], north[:, None] - preferred_enu_m[1])
    score = np.minimum(landing.clearance_m, _ENOUGH_CLEARANCE_M) - _DISTANCE_PRICE * away
    score = np.where(landing.clearance_m > 0, score, -np.inf)
    for _ in range(_MAX_CANDIDATES):
        row, column = np.unravel_index(int(np.argmax(score)), score.shape)
        if score[row, column] == -np.inf:
            return None
        height_m, slope, roughness = _fit_disc(elevation, row, column, needs.footprint_radius_m)
        if slope <= needs.max_slope_rad and roughness <= needs.max_roughness_m:
            return LandingSite(
                position_enu_m=(float(east[column]), float(north[row]), height_m),
                slope_rad=slope,
                roughness_m=roughness,
                clearance_m=float(landing.clearance_m[row, column]),
            )
        score[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2] = -np.inf
    return None


def _square(radius_m: float, resolution_m: float) -> int:
    """Odd side of the window of cells that holds a circle."""
    return 2 * math.ceil(radius_m / resolution_m) + 1


def _all_within(mask: np.ndarray, window: np.ndarray) -> np.ndarray:
    """Cells whose whole window lies in a mask; beyond the border nothing does."""
    import cv2  # noqa: PLC0415 - loads only where something lands

    inside = cv2.erode(
        mask.astype(np.uint8), window, borderType=cv2.BORDER_CONSTANT, borderValue=(0,)
    )
    return inside > 0


def _fit_planes(
    elevation: ElevationMap, side: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Slope, root mean square residual and height spread about the plane in a window per cell.

    Valid where the whole window was observed.
    """
    import cv2  # noqa: PLC0415 - loads only where something lands

    offset = (np.arange(side) - side // 2) * elevation.resolution_m
    ones = np.full(side, 1.0 / side)
    ramp = offset / (np.sum(offset**2) or 1.0)
    # Heights about their mean: squares of absolute heights would eat float32's digits.
    observed = elevation.is_observed
    level = float(np.mean(elevation.height_m[observed])) if observed.any() else 0.0
    height = np.where(observed, elevation.height_m - level, 0.0).astype(np.float64)
    mean = cv2.sepFilter2D(height, -1, ones, ones)
    square = cv2.sepFilter2D(height**2, -1, ones, ones)
    along_east = cv2.sepFilter2D(height, -1, ramp, ones)
    along_north = cv2.sepFilter2D(height, -1, ones, ramp)
    variance = float(np.mean(offset**2))
    explained = variance * (along_east**2 + along_north**2)
    residual = np.sqrt(np.maximum(square - mean**2 - explained, 0.0))
    window = np.ones((side, side), np.uint8)
    spread = cv2.dilate(elevation.top_m, window) - cv2.erode(elevation.bottom_m, window)
    of_plane = (np.abs(along_east) + np.abs(along_north)) * side * elevation.resolution_m
    return np.arctan(np.hypot(along_east, along_north)), residual, np.maximum(spread - of_plane, 0.0)


def _fit_disc(
    elevation: ElevationMap, row: int, column: int, radius_m: float
) -> tuple[float, float, float]:
    """Height at the centre, slope and height range about the plane of the cells in a disc."""
    reach = math.ceil(radius_m / elevation.resolution_m)
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1] * elevation.resolution_m
    inside = np.hypot(x, y) <= radius_m
    block = np.s_[row - reach : row + reach + 1, column - reach : column + reach + 1]
    z = elevation.height_m[block][inside].astype(float)
    design = np.column_stack([np.ones(len(z)), x[inside], y[inside]])
    (height, east, north), *_ = np.linalg.lstsq(design, z, rcond=None)
    residual = z - design @ [height, east, north]
    return float(height), math.atan(math.hypot(east, north)), float(np.ptp(residual))
