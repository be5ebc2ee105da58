"""The flight volume: it includes ground a little beyond it; indoors it fits the building."""

from __future__ import annotations

from math import ceil

import numpy as np

from aeroscene.feasibility.layout import Layout
from aeroscene.scene.catalogue import BUILDINGS

_MOST_GROWTH_M = 4.0
"""Greatest distance by which each side of an open flight volume moves out for ground beyond it."""
_MOST_SIDE_M = 100.0
_HEADROOM_M = 10.0
"""Height of the flight volume above the highest object under open sky."""
_SAME_M = 1e-3


def fit_extent(layout: Layout) -> None:
    """Set the sides of the flight volume, before anything is pushed back into it.

    Under open sky they move out a little for ground beyond them; indoors they fit the building.
    """
    shell = _shell(layout)
    if shell is None:
        _grow(layout)
    else:
        _hug(layout, shell)


def _shell(layout: Layout) -> int | None:
    """Row of the largest building of an indoor scene; None for a scene under open sky.

    Rooms of other layouts lie side by side on the ground, with a yard around them.
    """
    if layout.scene.domain != "indoor":
        return None
    shells = [i for i in layout.rows(BUILDINGS) if layout.boxes.parent[i] < 0]
    return max(shells, key=lambda i: layout.boxes.half_m[i].prod(), default=None)


def _hug(layout: Layout, shell: int) -> None:
    """Fit the volume to a building's outline, from the ground to the top of its roof."""
    boxes = layout.boxes
    corners = boxes.corners()[shell]
    low, high = corners.min(axis=0), corners.max(axis=0)
    own = np.flatnonzero((boxes.parent == shell) & layout.is_present)
    top_m = float(max(boxes.top_m[shell], *boxes.top_m[own])) if len(own) else boxes.top_m[shell]
    _widen(layout, np.array([*low, 0.0]), np.array([*high, top_m]))


def _grow(layout: Layout) -> None:
    boxes = layout.boxes
    corners = boxes.corners()[(boxes.parent < 0) & layout.is_present].reshape(-1, 2)
    if not len(corners):
        return
    low, high = (end.copy() for end in layout.extent_m)
    # What is left to the greatest side is shared by both ends.
    spare = np.maximum(_MOST_SIDE_M - (high - low)[:2], 0.0) / 2
    most = np.minimum(_MOST_GROWTH_M, spare)
    low[:2] -= np.clip(low[:2] - corners.min(axis=0), 0.0, most)
    high[:2] += np.clip(corners.max(axis=0) - high[:2], 0.0, most)
    _widen(layout, low, high)


def hold_all(layout: Layout) -> None:
    """Move the sides of the flight volume out to objects still beyond them; raise the sky.

    Called at the end, when no push is left that could bring them back.
    """
    if not layout.is_present.any():
        return
    boxes, (low, high) = layout.boxes, layout.extent_m.copy()
    corners = boxes.corners()[layout.is_present].reshape(-1, 2)
    top_m = float(boxes.top_m[layout.is_present].max())
    low[:2] = np.minimum(low[:2], corners.min(axis=0))
    high[:2] = np.maximum(high[:2], corners.max(axis=0))
    is_open = _shell(layout) is None
    high[2] = max(high[2], float(ceil(top_m + _HEADROOM_M)) if is_open else top_m)
    _widen(layout, low, high)


def _widen(layout: Layout, low: np.ndarray, high: np.ndarray) -> None:
    """Set the sides that differ, to the millimetre; a relief has to lie below all of the volume."""
    if (relief := layout.scene.relief) is not None:
        spans = np.array([relief.span_m(axis) for axis in range(2)])
        # Beyond the relief the ground is not known, so the volume must not extend further.
        low = np.array([*np.maximum(low[:2], spans[:, 0]), min(low[2], relief.min_m)])
        highest_m = max(high[2], ceil(relief.max_m + _HEADROOM_M))
        high = np.array([*np.minimum(high[:2], spans[:, 1]), highest_m])
    for row, wanted in enumerate((low, high)):
        differs = np.abs(layout.extent_m[row] - wanted) > _SAME_M
        layout.extent_m[row, differs] = np.round(wanted[differs], 3)
