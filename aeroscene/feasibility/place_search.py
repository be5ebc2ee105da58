"""Search for the nearest free place, compiled.

Rings of growing radius around the present place are tried, since displacement is the cost of a
projection. A grid over the whole host would test most places in vain.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from jaxtyping import Float, Shaped

from autonomy.jit import kernel

_COLUMNS = ("x_m", "y_m", "half_x_m", "half_y_m", "cos", "sin", "base_m", "top_m")
BLOCK = np.dtype([(name, np.float64) for name in _COLUMNS])
"""An upright box: its middle, half its extents along its axes, the cosine and sine of its heading,
and the heights of its lower and upper face.
"""
Blocks = Shaped[np.ndarray, " k"]
"""Array of `BLOCK`."""
TOUCH_M = 0.001
"""Depth up to which overlapping boxes only touch, as in the corpus."""
_STEP_M = 0.05
_GROWTH = 1.06
"""Growth of the radius from ring to ring, so that far places are searched more coarsely."""
_SPOKES = 24


@kernel
def nearest_free(
    group: Blocks,
    taken: Blocks,
    region: Float[np.ndarray, " 6"],
    bounds: Float[np.ndarray, " 4"],
    reach_m: float,
    swing_m: float,
) -> tuple[float, float, int]:
    """Find the nearest shift and quarter turn by which a group is free.

    Args:
        group: Boxes that move together; the first is the object, the others are carried by it.
        taken: Boxes that must not be overlapped.
        region: Rectangle that holds the first box: middle, half extents, cosine and sine of
            heading.
        bounds: Least x and y, greatest x and y of all boxes.
        reach_m: Greatest distance of a place.
        swing_m: Distance for which a turn counts.

    Returns:
        Shift along x and y, and number of quarter turns; NaN without a place.
    """
    radius = 0.0
    while radius <= reach_m:
        for turn in range(2):
            # A turn costs as much as a shift of that length, so that it is tried later.
            ring = radius - turn * swing_m
            if ring < 0.0:
                continue
            spokes = 1 if ring == 0.0 else _SPOKES
            for spoke in range(spokes):
                angle = 2.0 * math.pi * spoke / spokes
                x, y = ring * math.cos(angle), ring * math.sin(angle)
                if _is_free(group, taken, region, bounds, x, y, turn):
                    return x, y, turn
        radius = max(radius + _STEP_M, radius * _GROWTH)
    return math.nan, math.nan, 0


@kernel
def first_free(
    group: Blocks,
    taken: Blocks,
    shifts_m: Float[np.ndarray, "s 2"],
) -> int:
    """Find the first shift by which a group overlaps no taken box.

    Args:
        group: Boxes that move together.
        taken: Boxes that must not be overlapped.
        shifts_m: Shifts along x and y, in the order in which they are tried.

    Returns:
        Number of the shift; -1 if none is free.
    """
    for number in range(len(shifts_m)):
        if _is_apart(group, taken, shifts_m[number, 0], shifts_m[number, 1]):
            return number
    return -1


@kernel
def _is_apart(group: Blocks, taken: Blocks, shift_x: float, shift_y: float) -> bool:
    for block in group:
        x, y = block.x_m + shift_x, block.y_m + shift_y
        half_x, half_y, c, s = block.half_x_m, block.half_y_m, block.cos, block.sin
        # Boxes above each other do not collide, whatever their outlines.
        for other in taken:
            if block.base_m >= other.top_m - TOUCH_M or other.base_m >= block.top_m - TOUCH_M:
                continue
            if _overlaps(x, y, half_x, half_y, c, s, other):
                return False
    return True


@kernel
def _is_free(
    group: Blocks,
    taken: Blocks,
    region: Float[np.ndarray, " 6"],
    bounds: Float[np.ndarray, " 4"],
    shift_x: float,
    shift_y: float,
    turn: int,
) -> bool:
    x0, y0 = group[0].x_m, group[0].y_m
    is_first = True
    for block in group:
        dx, dy = block.x_m - x0, block.y_m - y0
        # About the first box; a half turn would change nothing of an outline.
        c, s = block.cos, block.sin
        if turn == 1:
            dx, dy = -dy, dx
            c, s = -s, c
        x, y = x0 + dx + shift_x, y0 + dy + shift_y
        half_x, half_y = block.half_x_m, block.half_y_m
        reach_x = abs(c) * half_x + abs(s) * half_y
        reach_y = abs(s) * half_x + abs(c) * half_y
        if (
            x - reach_x < bounds[0] - TOUCH_M
            or y - reach_y < bounds[1] - TOUCH_M
            or x + reach_x > bounds[2] + TOUCH_M
            or y + reach_y > bounds[3] + TOUCH_M
        ):
            return False
        if is_first and not _is_within(x, y, half_x, half_y, c, s, region):
            return False
        is_first = False
        for other in taken:
            if block.base_m >= other.top_m - TOUCH_M or other.base_m >= block.top_m - TOUCH_M:
                continue
            if _overlaps(x, y, half_x, half_y, c, s, other):
                return False
    return True


@kernel
def _is_within(
    x: float,
    y: float,
    half_x: float,
    half_y: float,
    c: float,
    s: float,
    region: Float[np.ndarray, " 6"],
) -> bool:
    dx, dy = x - region[0], y - region[1]
    rc, rs = region[4], region[5]
    lean, slant = abs(c * rc + s * rs), abs(s * rc - c * rs)
    along, across = abs(dx * rc + dy * rs), abs(dy * rc - dx * rs)
    # An object that is too long for its host lies in its middle.
    room_x = max(0.0, region[2] - lean * half_x - slant * half_y)
    room_y = max(0.0, region[3] - slant * half_x - lean * half_y)
    return along <= room_x + TOUCH_M and across <= room_y + TOUCH_M


@kernel
def _overlaps(
    x: float,
    y: float,
    half_x: float,
    half_y: float,
    c: float,
    s: float,
    other: Any,
) -> bool:
    dx, dy = other.x_m - x, other.y_m - y
    reach = math.hypot(half_x, half_y) + math.hypot(other.half_x_m, other.half_y_m)
    # Circles around both boxes decide most pairs.
    if dx * dx + dy * dy >= reach * reach:
        return False
    lean = abs(c * other.cos + s * other.sin)
    slant = abs(s * other.cos - c * other.sin)
    return (
        abs(dx * c + dy * s) < half_x + lean * other.half_x_m + slant * other.half_y_m - TOUCH_M
        and abs(dy * c - dx * s) < half_y + slant * other.half_x_m + lean * other.half_y_m - TOUCH_M
        and abs(dx * other.cos + dy * other.sin)
        < other.half_x_m + lean * half_x + slant * half_y - TOUCH_M
        and abs(dy * other.cos - dx * other.sin)
        < other.half_y_m + slant * half_x + lean * half_y - TOUCH_M
    )
