"""Height fields of MuJoCo's world from compiled code: heights, rays and distances.

A cell is two triangles with the common edge from its corner (row, column) to (row + 1, column + 1),
as in MuJoCo's contacts. A ray visits the cells below it one after another, so its cost grows with
its length. MuJoCo's own ray tests every triangle in the rectangle about the ray, which for a long
diagonal ray is most of the field.

    symbol   name
    x, y     place in cells from the field's first node along columns and rows
    z        height above the geom's origin, m
    f        height of a point of the ray above the surface, m

Source of the walk through the cells: Amanatides and Woo 1987, "A fast voxel traversal algorithm for
ray tracing".
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from autonomy.jit import kernel
from flightsim.plant.mujoco_calls import doubles, floats, integers

_NEVER = 1e300
"""Parameter of a crossing that does not happen; finite, because infinity times zero is not a
number."""


class _Field(NamedTuple):
    """A height field of the model, as views of MuJoCo's arrays."""

    heights: np.ndarray
    """Heights over the greatest one, 0 to 1, row by row."""
    n_rows: int
    n_columns: int
    size: np.ndarray
    """Half widths along columns and rows, greatest height and depth of the base (4,), m."""


@kernel
def ray_to_field_m(r: np.record, geom: int, ray: np.ndarray) -> float:
    """Return the distance to a height field along a ray, in lengths of its direction.

    Args:
        r: `flightsim.plant.rays.RAYS_DTYPE`.
        geom: Geom whose shape is a height field.
        ray: Origin and direction (6,), ENU, m.

    Returns:
        The distance, or a negative number if the ray does not meet the field.
    """
    field = _field_of(r, geom)
    x, y, z = _turned(r, geom, ray[0], ray[1], ray[2], True)
    dx, dy, dz = _turned(r, geom, ray[3], ray[4], ray[5], False)
    per_x, per_y = _cells_per_m(field)
    x, y = (x + field.size[0]) * per_x, (y + field.size[1]) * per_y
    dx, dy = dx * per_x, dy * per_y
    start, end = _within(x, dx, field.n_columns - 1, 0.0, _NEVER)
    start, end = _within(y, dy, field.n_rows - 1, start, end)
    if dz != 0.0:
        # The ray has crossed the surface where it leaves the field's heights, if it ever does.
        last_m = field.size[2] if dz > 0.0 else -field.size[3]
        end = min(end, max((last_m - z) / dz, start))
    if start > end:
        return -1.0
    place_m = z + start * dz
    if start > 0.0 and place_m <= field.size[2]:
        # The ray comes from beside the field, perhaps into the wall below its border.
        column, row = _cell(x + start * dx, field.n_columns), _cell(y + start * dy, field.n_rows)
        if place_m <= _surface(field, row, column, x + start * dx, y + start * dy):
            return start if place_m >= -field.size[3] else -1.0
    elif place_m > field.size[2]:
        if dz >= 0.0:
            return -1.0
        # The ray meets nothing before it is as low as the highest node.
        start = (field.size[2] - z) / dz
        if start > end:
            return -1.0
    return _walk(field, (x, y, z), (dx, dy, dz), start, end)


@kernel
def _walk(
    field: _Field,
    origin: tuple[float, float, float],
    direction: tuple[float, float, float],
    start: float,
    end: float,
) -> float:
    """Return where a ray from `start` to `end` first crosses the surface; negative for nowhere."""
    x, y, z = origin
    dx, dy, dz = direction
    here = start
    column, row = _cell(x + here * dx, field.n_columns), _cell(y + here * dy, field.n_rows)
    above_m = z + here * dz - _surface(field, row, column, x + here * dx, y + here * dy)
    if here > 0.0 and above_m <= 0.0:
        # The ray begins at the height of the highest node, and just there.
        return here
    while True:
        next_x, next_y = _exit(x, dx, column), _exit(y, dy, row)
        leave = min(next_x, next_y, end)
        # The surface is plane on both sides of the diagonal, where x - y is a whole number.
        across = dx - dy
        middle = (column - row - (x - y)) / across if across != 0.0 else _NEVER
        for part in range(2):
            until = min(max(middle, here), leave) if part == 0 else leave
            half = 0.5 * (here + until)
            is_right = x - y + half * across >= column - row
            f = z + until * dz
            f -= _plane(field, row, column, x + until * dx, y + until * dy, is_right)
            # Along one triangle the height above the surface is linear: interpolate the crossing.
            if (above_m > 0.0) != (f > 0.0):
                share = above_m / (above_m - f) if above_m != f else 0.0
                return here + share * (until - here)
            here, above_m = until, f
        if leave >= end:
            return -1.0
        if next_x <= next_y:
            column += 1 if dx > 0.0 else -1
        else:
            row += 1 if dy > 0.0 else -1
        if not (0 <= column < field.n_columns - 1 and 0 <= row < field.n_rows - 1):
            return -1.0


