"""Paths through openings that are hardly wider than the vehicle.

The middle of a door may be half a cell away from the nearest cell of a field. A door may then be
wide enough although no cell in it has enough room. Finer cells everywhere would cost too much. So
if a search ends there, the opening is measured exactly, and the path goes through its middle.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from jaxtyping import Float, Int

from autonomy.pages import copy_touched
from autonomy.planning.errors import UnreachableError
from autonomy.planning.field import DistanceField
from autonomy.planning.obstacles import Obstacles
from autonomy.planning.openings import Opening, opening_at
from autonomy.types import Vector3

BEFORE_M = (0.5, 0.75, 1.0, 1.25)
"""Distances before and behind an opening at which the line through it may begin and end."""
MOST_OPENINGS = 4
"""Greatest number of such openings on one path."""
_STEP_M = 0.05
_TUBE_CELLS = 0.9
"""Radius in cells of a tube about a line; its cells join the line's ends without a gap."""

Search = Callable[[DistanceField], Int[np.ndarray, "n 3"]]


def path_through_openings(
    search: Search, field: DistanceField, obstacles: Obstacles, needed_m: float
) -> Float[np.ndarray, "n 3"]:
    """Find a path: centres of cells, and the axes of openings in which no cell has enough room.

    Args:
        search: Search through a field, for example `shortest_path` with its other arguments bound.
        field: Distances to the obstacles.
        obstacles: Exact obstacles of the same space.
        needed_m: Distance to obstacles that the vehicle needs in an opening.

    Raises:
        UnreachableError: If there is no such path either.
    """
    axes: list[Float[np.ndarray, "3 3"]] = []
    for _ in range(MOST_OPENINGS + 1):
        try:
            path = search(field)
        except UnreachableError as error:
            place = error.narrowest_enu_m
            opening = None if place is None else opening_at(place, obstacles)
            if place is None or opening is None:
                raise
            axis = _axis(opening, place, obstacles, needed_m)
            # The same opening again means that widening it did not help.
            if axis is None or any(np.allclose(axis, other) for other in axes):
                raise _named(error, opening, needed_m) from None
            axes.append(axis)
            field = _widened(field, axis, needed_m)
        else:
            return _along_axes(field.centres(path), axes, field.resolution_m)
    raise UnreachableError(
        f"the way leads through more than {MOST_OPENINGS} openings that are hardly wide enough; "
        "valid: a nearer goal"
    )


def _named(error: UnreachableError, opening: Opening, needed_m: float) -> UnreachableError:
    """Return the error with the measures of the opening that the path would lead through."""
    what, valid = str(error).rsplit("; valid: ", 1)
    return UnreachableError(
        f"{what}: the opening there is {opening.width_m:.2f} m wide and {opening.height_m:.2f} m "
        f"high, the vehicle needs {2 * needed_m:.2f} m; valid: {valid}",
        error.narrowest_enu_m,
    )


def _axis(
    opening: Opening, place: Vector3, obstacles: Obstacles, needed_m: float
) -> Float[np.ndarray, "3 3"] | None:
    """Line through an opening; None if it is not wide enough or no cell leads there."""
    if not opening.fits(needed_m):
        return None
    through = np.array([np.cos(opening.normal_rad), np.sin(opening.normal_rad), 0.0])
    center = _lowered(opening, place, needed_m)
    ends = [_end(center, side * through, obstacles, needed_m) for side in (-1, 1)]
    if ends[0] is None or ends[1] is None:
        return None
    return np.array([ends[0], center, ends[1]])


def _lowered(opening: Opening, near: Vector3, needed_m: float) -> Float[np.ndarray, " 3"]:
    """Middle between the sides of an opening, at the height nearest to a point."""
    x, y, z = opening.center_enu_m
    play_m = opening.height_m / 2 - 1.5 * needed_m
    return np.array([x, y, np.clip(near[2], z - play_m, z + play_m) if play_m > 0 else z])


def _end(
    center: np.ndarray, way: np.ndarray, obstacles: Obstacles, needed_m: float
) -> Float[np.ndarray, " 3"] | None:
    """Beginning of the line into an opening on one side; None if it is not free."""
    along_m = np.arange(0.0, BEFORE_M[-1] + _STEP_M, _STEP_M)
    room_m = obstacles.signed_distance(center + np.outer(along_m, way))[0]
    if np.any(room_m[along_m <= BEFORE_M[0]] < needed_m):
        return None
    candidates = [before_m for before_m in BEFORE_M if room_m[along_m <= before_m].min() > needed_m]
    widest = max(candidates, default=BEFORE_M[0], key=lambda at: room_m[round(at / _STEP_M)])
    return center + widest * way


def _widened(
    field: DistanceField, axis: Float[np.ndarray, "3 3"], needed_m: float
) -> DistanceField:
    """Return the field in which the cells about a line have at least the needed distance."""
    length_m = float(np.linalg.norm(axis[2] - axis[0]))
    share = np.linspace(0.0, 1.0, round(length_m / _STEP_M) + 1)[:, None]
    line = axis[0] + share * (axis[2] - axis[0])
    around = np.array([-1, 0, 1])
    block = np.stack(np.meshgrid(around, around, around), axis=-1).reshape(-1, 3)
    cells = np.unique((field.cells(line)[:, None] + block).reshape(-1, 3), axis=0)
    cells = cells[np.all((cells >= 0) & (cells < field.distance_m.shape), axis=1)]
    away = np.linalg.norm(field.centres(cells)[:, None] - line, axis=2).min(axis=1)
    near = cells[away <= _TUBE_CELLS * field.resolution_m]
    # A copy: the caller's field must stay true.
    distance_m = copy_touched(field.distance_m)
    index = tuple(near.T)
    distance_m[index] = np.maximum(distance_m[index], needed_m)
    return dataclasses.replace(field, distance_m=distance_m)


def _along_axes(
    points: Float[np.ndarray, "n 3"], axes: list[Float[np.ndarray, "3 3"]], resolution_m: float
) -> Float[np.ndarray, "m 3"]:
    """Return the path with the points about each axis that it follows replaced by that axis."""
    for axis in axes:
        away = np.linalg.norm(points - axis[1], axis=1)
        to_ends = np.linalg.norm(points[:, None] - axis[None, (0, 2)], axis=2)
        if away.min() > 2 * resolution_m:
            continue
        middle = int(np.argmin(away))
        is_forward = to_ends[: middle + 1, 0].min() <= to_ends[: middle + 1, 1].min()
        first, last = (0, 1) if is_forward else (1, 0)
        enter = int(np.argmin(to_ends[: middle + 1, first]))
        leave = middle + int(np.argmin(to_ends[middle:, last]))
        through = axis if is_forward else axis[::-1]
        points = np.concatenate([points[:enter], through, points[leave + 1 :]])
    return points
