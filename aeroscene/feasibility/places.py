"""The nearest free place: for what no push can part from its neighbours."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np
from jaxtyping import Float, Int

from aeroscene.feasibility.boxes import Boxes
from aeroscene.feasibility.heights import surface_m
from aeroscene.feasibility.layout import Layout
from aeroscene.feasibility.roles import GROUND, margin_m
from aeroscene.solids.shapes.shell import FINISH_M

TOUCH_M = 0.001
_STEP_M = 0.05
_GROWTH = 1.06
"""Of the radius from ring to ring."""
_SPOKES = 24
_QUARTER = math.pi / 2
_NO_HOST_M = 40.0
"""How far away a place may be for what stands on nothing in particular."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where an object could go."""

    host: int
    """What it would stand on, -1 for the bare earth."""
    shift_m: tuple[float, float]
    quarters: int
    """Quarter turns."""
    swing_m: float
    """How far on average these move what the object carries."""

    @property
    def distance_m(self) -> float:
        """How far it is, by shift and turns together."""
        return math.hypot(*self.shift_m) + self.swing_m


def find_place(
    layout: Layout,
    row: int,
    host: int,
    obstacles: Boxes,
    reach_m: float = math.inf,
    *,
    may_cut: bool = False,
    among_coarse: bool = False,
) -> Place | None:
    """The nearest free place upon a host for an object with all it carries.

    Args:
        layout: Left as it is.
        row: The object.
        host: What it is to stand on, -1 for the bare earth.
        obstacles: Boxes that must be left free, beside all objects of the layout.
        reach_m: How far to look.
        may_cut: Whether ground is no obstacle, because it can be cut.
        among_coarse: Whether fine objects are none, because they make room afterwards.
    """
    boxes, group = layout.boxes, layout.carried(row)
    group = np.array([row, *group[layout.is_left[group] & (group != row)].tolist()])
    others = layout.is_left & ~layout.moves_with[:, row]
    if among_coarse:
        is_coarse = np.array([obj.is_coarse for obj in layout.objects], dtype=bool)
        group, others = group[is_coarse[group]], others & is_coarse
    rows = _rows(boxes, group)
    rise_m = 0.0
    if host != layout.host[row]:
        rise_m = floor_m(layout, row, host) - float(boxes.base_m[row])
        rows[:, 6:] += rise_m
    # What bears it, and what that belongs to, may overlap it.
    above = layout.chain(host) if host >= 0 else []
    others[above] = False
    if host == layout.boxes.parent[row]:
        others &= ~boxes.is_kin[row]
    if may_cut:
        others &= [obj.category not in GROUND for obj in layout.objects]
    taken = np.concatenate([_rows(boxes, np.flatnonzero(others)), _all_rows(obstacles)])
    region, furthest_m = _region(layout, row, host)
    swing_m = _swing_m(layout, row)
    x, y, turn = _nearest(rows, taken, region, _bounds(layout), min(reach_m, furthest_m), swing_m)
    return None if math.isnan(x) else Place(host, (x, y), turn, turn * swing_m)


def _swing_m(layout: Layout, row: int) -> float:
    """How far a quarter turn moves an object and all it carries, on average."""
    group = layout.carried(row)
    offset = layout.boxes.centre_m[group, :2] - layout.boxes.centre_m[row, :2]
    return math.sqrt(2) * float(np.hypot(*offset.T).mean())


def move_to(layout: Layout, row: int, place: Place) -> None:
    """Move an object with all it carries to a place; another host becomes its parent."""
    if place.quarters:
        layout.turn(row, place.quarters * _QUARTER)
    rise_m = 0.0
    if place.host != layout.host[row]:
        rise_m = floor_m(layout, row, place.host) - float(layout.boxes.base_m[row])
        if layout.boxes.parent[row] < 0 and layout.objects[row].is_coarse:
            layout.rehost(row, place.host)
        else:
            layout.adopt(row, place.host)
    layout.shift(row, np.array([*place.shift_m, rise_m]))


def floor_m(layout: Layout, row: int, host: int) -> float:
    """Height on which an object stands upon a host, the bare earth included."""
    if host < 0:
        return 0.0
    if layout.objects[host].category == "room":
        return float(layout.boxes.base_m[host]) + FINISH_M
    return surface_m(layout, host, row)


def _rows(boxes: Boxes, rows: Int[np.ndarray, " k"]) -> Float[np.ndarray, "k 8"]:
    """Centre, half extents, heading and heights of boxes."""
    return np.column_stack(
        [
            boxes.centre_m[rows, :2],
            boxes.half_m[rows, :2],
            np.cos(boxes.yaw_rad[rows]),
            np.sin(boxes.yaw_rad[rows]),
            boxes.base_m[rows],
            boxes.top_m[rows],
        ]
    )


def _all_rows(boxes: Boxes) -> Float[np.ndarray, "k 8"]:
    return _rows(boxes, np.arange(len(boxes)))


def _bounds(layout: Layout) -> Float[np.ndarray, " 4"]:
    return layout.extent_m[:, :2].ravel()


def _region(layout: Layout, row: int, host: int) -> tuple[Float[np.ndarray, " 6"], float]:
    """Where an object may be: centre, half extents, heading of a rectangle; and how far to look."""
    boxes, parent = layout.boxes, layout.parent_of(row)
    if host < 0:
        return np.array([0.0, 0.0, np.inf, np.inf, 1.0, 0.0]), _NO_HOST_M
    kept = 0.0 if parent is None else margin_m(layout.objects[row], parent)
    yaw = float(boxes.yaw_rad[host])
    half = boxes.half_m[host, :2] - (kept or 0.0)
    region = np.array([*boxes.centre_m[host, :2], *half, math.cos(yaw), math.sin(yaw)])
    away_m = float(np.hypot(*(boxes.centre_m[host, :2] - boxes.centre_m[row, :2])))
    return region, away_m + float(np.hypot(*boxes.half_m[host, :2]))


@numba.njit(cache=True, error_model="numpy")
def _nearest(
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


@numba.njit(cache=True, error_model="numpy")
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


@numba.njit(cache=True, error_model="numpy")
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


@numba.njit(cache=True, error_model="numpy")
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
