"""Are things where their hosts would have them, and in rows and grids of their like?"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool

from aeroscene.metrics.places.top_view import TopView
from aeroscene.relations.measures import is_row_of_equals


def is_pinned(view: TopView) -> Bool[np.ndarray, " k"]:
    """Whether a relation gives the place of each fine object in both axes."""
    return np.array(
        [all(unit.pins(i)[:2]) for unit in view.units for i in range(len(unit.members))], dtype=bool
    )


def is_in_row(view: TopView) -> Bool[np.ndarray, " k"]:
    """Whether each fine object is in a row or grid of at least three equal ones."""
    return np.repeat(
        np.array([is_row_of_equals(unit) for unit in view.units], dtype=bool),
        [len(unit.members) for unit in view.units],
    )
