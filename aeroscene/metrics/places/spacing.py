"""Rows of equal objects, which should stand at equal distances."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from jaxtyping import Float, Int

from aeroscene.metrics.places.top_view import TopView
from aeroscene.scene.catalogue import TABLES

LEAST_IN_ROW = 3
OFF_LINE_M = 0.5
"""Greatest distance of a middle from the line of its row."""
OFF_HEADING_RAD = math.radians(15.0)
"""Greatest angle between the headings of two objects in a row."""


def uneven_spacing(view: TopView, categories: frozenset[str] = TABLES) -> Float[np.ndarray, " k"]:
    """Deviation of the spacing over its mean, one number for each row of one kind.

    A row has `LEAST_IN_ROW` or more objects of one category and one parent. Their headings differ
    from that of the first by at most `OFF_HEADING_RAD`, and their middles lie at most `OFF_LINE_M`
    from the line through the first along its x or its y axis. Spacing is between neighbours along
    that line.

    Args:
        view: A scene.
        categories: Categories whose rows are judged.
    """
    found = []
    for category in sorted(categories):
        rows = view.rows({category})
        for parent in np.unique(view.arrays.parent[rows]):
            siblings = rows[view.arrays.parent[rows] == parent]
            for axes in (view.forward, view.leftward):
                found += [_unevenness(along_m) for along_m in _lines(view, siblings, axes)]
    return np.array(found, dtype=float)


def _lines(
    view: TopView, rows: Int[np.ndarray, " k"], axes: Float[np.ndarray, "n 2"]
) -> Iterator[Float[np.ndarray, " m"]]:
    """Yield the places along its line of each row's members; each object is in one row at most."""
    while len(rows) >= LEAST_IN_ROW:
        first = rows[0]
        apart_m = view.centre_m[rows] - view.centre_m[first]
        across_m = apart_m[:, 1] * axes[first, 0] - apart_m[:, 0] * axes[first, 1]
        cosine = view.forward[rows] @ view.forward[first]
        is_in = (np.abs(across_m) <= OFF_LINE_M) & (cosine >= math.cos(OFF_HEADING_RAD))
        if is_in.sum() >= LEAST_IN_ROW:
            yield apart_m[is_in] @ axes[first]
        # The first object is always in its own line, so the loop ends.
        rows = rows[~is_in]


def _unevenness(along_m: Float[np.ndarray, " m"]) -> float:
    gaps_m = np.diff(np.sort(along_m))
    return float(gaps_m.std() / max(gaps_m.mean(), 1e-9))
