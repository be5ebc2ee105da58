"""The nearest free place, for objects that no push can separate from their neighbours."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from aeroscene.feasibility.boxes import Boxes
from aeroscene.feasibility.heights import surface_m
from aeroscene.feasibility.layout import Layout
from aeroscene.feasibility.place_search import BLOCK, Blocks, nearest_free
from aeroscene.feasibility.roles import margin_m
from aeroscene.scene.catalogue import GROUND, ROOMS
from aeroscene.solids.shapes.shell import FINISH_M

_QUARTER = math.pi / 2
_NO_HOST_M = 40.0
"""Greatest distance of a place for an object without a host."""


@dataclass(frozen=True, slots=True)
class Place:
    """A place to which an object could move."""

    host: int
    """Host on which the object would stand; -1 for the bare earth."""
    shift_m: tuple[float, float]
    quarters: int
    """Number of quarter turns."""
    swing_m: float
    """Mean distance by which the turns move the object and all it carries."""

    @property
    def distance_m(self) -> float:
        """Distance of the place: shift and turns together, m."""
        return math.hypot(*self.shift_m) + self.swing_m


def find_place(
    layout: Layout,
    row: int,
    host: int,
    obstacles: Boxes,
    reach_m: float = math.inf,
    *,
    may_cut: bool = False,
    may_push: bool = False,
) -> Place | None:
    """Find the nearest free place on a host for an object with all it carries.

    Args:
        layout: Layout; it stays as it is.
        row: Row of the object.
        host: Host to stand on; -1 for the bare earth.
        obstacles: Boxes that must be left free, besides all objects of the layout.
        reach_m: Greatest distance of the place.
        may_cut: Ground is no obstacle, because it can be cut.
        may_push: Smaller fine objects are no obstacles, because they can make room.

    Returns:
        The place, or None if there is none.
    """
    boxes, group = layout.boxes, layout.carried(row)
    group = np.array([row, *group[layout.is_present[group] & (group != row)].tolist()])
    others = layout.is_present & ~layout.moves_with[:, row] & layout.obstructs(row)
    if layout.is_coarse[row]:
        # Fine objects on a coarse one find places of their own later.
        group = group[layout.is_coarse[group]]
    rows = _rows(boxes, group)
    rise_m = 0.0
    if host != layout.host[row]:
        rise_m = floor_m(layout, row, host) - float(boxes.base_m[row])
        rows["base_m"] += rise_m
        rows["top_m"] += rise_m
    # The host and its ancestors may overlap the object.
    above = layout.chain(host) if host >= 0 else []
    others[above] = False
    if host == layout.boxes.parent[row]:
        others &= ~boxes.is_kin[row]
    if may_cut:
        others &= [obj.category not in GROUND for obj in layout.objects]
    if may_push:
        size = boxes.half_m.prod(axis=1)
        others &= ~layout.is_fine | (size >= size[row])
    in_the_way = _rows(obstacles, np.arange(len(obstacles)))
    taken = np.concatenate([_rows(boxes, np.flatnonzero(others)), in_the_way])
    region, furthest_m = _region(layout, row, host)
    swing_m = _swing_m(layout, row)
    x, y, turn = nearest_free(
        rows, taken, region, _bounds(layout), min(reach_m, furthest_m), swing_m
    )
    return None if math.isnan(x) else Place(host, (x, y), turn, turn * swing_m)


def _swing_m(layout: Layout, row: int) -> float:
    """Mean distance by which a quarter turn moves an object and all it carries, m."""
    group = layout.carried(row)
    offset = layout.boxes.centre_m[group, :2] - layout.boxes.centre_m[row, :2]
    return math.sqrt(2) * float(np.hypot(*offset.T).mean())


def move_to(layout: Layout, row: int, place: Place) -> None:
    """Move an object with all it carries to a place; another host becomes its parent.

    Coarse roots stay roots, and stand on other ground.

    Args:
        layout: Layout; changed.
        row: Row of the object.
        place: Place of `find_place`.
    """
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
    """Height on which an object stands on a host, the bare earth included, m.

    Args:
        layout: Layout.
        row: Row of the object.
        host: Row of the host; -1 for the bare earth, at height 0.
    """
    if host < 0:
        return 0.0
    if layout.objects[host].category in ROOMS:
        return float(layout.boxes.base_m[host]) + FINISH_M
    return surface_m(layout, host, row)


def _rows(boxes: Boxes, rows: Int[np.ndarray, " k"]) -> Blocks:
    blocks = np.empty(len(rows), dtype=BLOCK)
    blocks["x_m"], blocks["y_m"] = boxes.centre_m[rows, :2].T
    blocks["half_x_m"], blocks["half_y_m"] = boxes.half_m[rows, :2].T
    blocks["cos"], blocks["sin"] = np.cos(boxes.yaw_rad[rows]), np.sin(boxes.yaw_rad[rows])
    blocks["base_m"], blocks["top_m"] = boxes.base_m[rows], boxes.top_m[rows]
    return blocks


def _bounds(layout: Layout) -> Float[np.ndarray, " 4"]:
    return layout.extent_m[:, :2].ravel()


def _region(layout: Layout, row: int, host: int) -> tuple[Float[np.ndarray, " 6"], float]:
    """Rectangle that must hold an object (centre, half extents, heading); radius to search."""
    boxes, parent = layout.boxes, layout.parent_of(row)
    if host < 0:
        return np.array([0.0, 0.0, np.inf, np.inf, 1.0, 0.0]), _NO_HOST_M
    kept = 0.0 if parent is None else margin_m(layout.objects[row], parent)
    yaw = float(boxes.yaw_rad[host])
    middle, half = _floor(layout, host)
    region = np.array([*middle, *(half - (kept or 0.0)), math.cos(yaw), math.sin(yaw)])
    # The whole host lies within that distance.
    away_m = float(np.hypot(*(middle - boxes.centre_m[row, :2])))
    return region, away_m + float(np.hypot(*half))


def _floor(layout: Layout, host: int) -> tuple[Float[np.ndarray, " 2"], Float[np.ndarray, " 2"]]:
    """Middle and half extents, along the host's axes, of the floor that objects on it use."""
    boxes, tiles = layout.boxes, layout.tiles(host)
    if len(tiles) == 1:
        return boxes.centre_m[host, :2], boxes.half_m[host, :2]
    frame = boxes.frame(host)
    local = boxes.corners()[tiles].reshape(-1, 2) @ frame.T
    low, high = local.min(axis=0), local.max(axis=0)
    return (low + high) / 2 @ frame, (high - low) / 2
