"""What a kind never goes without: children that training always found, kept in every draw.

A model that is nearly always right still leaves one building in twenty without a roof. So a draw
may not turn away from an object that lacks something, nor begin what the objects that are left to
place cannot complete.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.learning.skeleton.path import Paths


class Needs(NamedTuple):
    """What objects need of the children of one level, coarse or fine."""

    category: Float[np.ndarray, "kinds categories"]
    """One where a kind is of a category; single precision, since whole numbers multiply slowly."""
    due: Float[np.ndarray, "kinds_and_none categories"]
    """Objects that each kind needs of a category, with what those need themselves."""
    least: Int[np.ndarray, " kinds_and_none"]
    """Objects below each kind that it needs at least."""
    has_place: Bool[np.ndarray, " kinds"]
    """Kinds that a place is kept for beside the others: the start pad."""

    def affordable(
        self, paths: Paths, rows: Int[np.ndarray, " r"], n_left: Int[np.ndarray, " r"]
    ) -> Bool[np.ndarray, "r depths kinds"]:
        """Which kinds may come next at which depth, from 1, so that nothing goes without.

        `n_left` are the objects that each row may still place, this one included, without those
        that a place is kept for.
        """
        has = paths.bag[rows].astype(np.float32) @ self.category > 0
        lacks = np.where(has, np.float32(0), self.due[paths.kind[rows]])
        owed = lacks.sum(axis=-1)
        is_left_in_order = owed[:, ::-1].cumsum(axis=1)[:, ::-1] == 0
        still_owed = owed.cumsum(axis=1)[:, :-1]
        relief = lacks[:, :-1] @ self.category.T
        after = still_owed[..., None] - relief + self.least[:-1]
        is_enough = (after <= n_left[:, None, None] - 1) | self.has_place
        return is_left_in_order[:, 1:, None] & is_enough


def needs_of(
    category: Int[np.ndarray, "kinds categories"],
    always: Bool[np.ndarray, "kinds categories"],
    is_level: Bool[np.ndarray, " kinds"],
    has_place: Bool[np.ndarray, " kinds"],
) -> Needs:
    """The needs of children of one level, by the categories that each kind always has."""
    on_level = (category * is_level[:, None]).sum(axis=0) > 0
    always = np.concatenate([always & on_level, np.zeros_like(always[:1])])
    cost = np.ones(category.shape[1], dtype=np.int64)
    # What a child needs adds to the cost of its category; a round reaches one level further down.
    for _ in range(8):
        least = (always * cost).sum(axis=1)[:-1]
        below = np.where(category > 0, least[:, None], np.iinfo(np.int32).max).min(axis=0)
        cost = 1 + np.where(on_level, below, 0)
    due = (always * cost).astype(np.float32)
    return Needs(category.astype(np.float32), due, due.sum(axis=1).astype(np.int64), has_place)
