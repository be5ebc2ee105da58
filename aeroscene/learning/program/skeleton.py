"""Skeletons: kind and parent of each token of a program, without any geometry."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Int

from aeroscene.scene import SceneDomain


@dataclass(frozen=True)
class Skeleton:
    """A tree of kinds: the site first, then all coarse objects, then the fine ones.

    Coarse objects stand depth first. Fine ones follow in the order of the coarse objects that they
    belong to, depth first again. Parents come before their children, and coarse objects have coarse
    parents.
    """

    domain: SceneDomain
    kind_id: Int[np.ndarray, " n"]
    parent: Int[np.ndarray, " n"]
    """Places of the parents; the site is its own parent."""
    n_coarse: int
    """Number of coarse tokens, the site included; they come first."""

    def __len__(self) -> int:
        return len(self.kind_id)

    @cached_property
    def depth(self) -> Int[np.ndarray, " n"]:
        """Number of ancestors of each token."""
        depth = np.zeros(len(self), dtype=np.int64)
        for i in range(1, len(self)):
            depth[i] = depth[self.parent[i]] + 1
        return depth

    @cached_property
    def ordinal(self) -> Int[np.ndarray, " n"]:
        """Place of each object among the children of its parent."""
        return _counted(self.parent.tolist())

    @cached_property
    def twin(self) -> Int[np.ndarray, " n"]:
        """Place of each object among the children of its parent that have its kind."""
        return _counted(list(zip(self.parent.tolist(), self.kind_id.tolist(), strict=True)))


def _counted(keys: list) -> Int[np.ndarray, " n"]:
    seen: Counter = Counter()
    places = np.zeros(len(keys), dtype=np.int64)
    for i, key in enumerate(keys[1:], 1):
        places[i] = seen[key]
        seen[key] += 1
    return places
