"""The way from a root down to the object placed last, for many trees that grow depth first.

What a model sees of a tree is what lies along this path: the next object is a child of one of
those on it. Training and sampling walk the same code, so they cannot disagree.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from jaxtyping import Int, UInt8

from aeroscene.learning.skeleton.bucket import bucket


class Siblings(NamedTuple):
    """What is there already where an object is to be placed."""

    parent: Int[np.ndarray, " r"]
    """Kind of the parent."""
    last: Int[np.ndarray, " r"]
    """Kind of the parent's latest child."""
    n_siblings: Int[np.ndarray, " r"]
    """Children of the parent, see `bucket`."""
    bag: UInt8[np.ndarray, "r kinds"]
    """Children of the parent of each kind."""


class Paths:
    """One path a row; level 0 is the root, level d the object at depth d."""

    def __init__(self, n_rows: int, n_levels: int, n_kinds: int) -> None:
        self.none = n_kinds
        """Number that stands for no kind."""
        self.depth = np.zeros(n_rows, dtype=np.int64)
        """Depth of the object placed last."""
        self.kind = np.full((n_rows, n_levels), self.none)
        """Kind of the object at each level."""
        self.last = np.full((n_rows, n_levels), self.none)
        """Kind of the latest child of the object at each level."""
        self.n_children = np.zeros((n_rows, n_levels), dtype=np.int64)
        self.bag = np.zeros((n_rows, n_levels, n_kinds), dtype=np.uint8)
        """Children of each kind that the object at each level has."""

    def seen(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Kinds along the path, their numbers of children as classes, and the depth."""
        return self.kind.copy(), bucket(self.n_children), self.depth.copy()

    def restart(self, rows: Int[np.ndarray, " r"], kind: Int[np.ndarray, " r"]) -> None:
        """Begin trees anew at roots of these kinds."""
        self._put(rows, np.zeros_like(rows), kind)

    def place(
        self, rows: Int[np.ndarray, " r"], depth: Int[np.ndarray, " r"], kind: Int[np.ndarray, " r"]
    ) -> None:
        """Add an object at a depth from 1, child of the path's object one level up."""
        above = depth - 1
        self.last[rows, above] = kind
        self.n_children[rows, above] += 1
        self.bag[rows, above, kind] += self.bag[rows, above, kind] < 255
        self._put(rows, depth, kind)

    def siblings(self, rows: Int[np.ndarray, " r"], depth: Int[np.ndarray, " r"]) -> Siblings:
        """What is there already at a depth from 1."""
        at = (rows, depth - 1)
        return Siblings(self.kind[at], self.last[at], bucket(self.n_children[at]), self.bag[at])

    def _put(self, rows: np.ndarray, depth: np.ndarray, kind: np.ndarray) -> None:
        gone = np.arange(self.kind.shape[1]) >= depth[:, None]
        self.kind[rows] = np.where(gone, self.none, self.kind[rows])
        self.last[rows] = np.where(gone, self.none, self.last[rows])
        self.n_children[rows] = np.where(gone, 0, self.n_children[rows])
        self.kind[rows, depth] = kind
        self.bag[rows, depth] = 0
        self.depth[rows] = depth
