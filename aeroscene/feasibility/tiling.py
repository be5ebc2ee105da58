"""Surfaces that tile a plan: rooms fill their building, open ground extends below its objects.

Sampled surfaces leave gaps, and cuts widen them. In the corpus, rooms and the walls between them
cover 95% of a building's plan and more, and everything stands well within its ground. Therefore
surfaces grow, first below the objects on them, and rooms then up to the next obstacle on each side.
Nothing else moves.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.feasibility.boxes import Boxes
from aeroscene.feasibility.layout import Layout
from aeroscene.feasibility.roles import is_fitting, margin_m
from aeroscene.scene.catalogue import BUILDINGS, OPEN_GROUND, ROOMS

_TOUCH_M = 0.001
_SAME_M = 0.01
_GAP_M = 0.0005
"""Gap that is left between neighbours."""
_LEAST_M = 0.1
"""Width up to which gaps stay: jambs of the corpus leave six centimetres."""
_MOST_M = 8.0
"""Greatest distance by which a side of open ground moves out for objects beside it."""
_CROWDED_M = 0.05
"""Depth of overlap from which objects need room."""
_RIM_M = 0.1
"""Width of a surface beyond the objects on it."""


def hold_children(layout: Layout) -> None:
    """Extend open ground below its own objects that lie beside it, if there is room."""
    for row in _rows(layout, OPEN_GROUND):
        _grow(layout, row, np.minimum(_beyond_m(layout, row), _MOST_M))


def make_room(layout: Layout, is_wanted: Bool[np.ndarray, " n"], air: Boxes) -> None:
    """Extend open ground on which wanted objects overlap others or `air`, to give them places."""
    rows = np.unique(layout.overlaps(_CROWDED_M, air).pairs)
    rows = rows[rows < len(is_wanted)]
    crowded = set(layout.host[rows[is_wanted[rows]]].tolist())
    for row in _rows(layout, OPEN_GROUND):
        if row in crowded:
            _grow(layout, row, np.minimum(_to_border_m(layout, row), _MOST_M))


def _to_border_m(layout: Layout, row: int) -> Float[np.ndarray, "2 2"]:
    """Distances of a surface's low and high sides from the ends of all surfaces beside it, m."""
    boxes = layout.boxes
    beside = [i for i in _rows(layout, OPEN_GROUND) if boxes.parent[i] == boxes.parent[row]]
    middle, reach = _spans(layout, row, np.array(beside))
    half = boxes.half_m[row, :2]
    return np.stack([(reach - middle).max(axis=0) - half, (middle + reach).max(axis=0) - half])


def fill_buildings(layout: Layout) -> None:
    """Extend rooms below their own objects, then up to walls, other rooms and the shell."""
    rows = _rows(layout, ROOMS)
    for row in rows:
        _grow(layout, row, np.minimum(_beyond_m(layout, row), _within_m(layout, row)))
    for row in rows:
        _grow(layout, row, _within_m(layout, row))


def _rows(layout: Layout, categories: frozenset[str]) -> list[int]:
    """Surfaces of some categories that are parts of a building or have no parent."""
    return [
        row
        for row in layout.rows(categories)
        if ((parent := layout.parent_of(row)) is None or parent.category in BUILDINGS)
    ]


def _beyond_m(layout: Layout, row: int) -> Float[np.ndarray, "2 2"]:
    """Distances by which a surface has to grow below the fine objects that it carries, m."""
    boxes = layout.boxes
    is_child = (boxes.parent == row) & layout.is_present & ~layout.is_coarse
    middle, reach = _spans(layout, row, np.flatnonzero(is_child))
    half = boxes.half_m[row, :2]
    low = np.max(reach - middle - half, axis=0, initial=-np.inf)
    high = np.max(middle + reach - half, axis=0, initial=-np.inf)
    beyond = np.stack([low, high])
    return np.where(beyond > _SAME_M, beyond + _RIM_M, 0.0)


def _within_m(layout: Layout, row: int) -> Float[np.ndarray, "2 2"]:
    """Distances of a room's low and high sides from the shell, and from the edges of its slab.

    A room that is no part of a building stays as it is.
    """
    obj, parent = layout.objects[row], layout.parent_of(row)
    if parent is None or not is_fitting(obj, parent):
        return np.zeros((2, 2))
    room = np.full((2, 2), np.inf)
    half = layout.boxes.half_m[row, :2]
    kept = {int(layout.host[row]): 0.0, int(layout.boxes.parent[row]): margin_m(obj, parent) or 0.0}
    for bearer, kept_m in kept.items():
        middle, reach = (found[0] for found in _spans(layout, row, np.array([bearer])))
        room = np.minimum(room, np.stack([reach - middle, reach + middle]) - half - kept_m)
    return room


def _grow(layout: Layout, row: int, most_m: Float[np.ndarray, "2 2"]) -> None:
    """Move the low and high sides of a surface out, up to the next obstacle."""
    boxes = layout.boxes
    middle, reach = _spans(layout, row, np.flatnonzero(_obstacles(layout, row)))
    half, grown = boxes.half_m[row, :2], np.zeros((2, 2))
    for axis in (0, 1):
        other = 1 - axis
        # Growth along x counts when y is next, so that corners stay free.
        is_beside = (middle + reach)[:, other] > -half[other] - grown[0, other] + _TOUCH_M
        is_beside &= (middle - reach)[:, other] < half[other] + grown[1, other] - _TOUCH_M
        for end, sign in enumerate((-1.0, 1.0)):
            along, reaches = sign * middle[is_beside, axis], reach[is_beside, axis]
            is_ahead = along + reaches > half[axis] + _TOUCH_M
            gap_m = np.min((along - reaches)[is_ahead], initial=np.inf) - half[axis] - _GAP_M
            wanted_m = min(float(gap_m), float(most_m[end, axis]))
            grown[end, axis] = wanted_m if wanted_m > _LEAST_M else 0.0
    boxes.centre_m[row, :2] += boxes.frame(row).T @ ((grown[1] - grown[0]) / 2)
    boxes.half_m[row, :2] += grown.sum(axis=0) / 2


def _obstacles(layout: Layout, row: int) -> Bool[np.ndarray, " n"]:
    """Coarse strangers at the height of a surface."""
    boxes = layout.boxes
    found = layout.is_coarse & layout.is_present & ~boxes.is_kin[row]
    rise = np.minimum(boxes.top_m, boxes.top_m[row]) - np.maximum(boxes.base_m, boxes.base_m[row])
    return found & (rise > _TOUCH_M)


def _spans(
    layout: Layout, row: int, others: Int[np.ndarray, " k"]
) -> tuple[Float[np.ndarray, "k 2"], Float[np.ndarray, "k 2"]]:
    """Middles of others along a surface's axes from its own middle, and half their extents."""
    boxes, frame = layout.boxes, layout.boxes.frame(row)
    middle = (boxes.centre_m[others, :2] - boxes.centre_m[row, :2]) @ frame.T
    lean = np.abs(np.einsum("ai,kbi->kab", frame, boxes.axes_of(others)))
    return middle, np.einsum("kab,kb->ka", lean, boxes.half_m[others, :2])
