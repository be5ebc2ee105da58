"""Order: objects where their hosts pin them, and in rows and grids of equal ones."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool

from aeroscene.metrics.places.top_view import TopView
from aeroscene.relations import Kind, Unit

_MIN_ROW = 3
"""Least number of objects in a row."""
# Greatest difference of the extents in a row of equal objects.
_EQUAL_M = 0.02


def is_pinned(view: TopView) -> Bool[np.ndarray, " k"]:
    """True for each fine object whose relation gives its place in both axes."""
    return np.array(
        [all(unit.pins(i)[:2]) for unit in view.units for i in range(len(unit.members))], dtype=bool
    )


def is_in_row(view: TopView) -> Bool[np.ndarray, " k"]:
    """True for each fine object in a row or grid of at least three equal ones."""
    return np.repeat(
        np.array([_is_row_of_equals(unit) for unit in view.units], dtype=bool),
        [len(unit.members) for unit in view.units],
    )


def _is_row_of_equals(unit: Unit) -> bool:
    # Seats of one table are a group, but no row.
    if unit.relation.kind == Kind.SEAT or len(unit.members) < _MIN_ROW:
        return False
    sizes_m = np.array([member.size_m[:2] for member in unit.members])
    return bool(np.ptp(sizes_m, axis=0).max() <= _EQUAL_M)
