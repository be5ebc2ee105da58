"""Where to land: slope, roughness and room on an elevation map, and the best place on it.

A cell is safe as the vehicle's centre when, within the circle that holds its feet, everything was
observed, the fitted plane is level enough and nothing stands out of it or drops below it, and when
within the circle that holds the whole vehicle nothing rises above that plane into the rotors. What
was not seen there counts as high as the lines of sight over it allow: beyond the edge of a roof,
where the roof itself hides the ground, that is below the roof; elsewhere it is anything.

The camera sees the ground beneath an eave or a branch that is itself out of view. What overhangs a
place shows from above that place: look again there before descending, and on the way down.

Over a fully observed disc the least-squares plane separates into three correlations: with one,
with x and with y.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from autonomy.jit import kernel
from autonomy.model.quadrotor import Vector3
from autonomy.perception.elevation import ElevationMap

_DISTANCE_PRICE = 0.1
"""Metres of room that a metre nearer to the preferred point is worth."""


@dataclass(frozen=True, kw_only=True, slots=True)
class LandingNeeds:
    """What a vehicle needs to stand safely."""

    footprint_radius_m: float
    """Of its feet, plus the scatter of a touchdown."""
    body_radius_m: float
    """Of all of it, plus the scatter of a touchdown."""
    max_slope_rad: float = math.radians(10.0)
    max_roughness_m: float = 0.04
    """Largest height range about the plane under the feet. With one foot so much higher a stance
    of 0.28 m tilts by 8 deg; 0.06 let it stand on kerbs of 0.05 m."""
    max_rise_m: float = 0.06
    """How far things within the body's radius may rise above the plane: below the rotors."""
    enough_clearance_m: float = 0.8
    """Room beyond this makes a place no better."""

    def __post_init__(self) -> None:
        """Refuse what no vehicle needs."""
        if not 0.0 < self.footprint_radius_m <= self.body_radius_m:
            raise ValueError(
                f"footprint_radius_m {self.footprint_radius_m} is not valid; valid: above 0, at "
                f"most body_radius_m {self.body_radius_m}"
            )
        if not 0.0 < self.max_slope_rad < math.pi / 2:
            raise ValueError(
                f"max_slope_rad {self.max_slope_rad} is not valid; valid: above 0, below pi/2"
            )


