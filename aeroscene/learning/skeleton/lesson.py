"""Skeletons as lessons: the steps that make them, what is seen and what is right at each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from jaxtyping import Int
from torch import Tensor

from aeroscene.learning.skeleton.grammar import Grammar, owners
from aeroscene.learning.skeleton.growth import CoarseGrowth, FineGrowth, View
from aeroscene.learning.skeleton.path import Siblings
from aeroscene.learning.skeleton.sequence import (
    IGNORE,
    Coarse,
    Lesson,
    Steps,
    coarse_parts,
    fine_growth,
    wish_numbers,
)
from aeroscene.learning.tokens.skeleton import Skeleton, Wish


def lesson_of(skeletons: Sequence[Skeleton], wishes: Sequence[Wish], grammar: Grammar) -> Lesson:
    """The steps that make a batch of skeletons."""
    owner = [owners(skeleton) for skeleton in skeletons]
    start = np.array([_start(s, o, grammar) for s, o in zip(skeletons, owner, strict=True)])
    coarse = coarse_parts(skeletons, grammar.n_kinds)
    return Lesson(
        torch.from_numpy(wish_numbers(wishes)),
        coarse,
        torch.from_numpy(np.where(start < 0, IGNORE, start)),
        _coarse_steps(coarse, grammar),
        _fine_steps(skeletons, owner, start, coarse, grammar),
        sum(len(skeleton) - 1 for skeleton in skeletons),
    )


def _start(skeleton: Skeleton, owner: np.ndarray, grammar: Grammar) -> int:
    is_start = grammar.is_start[skeleton.kind_id] & (owner < np.arange(len(owner)))
    return int(owner[is_start.argmax()]) if is_start.any() else -1


class _Log:
    """Steps as they happen."""

    def __init__(self, n_rows: int) -> None:
        self._n_rows = n_rows
        self._views: list[View] = []
        self._siblings: list[Siblings] = []
        self._targets: list[np.ndarray] = []

    def step(self, growth: CoarseGrowth | FineGrowth, rows: np.ndarray, *said: np.ndarray) -> None:
        """Note what is seen before a step, and what is right for the rows that place an object.

        `said` are depth, kind and quota of every row, IGNORE where there is none.
        """
        targets = np.stack(said)
        depth = np.ones(self._n_rows, dtype=np.int64)
        depth[rows] = said[0][rows]
        self._views.append(growth.view())
        self._siblings.append(growth.paths.siblings(np.arange(self._n_rows), depth))
        self._targets.append(targets)

    def steps(self) -> Steps:
        """All of them, as tensors."""
        depth, kind, quota = torch.from_numpy(np.stack(self._targets, axis=-1))
        return Steps(_over_time(self._views), _over_time(self._siblings), depth, kind, quota)


def _over_time(parts: Sequence[tuple[np.ndarray, ...]]) -> tuple[Tensor, ...]:
    return tuple(torch.from_numpy(np.stack(part, axis=1)) for part in zip(*parts, strict=True))


def _coarse_steps(coarse: Coarse, grammar: Grammar) -> Steps:
    kinds, depths, length = (part.numpy() for part in coarse)
    growth = CoarseGrowth(kinds[:, 0], length - 1, grammar.coarse_levels, grammar.n_kinds)
    log = _Log(len(kinds))
    nothing = np.full(len(kinds), IGNORE)
    for i in range(1, max(2, kinds.shape[1])):
        rows = np.flatnonzero(growth.is_growing)
        depth, kind = nothing.copy(), nothing.copy()
        if len(rows):
            depth[rows], kind[rows] = depths[rows, i], kinds[rows, i]
        log.step(growth, rows, depth, kind, nothing)
        growth.place(rows, depth[rows], kind[rows])
    return log.steps()


def _fine_steps(
    skeletons: Sequence[Skeleton],
    owner: Sequence[np.ndarray],
    start: np.ndarray,
    coarse: Coarse,
    grammar: Grammar,
) -> Steps:
    quotas = _quotas(skeletons, owner, coarse.kind.shape[1])
    kinds, depths = _below_owners(skeletons, owner)
    is_bearer = grammar.bears_fine[coarse.kind.numpy()] | (quotas > 0)
    growth = fine_growth(coarse, is_bearer, start, quotas.sum(axis=1), grammar)
    at = coarse.length.numpy().copy()
    log = _Log(len(skeletons))
    while True:
        growing, plans = growth.is_growing, growth.is_planning
        planning, placing = np.flatnonzero(growing & plans), np.flatnonzero(growing & ~plans)
        depth, kind, quota = np.full((3, len(skeletons)), IGNORE)
        quota[planning] = quotas[planning, growth.focus[planning]]
        depth[placing], kind[placing] = depths[placing, at[placing]], kinds[placing, at[placing]]
        log.step(growth, placing, depth, kind, quota)
        growth.share(planning, quota[planning])
        growth.place(placing, depth[placing], kind[placing], grammar.is_start[kind[placing]])
        at[placing] += 1
        if not growth.is_growing.any():
            return log.steps()


def _quotas(
    skeletons: Sequence[Skeleton], owner: Sequence[np.ndarray], n_places: int
) -> Int[np.ndarray, "b c"]:
    """Fine objects of each coarse one."""
    pairs = zip(skeletons, owner, strict=True)
    return np.stack([np.bincount(o[s.n_coarse :], minlength=n_places) for s, o in pairs])


def _below_owners(
    skeletons: Sequence[Skeleton], owner: Sequence[np.ndarray]
) -> Int[np.ndarray, "2 b n"]:
    """Kind of each object, and its depth below the coarse object that it belongs to."""
    found = np.full((2, len(skeletons), max(len(s) for s in skeletons)), IGNORE)
    for row, (skeleton, own) in enumerate(zip(skeletons, owner, strict=True)):
        found[0, row, : len(own)] = skeleton.kind_id
        found[1, row, : len(own)] = skeleton.depth - skeleton.depth[own]
    return found
