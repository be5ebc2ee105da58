"""Signs of numbers that a model drew: odd decimals, and gaps too narrow to be intended.

The corpus is drawn in whole centimetres, and objects that do not touch are 3 cm apart. A model that
draws real numbers gives itself away by its decimals, and by objects a few millimetres off their
neighbours.
"""

from __future__ import annotations

import numpy as np
import shapely
from jaxtyping import Bool

from aeroscene.metrics.places.top_view import TopView, near_pairs

_CENTIMETRE_M = 0.01
_ROUNDED_M = 2e-4
"""Deviation from whole centimetres that the file format's own rounding explains."""
# Boxes that are nearer than this touch.
_TOUCH_M = 1.5e-3
NARROW_M = 0.005
"""Gaps of fine objects below this width look like an accident."""


def whole_centimetres(view: TopView) -> Bool[np.ndarray, " objects"]:
    """True for each fine object whose extents along x and y are whole centimetres."""
    is_fine = np.array([not obj.is_coarse for obj in view.scene.objects], dtype=bool)
    size_m = view.arrays.size_m[is_fine, :2]
    off_m = np.abs(size_m - _CENTIMETRE_M * np.round(size_m / _CENTIMETRE_M))
    return np.all(off_m <= _ROUNDED_M, axis=1)


def narrow_gaps(view: TopView) -> Bool[np.ndarray, " objects"]:
    """True for each fine object with a gap below `NARROW_M` to another one of its parent.

    Objects that touch have no gap. Objects of which one is above the other have none either.
    """
    rows = np.flatnonzero([not obj.is_coarse for obj in view.scene.objects])
    outlines = view.outline[rows]
    first, second = near_pairs(outlines, outlines, NARROW_M)
    is_pair = (first != second) & (
        view.arrays.parent[rows[first]] == view.arrays.parent[rows[second]]
    )
    # Objects on different shelves are no neighbours.
    is_pair &= view.shared_height_m(rows[first], rows[second]) > _TOUCH_M
    first, second = first[is_pair], second[is_pair]
    apart_m = np.asarray(shapely.distance(outlines[first], outlines[second]))
    is_narrow = np.zeros(len(rows), dtype=bool)
    is_narrow[first[apart_m > _TOUCH_M]] = True
    return is_narrow