@dataclass(frozen=True, kw_only=True, slots=True)
class LandingSite:
    """A place to touch down."""

    position_enu_m: Vector3
    """On the plane under the feet, in the frame of the estimate."""
    normal_enu: Vector3
    """Of that plane, upwards."""
    slope_rad: float
    roughness_m: float
    """Height range about the plane under the feet."""
    clearance_m: float
    """Distance from here to the nearest place that is unsafe as a centre, or not allowed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LandingMap:
    """What is known about every cell; rows along north, columns along east."""

    surface_m: Float[np.ndarray, "n n"]
    """Height of the plane under the feet, ENU; NaN, like all that follows from it, where not all
    under the feet was observed."""
    gradient: Float[np.ndarray, "2 n n"]
    """Rise of the plane per metre to the east and to the north."""
    slope_rad: Float[np.ndarray, "n n"]
    roughness_m: Float[np.ndarray, "n n"]
    """Height range about the plane under the feet."""
    rise_m: Float[np.ndarray, "n n"]
    """How far anything within the body's radius may rise above the plane; inf: it is unknown."""
    is_observed: Bool[np.ndarray, "n n"]
    is_safe: Bool[np.ndarray, "n n"]
    clearance_m: Float[np.ndarray, "n n"]
    """Distance to the nearest cell that is unsafe or not allowed; 0 in those."""
    cells_enu_m: Float[np.ndarray, "m 3"]
    """The observed cells as points."""
    cost: Float[np.ndarray, " m"]
    """Of each of those, from 0 with much room to 1 where it is unsafe or not allowed."""


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
    observed = elevation.is_observed
    # Heights about their mean, so that single precision keeps every digit that matters.
    level = float(np.mean(elevation.height_m[observed])) if observed.any() else 0.0
    foot = _disc(needs.footprint_radius_m, elevation.resolution_m)
    height = np.where(observed, elevation.height_m - level, 0.0)
    plane = _fit_planes(height, foot, elevation.resolution_m)
    plane[:, ~_all_within(observed, foot)] = np.nan
    top = np.where(observed, elevation.top_m - level, np.inf)
    bottom = np.where(observed, elevation.bottom_m - level, -np.inf)
    step = elevation.resolution_m
    roughness = _highest(top, plane, foot, step) + _highest(-bottom, -plane, foot, step)
    body = _disc(needs.body_radius_m, elevation.resolution_m)
    rise = _highest(elevation.ceiling_m - level, plane, body, step)
    slope = np.arctan(np.hypot(plane[1], plane[2]))
    is_safe = (
        (slope <= needs.max_slope_rad)
        & (roughness <= needs.max_roughness_m)
        & (rise <= needs.max_rise_m)
    )
    clearance = _clearance(is_safe if is_allowed is None else is_safe & is_allowed, step)
    share = np.minimum(clearance / needs.enough_clearance_m, 1.0)
    cost = np.where(clearance > 0, 0.5 * (1.0 - share), 1.0)
    rows, columns = np.nonzero(observed)
    east, north = elevation.cell_centres()
    return LandingMap(
        surface_m=plane[0] + level,
        gradient=plane[1:],
        slope_rad=slope,
        roughness_m=roughness,
        rise_m=rise,
        is_observed=observed,
        is_safe=is_safe,
        clearance_m=clearance,
        cells_enu_m=np.column_stack([east[columns], north[rows], elevation.height_m[observed]]),
        cost=cost[observed],
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
    """What a map holds of a place by now, safe or not; None where its ground was not observed."""
    cell = elevation.cell(*place_enu_m[:2])
    if not _is_known(landing, cell):
        return None
    gradient_east, gradient_north = landing.gradient[(slice(None), *cell)].tolist()
    length = math.hypot(gradient_east, gradient_north, 1.0)
    return LandingSite(
        position_enu_m=(place_enu_m[0], place_enu_m[1], float(landing.surface_m[cell])),
        normal_enu=(-gradient_east / length, -gradient_north / length, 1.0 / length),
        slope_rad=float(landing.slope_rad[cell]),
        roughness_m=float(landing.roughness_m[cell]),
        clearance_m=float(landing.clearance_m[cell]),
    )


def objection(
    landing: LandingMap, elevation: ElevationMap, needs: LandingNeeds, place_enu_m: Vector3
) -> str | None:
    """Why a place is not safe, by what a map holds by now; None if it is safe."""
    cell = elevation.cell(*place_enu_m[:2])
    if not _is_known(landing, cell):
        return "not all of the ground under the feet was observed"
    slope, roughness, rise = (
        float(layer[cell]) for layer in (landing.slope_rad, landing.roughness_m, landing.rise_m)
    )
    if slope > needs.max_slope_rad:
        most = math.degrees(needs.max_slope_rad)
        return f"slope {math.degrees(slope):.1f} deg, at most {most:.1f} deg"
    if roughness > needs.max_roughness_m:
        return f"height range {roughness:.2f} m under the feet, at most {needs.max_roughness_m} m"
    if math.isinf(rise):
        return f"not everything within {needs.body_radius_m:.2f} m was observed"
    if rise > needs.max_rise_m:
        return f"something rises {rise:.2f} m beside the vehicle, at most {needs.max_rise_m} m"
    return None


def _is_known(landing: LandingMap, cell: tuple[int, int]) -> bool:
    n = len(landing.surface_m)
    return all(0 <= i < n for i in cell) and bool(np.isfinite(landing.surface_m[cell]))


def _disc(radius_m: float, resolution_m: float) -> Float[np.ndarray, "k k"]:
    """Window of cells, 1 where a cell is at least about half inside a circle, else 0."""
    reach = math.floor(radius_m / resolution_m + 0.5)
    offset = np.arange(-reach, reach + 1)
    return (np.hypot(*np.meshgrid(offset, offset)) <= radius_m / resolution_m + 0.5).astype(float)


def _all_within(mask: np.ndarray, window: np.ndarray) -> np.ndarray:
    """Cells whose whole window lies in a mask; beyond the border nothing does."""
    import cv2  # noqa: PLC0415 - loads only where something lands

    shape = window.astype(np.uint8)
    border = {"borderType": cv2.BORDER_CONSTANT, "borderValue": (0,)}
    return cv2.erode(mask.astype(np.uint8), shape, **border).astype(bool)


def _fit_planes(
    height: Float[np.ndarray, "n n"], window: Float[np.ndarray, "k k"], resolution_m: float
) -> Float[np.ndarray, "3 n n"]:
    """Least-squares plane in the window about each cell: height there, rise to east and north."""
    import cv2  # noqa: PLC0415 - loads only where something lands

    offset = (np.arange(len(window)) - len(window) // 2) * resolution_m
    east = window * offset
    moment = float(np.sum(east * offset)) or 1.0
    weights = (window / window.sum(), east / moment, east.T / moment)
    return np.stack([cv2.filter2D(height, -1, weight) for weight in weights])


def _highest(
    surface: Float[np.ndarray, "n n"],
    plane: Float[np.ndarray, "3 n n"],
    window: Float[np.ndarray, "k k"],
    resolution_m: float,
) -> Float[np.ndarray, "n n"]:
    """How far a surface rises above each cell's plane within the window; inf beyond the border."""
    reach = len(window) // 2
    padded = np.pad(surface.astype(np.float32), reach, constant_values=np.inf)
    height, east, north = plane.astype(np.float32)
    offsets = np.argwhere(window > 0) - reach
    return highest_above_planes(padded, height, east, north, offsets, reach, resolution_m)


@kernel
def highest_above_planes(
    surface: Float[np.ndarray, "m m"],
    height: Float[np.ndarray, "n n"],
    east: Float[np.ndarray, "n n"],
    north: Float[np.ndarray, "n n"],
    offsets: Int[np.ndarray, "k 2"],
    reach: int,
    resolution: float,
) -> Float[np.ndarray, "n n"]:
    """Largest surface minus plane over a window about each cell.

    Args:
        surface: Heights, `reach` cells wider than the grid on every side.
        height: Of each cell's plane over the cell.
        east: Rise of each cell's plane per metre to the east (columns).
        north: The same to the north (rows).
        offsets: Rows and columns of the window's cells from its middle.
        reach: The largest of them.
        resolution: Size of a cell, m.
    """
    n = len(height)
    highest = np.full((n, n), np.float32(-np.inf))
    for i in range(n):
        # Rows as arrays of their own: so the inner loop compiles to vector instructions.
        best, level, east_row, north_row = highest[i], height[i], east[i], north[i]
        for k in range(len(offsets)):
            x, y = np.float32(offsets[k, 1] * resolution), np.float32(offsets[k, 0] * resolution)
            right = offsets[k, 1] + reach
            row = surface[i + offsets[k, 0] + reach, right : right + n]
            for j in range(n):
                above = row[j] - (level[j] + x * east_row[j] + y * north_row[j])
                best[j] = max(above, best[j])
    return highest


def _clearance(is_usable: Bool[np.ndarray, "n n"], resolution_m: float) -> np.ndarray:
    """Distance to the nearest cell that is not usable; the map's border is one."""
    import cv2  # noqa: PLC0415 - loads only where something lands

    padded = np.pad(is_usable.astype(np.uint8), 1)
    return cv2.distanceTransform(padded, cv2.DIST_L2, 5)[1:-1, 1:-1] * resolution_m
