"""Doors, windows and other openings in walls, found from free space alone.

The planner must know exactly how wide a door is, and a map from depth has no list of doors. An
opening is a place where free space narrows: across it solids stand close on both sides and above,
and a step before and a step behind it space is wider and higher. Cells of a distance field find the
place, because they are quick to scan. The obstacles themselves then give the width and height,
because cells are too coarse for that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from autonomy.jit import kernel
from autonomy.planning.field import DistanceField
from autonomy.planning.obstacles import Obstacles
from autonomy.planning.solids import Solids, nearest_solid
from autonomy.types import Vector3

MAX_WIDTH_M = 3.5
LEAST_WIDTH_M, LEAST_HEIGHT_M = 0.5, 0.8
"""Least width and height of an opening; smaller ones are mere gaps between objects."""
_N_DIRECTIONS = 12  # over half a turn, 15 degrees apart
_WIDER_M = 0.5
"""Excess of the width before and behind an opening."""
_LINTEL_M = 0.2  # a wall above the opening, at least this high
_STEPS_M = (0.5, 0.75, 1.0, 1.25)
"""Distances before and behind an opening at which its width is compared."""
_MAX_RUN_M = 6.0  # from there on a side counts as open
# Places along the passage, beside a point, and turns of the direction that are tried for the
# narrowest.
_OFFSETS_M: Float[np.ndarray, " n"] = np.linspace(-0.4, 0.4, 17)
_BESIDE_M = np.linspace(-0.25, 0.25, 5)
_UP = np.array([0.0, 0.0, 1.0])
_TURNS_RAD: Float[np.ndarray, " n"] = np.radians(np.linspace(-12.0, 12.0, 7))
_REFINEMENTS_RAD: Float[np.ndarray, " n"] = np.radians(np.linspace(-3.0, 3.0, 13))
_TOUCH_M = 0.005  # distance at which a march counts as having met a solid
_MARCH_STEPS = 60


@dataclass(frozen=True, kw_only=True, slots=True)
class Opening:
    """Opening such as a door, a window or a hatch."""

    center_enu_m: Vector3
    normal_rad: float
    """Direction of the passage through the opening, counter-clockwise from east; the opposite one
    is as good."""
    width_m: float
    height_m: float

    def fits(self, radius_m: float, margin_m: float = 0.0) -> bool:
        """Return whether a ball can pass with a margin on either side."""
        return min(self.width_m, self.height_m) > 2 * (radius_m + margin_m)


def find_openings(field: DistanceField, obstacles: Obstacles) -> list[Opening]:
    """Find every opening in something upright, the widest first.

    Args:
        field: Free space; its cells find openings that are wider than about two of them.
        obstacles: Exact obstacles of the same space, for the measures.
    """
    from scipy import ndimage

    is_free = np.ascontiguousarray(field.distance_m > 0)
    direction = narrow_cells(is_free, field.resolution_m)
    found: list[Opening] = []
    labelled: Any = ndimage.label(direction >= 0, np.ones((3, 3, 3)))
    labels, count = labelled
    for box, label in zip(ndimage.find_objects(labels, count), range(1, count + 1), strict=True):
        members = np.argwhere(labels[box] == label) + [part.start for part in box]
        opening = _measured(members, direction, field, obstacles)
        if opening is not None and not any(_is_same(opening, other) for other in found):
            found.append(opening)
    return sorted(found, key=lambda opening: -opening.width_m)


def _is_same(one: Opening, other: Opening) -> bool:
    return math.dist(one.center_enu_m, other.center_enu_m) < max(one.width_m, other.width_m) / 2


def _measured(
    members: Int[np.ndarray, "n 3"],
    direction: Int[np.ndarray, "nx ny nz"],
    field: DistanceField,
    obstacles: Obstacles,
) -> Opening | None:
    """Measure the opening of some cells; None if the obstacles leave too little."""
    middle = members[np.argmin(np.linalg.norm(members - members.mean(axis=0), axis=1))]
    across_rad = math.pi * float(direction[tuple(middle)]) / _N_DIRECTIONS
    return _measured_about(field.centres(middle), across_rad, obstacles)


def opening_at(point_enu_m: Vector3, obstacles: Obstacles) -> Opening | None:
    """Find the opening at, or just beside, a free point, from the obstacles alone.

    Returns:
        The opening, or None if there is none.
    """
    angles: Float[np.ndarray, " n"] = np.pi * np.arange(_N_DIRECTIONS) / _N_DIRECTIONS
    angles = np.repeat(angles, len(_BESIDE_M))
    through = np.column_stack([-np.sin(angles), np.cos(angles), np.zeros(len(angles))])
    points = np.array(point_enu_m) + np.tile(_BESIDE_M, _N_DIRECTIONS)[:, None] * through
    # A point within an obstacle is in no opening.
    is_free = obstacles.signed_distance(points)[0] > _TOUCH_M
    if not is_free.any():
        return None
    best = _narrowest(points[is_free], angles[is_free], obstacles)
    return _measured_about(points[is_free][best], float(angles[is_free][best]), obstacles)


def _measured_about(
    center: Float[np.ndarray, " 3"], across_rad: float, obstacles: Obstacles
) -> Opening | None:
    """Measure the opening near a point, given the approximate direction across it."""
    # Walls are thinner than cells: look for the narrowest place along the passage.
    turns = across_rad + np.repeat(_TURNS_RAD, len(_OFFSETS_M))
    along = np.tile(np.outer(_OFFSETS_M, _level(across_rad + math.pi / 2)), (len(_TURNS_RAD), 1))
    best = _narrowest(center + along, turns, obstacles)
    center, across_rad = center + along[best], float(turns[best])
    turns = across_rad + _REFINEMENTS_RAD
    across_rad = float(turns[_narrowest(np.tile(center, (len(turns), 1)), turns, obstacles)])
    level = _level(across_rad)
    # Height first: the width is measured at mid-height.
    center, height_m = _centred(center, _UP, obstacles)
    center, width_m = _centred(center, level, obstacles)
    if not (LEAST_WIDTH_M <= width_m <= MAX_WIDTH_M and height_m >= LEAST_HEIGHT_M):
        return None
    if not all(_is_wider(center, level, side, width_m, height_m, obstacles) for side in (1, -1)):
        return None
    x, y, z = center.tolist()
    return Opening(
        center_enu_m=(x, y, z),
        normal_rad=math.remainder(across_rad + math.pi / 2, math.tau),
        width_m=width_m,
        height_m=height_m,
    )


def _level(angle_rad: float) -> Float[np.ndarray, " 3"]:
    return np.array([math.cos(angle_rad), math.sin(angle_rad), 0.0])


def _centred(
    center: Float[np.ndarray, " 3"], way: Float[np.ndarray, " 3"], obstacles: Obstacles
) -> tuple[Float[np.ndarray, " 3"], float]:
    """Middle between the obstacles on both sides along a direction, and their distance."""
    low, high = _reach(np.tile(center, (2, 1)), np.array([-way, way]), obstacles).tolist()
    return center + (high - low) / 2 * way, low + high


def _is_wider(
    center: np.ndarray,
    level: np.ndarray,
    side: int,
    width_m: float,
    height_m: float,
    obstacles: Obstacles,
) -> bool:
    """Return whether space is wider and higher somewhere on a side of an opening.

    Half of the excess that cells must show is enough here.
    """
    through = side * np.cross(level, _UP)
    points = center + np.outer(_STEPS_M, through)
    steps = len(points)
    ways = np.repeat([level, -level, _UP], steps, axis=0)
    left, right, up = _reach(np.tile(points, (3, 1)), ways, obstacles).reshape(3, steps)
    is_higher = up >= height_m / 2 + _LINTEL_M / 2
    return bool(np.any(is_higher & (left + right >= width_m + _WIDER_M / 2)))


def _narrowest(
    points_enu_m: Float[np.ndarray, "n 3"], angle: Float[np.ndarray, " n"], obstacles: Obstacles
) -> int:
    """Index of the point with the least width; the middle one of several equals."""
    ways = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))])
    width_m = _reach(points_enu_m, ways, obstacles) + _reach(points_enu_m, -ways, obstacles)
    least = np.flatnonzero(width_m < width_m.min() + 2 * _TOUCH_M)
    return int(least[len(least) // 2])


def _reach(
    points_enu_m: Float[np.ndarray, "n 3"], ways: Float[np.ndarray, "n 3"], obstacles: Obstacles
) -> Float[np.ndarray, " n"]:
    """Distance from points to obstacles along unit vectors, by sphere tracing."""
    points = np.ascontiguousarray(points_enu_m, dtype=float)
    return reach_solids(points, np.ascontiguousarray(ways, dtype=float), obstacles.solids)


@kernel
def reach_solids(
    points: Float[np.ndarray, "n 3"], ways: Float[np.ndarray, "n 3"], solids: Solids
) -> Float[np.ndarray, " n"]:
    """Distance from points to solids along unit vectors; see `_reach`."""
    reach = np.zeros(len(points))
    for n in range(len(points)):
        for _ in range(_MARCH_STEPS):
            x = points[n, 0] + reach[n] * ways[n, 0]
            y = points[n, 1] + reach[n] * ways[n, 1]
            z = points[n, 2] + reach[n] * ways[n, 2]
            gap = nearest_solid(x, y, z, solids)[0]
            # This order of the comparison also ends the march at NaN.
            if not (gap >= _TOUCH_M and reach[n] <= _MAX_RUN_M):
                break
            reach[n] += gap
    return reach


@kernel
def narrow_cells(
    is_free: Bool[np.ndarray, "nx ny nz"], resolution: float
) -> Int[np.ndarray, "nx ny nz"]:
    """Mark cells in the middle of openings by the number of the direction across, others by -1.

    Args:
        is_free: True for cells without a solid.
        resolution: Size of a cell, m.
    """
    nx, ny, nz = is_free.shape
    number = np.full((nx, ny, nz), -1, dtype=np.int8)
    most = 0.5 * MAX_WIDTH_M / resolution
    reach = math.ceil(most) + 1
    # Height of the nearest solid above each column, kept while layers are visited from the top.
    roof = np.full((nx, ny), nz)
    for k in range(nz - 1, -1, -1):
        for i in range(nx):
            for j in range(ny):
                if not is_free[i, j, k]:
                    roof[i, j] = k
        sums = _solid_sums(is_free, k)
        for i in range(nx):
            for j in range(ny):
                # As `_run` counts, which stops half a cell before what is not free.
                up = roof[i, j] - k - 0.5
                if not is_free[i, j, k] or up * resolution >= _MAX_RUN_M:
                    continue
                if _has_room(sums, i, j, reach):
                    continue
                number[i, j, k] = _narrow_direction(is_free, i, j, k, up, most, resolution)
    return number


@kernel
def _solid_sums(is_free: np.ndarray, k: int) -> np.ndarray:
    """Number of cells of a layer that are not free, summed up to each row and column.

    Differences of four sums then count any rectangle at once.
    """
    nx, ny, _ = is_free.shape
    sums = np.zeros((nx + 1, ny + 1), dtype=np.int64)
    for i in range(nx):
        row = 0
        for j in range(ny):
            row += not is_free[i, j, k]
            sums[i + 1, j + 1] = sums[i, j + 1] + row
    return sums


@kernel
def _has_room(sums: np.ndarray, i: int, j: int, reach: int) -> bool:
    """True if all cells of a layer about one exist and are free, so that nothing is narrow."""
    if i < reach or j < reach or i + reach + 2 > len(sums) or j + reach + 2 > sums.shape[1]:
        return False
    a, b, u, v = i - reach, j - reach, i + reach + 1, j + reach + 1
    return sums[u, v] - sums[a, v] - sums[u, b] + sums[a, b] == 0


@kernel
def _narrow_direction(
    is_free: np.ndarray, i: int, j: int, k: int, up: float, most: float, resolution: float
) -> int:
    narrowest, best = np.inf, -1
    for n in range(_N_DIRECTIONS):
        x, y = math.cos(math.pi * n / _N_DIRECTIONS), math.sin(math.pi * n / _N_DIRECTIONS)
        left = _run(is_free, i, j, k, -x, -y, 0.0, most)
        if left >= most or left >= narrowest:
            continue
        right = _run(is_free, i, j, k, x, y, 0.0, most)
        # More than a cell apart means that this cell is not in the middle.
        if right >= most or abs(left - right) > 1.0 or left + right >= narrowest:
            continue
        if _opens(is_free, i, j, k, x, y, left + right, up, resolution) and _opens(
            is_free, i, j, k, -x, -y, left + right, up, resolution
        ):
            narrowest, best = left + right, n
    return best


@kernel
def _opens(
    is_free: np.ndarray,
    i: int,
    j: int,
    k: int,
    x: float,
    y: float,
    width: float,
    up: float,
    resolution: float,
) -> bool:
    """Return whether space is wider and higher to the left of the direction across."""
    for step in _STEPS_M:
        n = step / resolution
        u, v = math.floor(i - n * y + 0.5), math.floor(j + n * x + 0.5)
        if not (0 <= u < is_free.shape[0] and 0 <= v < is_free.shape[1]) or not is_free[u, v, k]:
            return False
        if _run(is_free, u, v, k, 0.0, 0.0, 1.0, up + 9.0) < up + _LINTEL_M / resolution:
            continue
        wanted = width + _WIDER_M / resolution
        left = _run(is_free, u, v, k, -x, -y, 0.0, wanted)
        if left + _run(is_free, u, v, k, x, y, 0.0, wanted) >= wanted:
            return True
    return False


@kernel
def _run(
    is_free: np.ndarray, i: int, j: int, k: int, x: float, y: float, z: float, most: float
) -> float:
    """Number of free cells after a cell, up to one that is not free or the end of the grid."""
    gone = 0.5
    while gone < most:
        # Not round(), which alternates for halves.
        u, v = math.floor(i + gone * x + 0.5), math.floor(j + gone * y + 0.5)
        w = math.floor(k + gone * z + 0.5)
        if not (0 <= u < is_free.shape[0] and 0 <= v < is_free.shape[1] and w < is_free.shape[2]):
            return gone
        if not is_free[u, v, w]:
            return gone
        gone += 0.5
    return most
