"""The search for the nearest free place, compiled."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from autonomy.jit import kernel

TOUCH_M = 0.001
"""Boxes that overlap by less only touch, as in the corpus."""
_STEP_M = 0.05
_GROWTH = 1.06
"""Growth of the radius from ring to ring."""
_SPOKES = 24


@kernel
def nearest_free(
    group: Float[np.ndarray, "g 8"],
    taken: Float[np.ndarray, "k 8"],
    region: Float[np.ndarray, " 6"],
    bounds: Float[np.ndarray, " 4"],
    reach_m: float,
    swing_m: float,
) -> tuple[float, float, int]:
    """Shift and quarter turns of a group about its first box, NaN without a place.

    A turn counts as a shift by `swing_m`.
    """
    radius = 0.0
    while radius <= reach_m:
        for turn in range(2):
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
    group: Float[np.ndarray, "g 8"],
    taken: Float[np.ndarray, "k 8"],
    shifts_m: Float[np.ndarray, "s 2"],
) -> int:
    """Number of the first shift by which a group overlaps nothing that is taken, -1 without one."""
    for number in range(len(shifts_m)):
        if _is_apart(group, taken, shifts_m[number, 0], shifts_m[number, 1]):
            return number
    return -1


@kernel
def _is_apart(
    group: Float[np.ndarray, "g 8"], taken: Float[np.ndarray, "k 8"], shift_x: float, shift_y: float
) -> bool:
    for g in range(len(group)):
        x, y = group[g, 0] + shift_x, group[g, 1] + shift_y
        half_x, half_y, c, s = group[g, 2], group[g, 3], group[g, 4], group[g, 5]
        for k in range(len(taken)):
            if group[g, 6] >= taken[k, 7] - TOUCH_M or taken[k, 6] >= group[g, 7] - TOUCH_M:
                continue
            if _overlaps(x, y, half_x, half_y, c, s, taken[k]):
                return False
    return True


@kernel
def _is_free(
    group: Float[np.ndarray, "g 8"],
    taken: Float[np.ndarray, "k 8"],
    region: Float[np.ndarray, " 6"],
    bounds: Float[np.ndarray, " 4"],
    shift_x: float,
    shift_y: float,
    turn: int,
) -> bool:
    x0, y0 = group[0, 0], group[0, 1]
    for g in range(len(group)):
        dx, dy = group[g, 0] - x0, group[g, 1] - y0
        c, s = group[g, 4], group[g, 5]
        if turn == 1:
            dx, dy = -dy, dx
            c, s = -s, c
        x, y = x0 + dx + shift_x, y0 + dy + shift_y
        half_x, half_y = group[g, 2], group[g, 3]
        reach_x = abs(c) * half_x + abs(s) * half_y
        reach_y = abs(s) * half_x + abs(c) * half_y
        if (
            x - reach_x < bounds[0] - TOUCH_M
            or y - reach_y < bounds[1] - TOUCH_M
            or x + reach_x > bounds[2] + TOUCH_M
            or y + reach_y > bounds[3] + TOUCH_M
        ):
            return False
        if g == 0 and not _is_within(x, y, half_x, half_y, c, s, region):
            return False
        for k in range(len(taken)):
            if group[g, 6] >= taken[k, 7] - TOUCH_M or taken[k, 6] >= group[g, 7] - TOUCH_M:
                continue
            if _overlaps(x, y, half_x, half_y, c, s, taken[k]):
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
    # What is too long for its host lies in its middle.
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
    other: Float[np.ndarray, " 8"],
) -> bool:
    dx, dy = other[0] - x, other[1] - y
    reach = math.hypot(half_x, half_y) + math.hypot(other[2], other[3])
    if dx * dx + dy * dy >= reach * reach:
        return False
    lean = abs(c * other[4] + s * other[5])
    slant = abs(s * other[4] - c * other[5])
    return (
        abs(dx * c + dy * s) < half_x + lean * other[2] + slant * other[3] - TOUCH_M
        and abs(dy * c - dx * s) < half_y + slant * other[2] + lean * other[3] - TOUCH_M
        and abs(dx * other[4] + dy * other[5]) < other[2] + lean * half_x + slant * half_y - TOUCH_M
        and abs(dy * other[4] - dx * other[5]) < other[3] + slant * half_x + lean * half_y - TOUCH_M
    )
