"""Rows and grids of equal objects.

From each object and a few pitches to its neighbours a lattice is grown step by step. The one with
the most members wins, and the search goes on among the rest. Each step starts from the member that
was found last, so that small deviations do not add up.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Float, Int

from aeroscene.relations.parsing.fits import TOLERANCE_M, TOLERANCE_RAD
from aeroscene.relations.plane import Half, Place, Rectangle
from aeroscene.relations.relation import MAX_ROWS, Array

MIN_MEMBERS = 3
_FULL_SHARE = 0.6
"""Least share of the places of a row or grid that have a member."""
_SAME_M = 0.05
_SAME_SHARE = 0.1
"""Sizes are equal if they differ by less, in metres or as a share."""
_MAX_PITCHES = 3
"""Number of neighbours along an axis whose distance is tried as pitch."""


@dataclass(frozen=True, slots=True)
class Lattice:
    """A row or grid that was found."""

    members: tuple[int, ...]
    """Indices of the rectangles, in the order of the array's places."""
    array: Array
    middle: Place


def find_lattices(rectangles: Sequence[Rectangle]) -> list[Lattice]:
    """Find rows and grids of equal rectangles, the largest first.

    Each rectangle is in one at most.
    """
    found: list[Lattice] = []
    for alike in _alike(rectangles):
        # Members of a found row are removed, and the rest may hold another row.
        left = alike
        while len(left) >= MIN_MEMBERS:
            best = _largest([rectangles[index] for index in left])
            if best is None:
                break
            members = tuple(left[index] for index in best.members)
            found.append(Lattice(members, best.array, best.middle))
            left = [index for index in left if index not in members]
    return found


def _alike(rectangles: Sequence[Rectangle]) -> list[list[int]]:
    """Group rectangles by size and heading."""
    groups: list[list[int]] = []
    for index, rectangle in enumerate(rectangles):
        for group in groups:
            first = rectangles[group[0]]
            turn_rad = first.place.local(rectangle.place)[2]
            if abs(_half_turned(turn_rad)) <= TOLERANCE_RAD and _is_same(
                first.half_m, rectangle.half_m
            ):
                group.append(index)
                break
        else:
            groups.append([index])
    return [group for group in groups if len(group) >= MIN_MEMBERS]


def _half_turned(turn_rad: float) -> float:
    """Return a turn without its half turns, because members of a row may look both ways."""
    return math.remainder(turn_rad, math.pi)


def _is_same(first_m: Half, second_m: Half) -> bool:
    pairs = zip(first_m, second_m, strict=True)
    return all(2 * abs(a - b) <= max(_SAME_M, 2 * _SAME_SHARE * a) for a, b in pairs)


def _largest(rectangles: Sequence[Rectangle]) -> Lattice | None:
    """Return the row or grid with the most members among equal rectangles."""
    origin, points, is_turned = _points(rectangles)
    best: dict[int, tuple[int, int]] = {}
    for start in range(len(points)):
        # A pitch of 0 along an axis makes a row instead of a grid.
        steps = [(*_pitches(points, start, axis), 0.0) for axis in (0, 1)]
        for pitch_m in product(*steps):
            cells = _grown(points, start, pitch_m) if any(pitch_m) else {}
            if len(cells) > len(best) and _is_full(cells):
                best = cells
    return _fitted(points, is_turned, best, origin) if len(best) >= MIN_MEMBERS else None


def _points(
    rectangles: Sequence[Rectangle],
) -> tuple[Place, Float[np.ndarray, "n 2"], list[bool]]:
    """Return a frame with the mean heading, the middles in it, and which of them look back."""
    turns = [rectangles[0].place.local(other.place)[2] for other in rectangles]
    mean_rad = float(np.mean([_half_turned(turn_rad) for turn_rad in turns]))
    origin = rectangles[0].place.moved(0.0, 0.0, mean_rad)
    points = np.array([origin.local(other.place)[:2] for other in rectangles])
    return origin, points, [abs(turn_rad) > math.pi / 2 for turn_rad in turns]


def _pitches(points: Float[np.ndarray, "n 2"], start: int, axis: int) -> list[float]:
    """Return the distances to the nearest rectangles ahead along an axis."""
    apart = points - points[start]
    ahead = apart[(np.abs(apart[:, 1 - axis]) <= TOLERANCE_M) & (apart[:, axis] > TOLERANCE_M)]
    return np.sort(ahead[:, axis])[:_MAX_PITCHES].tolist()


def _grown(
    points: Float[np.ndarray, "n 2"], start: int, pitch_m: tuple[float, ...]
) -> dict[int, tuple[int, int]]:
    """Return row and column of each point reached from one in steps, over one hole at most."""
    cells, taken, reached = {start: (0, 0)}, {(0, 0)}, [start]
    # A hop of two steps passes over one missing member.
    jumps = [(hop, 0) for hop in (1, -1, 2, -2)] + [(0, hop) for hop in (1, -1, 2, -2)]
    # The list grows while it is walked through.
    for index in reached:
        for jump in jumps:
            step_m = np.multiply(jump, pitch_m)
            cell = (cells[index][0] + jump[0], cells[index][1] + jump[1])
            if not step_m.any() or cell in taken:
                continue
            off_m = np.abs(points - points[index] - step_m).max(axis=1)
            nearest = int(off_m.argmin())
            if off_m[nearest] <= TOLERANCE_M and nearest not in cells:
                cells[nearest] = cell
                taken.add(cell)
                reached.append(nearest)
    return cells


def _is_full(cells: dict[int, tuple[int, int]]) -> bool:
    """True if the places are few enough and mostly have members."""
    rows, columns = np.ptp(list(cells.values()), axis=0) + 1
    return max(rows, columns) <= MAX_ROWS and len(cells) >= _FULL_SHARE * rows * columns


def _fitted(
    points: Float[np.ndarray, "n 2"],
    is_turned: Sequence[bool],
    cells: dict[int, tuple[int, int]],
    origin: Place,
) -> Lattice | None:
    """Fit the array through points by least squares; None if one is off its place."""
    order = sorted(cells, key=lambda index: cells[index])
    steps: Int[np.ndarray, "k 2"] = np.array([cells[index] for index in order])
    steps = steps - steps.min(axis=0)
    counts = steps.max(axis=0) + 1
    found = points[order]
    pitch_m, middle_m = np.zeros(2), found.mean(axis=0)
    for axis in (0, 1):
        at = steps[:, axis] - (counts[axis] - 1) / 2
        if counts[axis] > 1:
            pitch_m[axis], middle_m[axis] = np.polyfit(at, found[:, axis], 1)
    off_m = found - middle_m - (steps - (counts - 1) / 2) * pitch_m
    # Growing allows deviations that add up; the fitted lattice must hold for all.
    if np.abs(off_m).max() > TOLERANCE_M:
        return None
    rows, columns = counts.tolist()
    taken = {row * columns + column for row, column in steps.tolist()}
    array = Array(
        rows=rows,
        columns=columns,
        pitch_m=(float(pitch_m[0]), float(pitch_m[1])),
        holes=tuple(sorted(set(range(rows * columns)) - taken)),
        turned=tuple(place for place, index in enumerate(order) if is_turned[index]),
    )
    return Lattice(tuple(order), array, origin.moved(*middle_m.tolist()))
