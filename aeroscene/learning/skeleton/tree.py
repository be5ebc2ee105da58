"""A skeleton in the making: objects come with a depth, depth first."""

from __future__ import annotations

import numpy as np

from aeroscene.learning.tokens.skeleton import Skeleton
from aeroscene.scene import SceneDomain


class Tree:
    """Kinds and parents, in a skeleton's order."""

    def __init__(self, coarse: Skeleton) -> None:
        """Begin with the coarse part of a skeleton; its site at least."""
        n = coarse.n_coarse
        self._domain: SceneDomain = coarse.domain
        self._n_coarse = n
        self._kinds: list[int] = coarse.kind_id[:n].tolist()
        self._parents: list[int] = coarse.parent[:n].tolist()
        self._path: list[int] = [0]

    def turn_to(self, place: int) -> None:
        """Let the next objects' depths count from an object that is there."""
        if self._path[0] != place:
            self._path = [place]

    def add(self, depth: int, kind: int, *, is_coarse: bool) -> None:
        """An object, `depth` levels below the one turned to."""
        self._parents.append(self._path[depth - 1])
        self._path[depth:] = [len(self._kinds)]
        self._kinds.append(kind)
        self._n_coarse += is_coarse

    def skeleton(self) -> Skeleton:
        """Skeleton of the objects added so far."""
        return Skeleton(
            self._domain, np.array(self._kinds), np.array(self._parents), self._n_coarse
        )