@kernel
def above_field_m(r: np.record, geom: int, point: np.ndarray) -> float:
    """Return a lower bound of the distance from a point above a height field to it; 0 below it.

    A surface whose gradient is at most g is at least as far as the height above it times 1 / sqrt(1
    + g^2). That holds beside the field too, by the nearest point of its border.
    """
    field = _field_of(r, geom)
    x, y, z = _turned(r, geom, point[0], point[1], point[2], True)
    per_x, per_y = _cells_per_m(field)
    x = min(max((x + field.size[0]) * per_x, 0.0), field.n_columns - 1.0)
    y = min(max((y + field.size[1]) * per_y, 0.0), field.n_rows - 1.0)
    row, column = _cell(y, field.n_rows), _cell(x, field.n_columns)
    cosine = doubles(r.field_cosines_address, r.n_fields)[_number_of(r, geom)]
    return max((z - _surface(field, row, column, x, y)) * cosine, 0.0)


@kernel
def ground_m(r: np.record, east_m: float, north_m: float) -> float:
    """Return the ENU height of the ground at a place, from the height field of geom 0.

    If geom 0 is a plane, the ground lies at 0.
    """
    if r.n_fields == 0:
        return 0.0
    field = _field_of(r, 0)
    place = doubles(r.xpos_address, 3)
    per_x, per_y = _cells_per_m(field)
    x = min(max((east_m - place[0] + field.size[0]) * per_x, 0.0), field.n_columns - 1.0)
    y = min(max((north_m - place[1] + field.size[1]) * per_y, 0.0), field.n_rows - 1.0)
    row, column = _cell(y, field.n_rows), _cell(x, field.n_columns)
    return place[2] + _surface(field, row, column, x, y)


@kernel
def _number_of(r: np.record, geom: int) -> int:
    return integers(r.dataid_address, r.n_geoms)[geom]


@kernel
def _field_of(r: np.record, geom: int) -> _Field:
    number = _number_of(r, geom)
    n_rows = integers(r.field_rows_address, r.n_fields)[number]
    n_columns = integers(r.field_columns_address, r.n_fields)[number]
    first = integers(r.field_first_address, r.n_fields)[number]
    # MuJoCo stores the heights of all fields one after another, as 32-bit floats.
    heights = floats(r.field_heights_address + 4 * first, n_rows * n_columns)
    return _Field(heights, n_rows, n_columns, doubles(r.field_size_address + 32 * number, 4))


@kernel
def _cells_per_m(field: _Field) -> tuple[float, float]:
    size = field.size
    return (field.n_columns - 1) / (2.0 * size[0]), (field.n_rows - 1) / (2.0 * size[1])


@kernel
def _turned(
    r: np.record, geom: int, x: float, y: float, z: float, is_place: bool
) -> tuple[float, float, float]:
    """Return a place or a direction, ENU, in the frame of a geom."""
    # `xmat` is the rotation matrix from geom to world, row by row: its transpose goes back.
    turn = doubles(r.xmat_address + 72 * geom, 9)
    if is_place:
        place = doubles(r.xpos_address + 24 * geom, 3)
        x, y, z = x - place[0], y - place[1], z - place[2]
    return (
        x * turn[0] + y * turn[3] + z * turn[6],
        x * turn[1] + y * turn[4] + z * turn[7],
        x * turn[2] + y * turn[5] + z * turn[8],
    )


@kernel
def _within(x: float, dx: float, most: int, start: float, end: float) -> tuple[float, float]:
    """Return the part of a ray from `start` to `end` where a coordinate is from 0 to `most`."""
    if dx == 0.0:
        # An empty part has its start after its end.
        return (start, end) if 0.0 <= x <= most else (1.0, 0.0)
    first, last = -x / dx, (most - x) / dx
    return max(start, min(first, last)), min(end, max(first, last))


@kernel
def _cell(x: float, n_nodes: int) -> int:
    """Return the cell of a coordinate; beyond the border, the nearest one."""
    return min(max(math.floor(x), 0), n_nodes - 2)


@kernel
def _exit(x: float, dx: float, cell: int) -> float:
    """Return the parameter of a ray at which a coordinate leaves a cell."""
    if dx == 0.0:
        return _NEVER
    return (cell + (1.0 if dx > 0.0 else 0.0) - x) / dx


@kernel
def _surface(field: _Field, row: int, column: int, x: float, y: float) -> float:
    """Return the height of the surface of a cell above the geom's origin, m."""
    return _plane(field, row, column, x, y, x - y >= column - row)


@kernel
def _plane(field: _Field, row: int, column: int, x: float, y: float, is_right: bool) -> float:
    """Return the height of the plane of one of a cell's two triangles, m."""
    heights, first = field.heights, row * field.n_columns + column
    next_row = first + field.n_columns
    u, v = x - column, y - row
    # Convert first: the difference of two 32-bit floats would be rounded to 32 bits as well.
    start, end = float(heights[first]), float(heights[next_row + 1])
    corner = float(heights[first + 1])
    if not is_right:
        corner = float(heights[next_row])
        u, v = v, u
    return field.size[2] * (start + u * (corner - start) + v * (end - corner))
