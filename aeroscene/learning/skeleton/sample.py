"""Skeletons drawn from the model, as many at once as are asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from aeroscene.learning.skeleton.choice import Chooser, allowed_children
from aeroscene.learning.skeleton.config import SkeletonError
from aeroscene.learning.skeleton.growth import FOCUS, CoarseGrowth, FineGrowth
from aeroscene.learning.skeleton.model import SkeletonModel
from aeroscene.learning.skeleton.path import Paths
from aeroscene.learning.skeleton.quotas import Quotas
from aeroscene.learning.skeleton.sequence import (
    Coarse,
    coarse_parts,
    fine_growth,
    to_device,
    wish_numbers,
)
from aeroscene.learning.skeleton.stage import Stage
from aeroscene.learning.skeleton.tree import Tree
from aeroscene.learning.tokens.kinds import DOMAINS
from aeroscene.learning.tokens.skeleton import Skeleton, Wish


@torch.inference_mode()
def sample_skeletons(
    model: SkeletonModel,
    wishes: Sequence[Wish],
    generators: Sequence[np.random.Generator],
    coarse: Sequence[Skeleton | None] | None = None,
) -> list[Skeleton]:
    """Skeletons as wished for, each drawn by a generator of its own.

    Of a skeleton in `coarse` the coarse part is kept; where there is None the model chooses one.

    Returns:
        Skeletons with as many coarse objects as wished for (or as in the part that is kept), fine
        ones as `FineGrowth` shares them out, and one start pad where the training had it.

    Raises:
        SkeletonError: If the lists differ in length.
    """
    kept = [None] * len(wishes) if coarse is None else coarse
    if not len(wishes) == len(generators) == len(kept):
        raise SkeletonError(
            f"there are {len(wishes)} wishes, {len(generators)} generators and {len(kept)} coarse "
            "parts, valid: as many of each"
        )
    model.eval()
    table = model.embedding()
    wish = torch.from_numpy(wish_numbers(wishes)).to(table)
    draw = _Draw(model, table, wish, Chooser(generators))
    return draw.with_fine(draw.with_coarse(wishes, kept), wishes)


def _site(wish: Wish) -> Skeleton:
    """A skeleton of the site alone: kinds 0 to 2 are those of the domains."""
    return Skeleton(wish.domain, np.array([DOMAINS.index(wish.domain)]), np.array([0]), 1)


@dataclass(frozen=True)
class _Draw:
    """A batch of skeletons in the making."""

    model: SkeletonModel
    table: Float[Tensor, "kinds_and_none w"]
    wish: Float[Tensor, "b 6"]
    chooser: Chooser

    def with_coarse(
        self, wishes: Sequence[Wish], kept: Sequence[Skeleton | None]
    ) -> list[Skeleton]:
        """Coarse parts: those that are kept, and drawn ones."""
        grammar = self.model.grammar
        trees = [Tree(part or _site(wish)) for wish, part in zip(wishes, kept, strict=True)]
        sites = np.array([DOMAINS.index(wish.domain) for wish in wishes])
        wanted = [w.n_coarse if p is None else 0 for w, p in zip(wishes, kept, strict=True)]
        growth = CoarseGrowth(sites, np.array(wanted), grammar.coarse_levels, grammar.n_kinds)
        state = None
        while growth.is_growing.any():
            view = self._view(growth)
            known, state = self.model.coarse(view, self.wish[:, None], self.table, state)
            rows = np.flatnonzero(growth.is_growing)
            wanted = np.broadcast_to(grammar.is_coarse, (len(rows), grammar.n_kinds))
            allowed = allowed_children(
                grammar, growth.paths, rows, wanted, grammar.coarse_needs, growth.n_left[rows]
            )
            depth, kind = self._choose(self.model.coarse, known, growth.paths, rows, allowed)
            growth.place(rows, depth, kind)
            for row, d, k in zip(rows.tolist(), depth.tolist(), kind.tolist(), strict=True):
                trees[row].add(d, k, is_coarse=True)
        return [tree.skeleton() for tree in trees]

    def with_fine(self, parts: Sequence[Skeleton], wishes: Sequence[Wish]) -> list[Skeleton]:
        """Coarse parts with fine objects on them."""
        grammar = self.model.grammar
        coarse = to_device(coarse_parts(parts, grammar.n_kinds), self.table.device)
        memory = self.model.read_coarse(coarse, self.table)
        kind = coarse.kind.cpu().numpy()
        may_bear = grammar.bears_fine[kind]
        start = self._choose_start(memory, coarse, may_bear)
        n_fine = np.array([wish.n_fine for wish in wishes])
        growth = fine_growth(coarse, may_bear, start, n_fine, grammar)
        quotas = self._quotas(kind, may_bear, start)
        trees = [Tree(part) for part in parts]
        state = None
        while growth.is_growing.any():
            view = self._view(growth)
            context = self.model.fine_context(memory, self.wish, view[FOCUS])
            known, state = self.model.fine(view, context, self.table, state)
            sharing = np.flatnonzero(growth.is_growing & growth.is_planning)
            placing = np.flatnonzero(growth.is_growing & ~growth.is_planning)
            if len(sharing):
                self._share(known, growth, sharing, quotas)
            if len(placing):
                self._place(known, growth, placing, trees)
        return [tree.skeleton() for tree in trees]

    def _view(self, growth: CoarseGrowth | FineGrowth) -> list[Tensor]:
        device = self.table.device
        return [torch.from_numpy(part).unsqueeze(1).to(device) for part in growth.view()]

    def _choose_start(
        self, memory: Float[Tensor, "b c m"], coarse: Coarse, may_bear: Bool[np.ndarray, "b c"]
    ) -> Int[np.ndarray, " b"]:
        grammar = self.model.grammar
        rows = np.flatnonzero(may_bear.any(axis=1))
        start = np.full(len(may_bear), -1)
        if grammar.is_start.any() and len(rows):
            logits = self.model.start_logits(memory, coarse, self.wish, self.table)
            suits = may_bear & grammar.bears_start[coarse.kind.cpu().numpy()]
            allowed = np.where(suits.any(axis=1, keepdims=True), suits, may_bear)
            start[rows] = self.chooser.choose(rows, logits[rows], allowed[rows])
        return start

    def _quotas(
        self,
        kind: Int[np.ndarray, "b c"],
        may_bear: Bool[np.ndarray, "b c"],
        start: Int[np.ndarray, " b"],
    ) -> Quotas:
        grammar = self.model.grammar
        least = np.where(may_bear, grammar.fine_needs.least[kind], 0)
        least += start[:, None] == np.arange(kind.shape[1])
        most = np.append(grammar.most_quota, 0)[kind]
        return Quotas(least, np.maximum(most, least), grammar.max_quota + 1)

    def _share(
        self,
        known: Float[Tensor, "b 1 h"],
        growth: FineGrowth,
        rows: Int[np.ndarray, " r"],
        quotas: Quotas,
    ) -> None:
        """Give the coarse objects in focus their quotas; the last one's brings the rest in."""
        places, logits = growth.focus[rows], self.model.quota(known[rows, 0])
        quotas.note(rows, places, logits.cpu().numpy())
        allowed = quotas.allowed(rows, places, growth.n_unshared[rows])
        quota = self.chooser.choose(rows, logits, allowed)
        for row, last in zip(rows.tolist(), quota.tolist(), strict=True):
            rest = int(growth.n_unshared[row]) - last
            if growth.n_to_plan[row] == 1 and rest > 0:
                planned = growth.quota[row].copy()
                planned[growth.focus[row]] = last
                growth.top_up(row, quotas.share_rest(row, planned, rest))
        growth.share(rows, quota)

    def _place(
        self,
        known: Float[Tensor, "b 1 h"],
        growth: FineGrowth,
        rows: np.ndarray,
        trees: Sequence[Tree],
    ) -> None:
        grammar = self.model.grammar
        is_due, is_last = growth.is_due[rows, None], growth.n_left[rows, None] == 1
        wanted = np.where(grammar.is_start, is_due, ~grammar.is_coarse & ~(is_due & is_last))
        n_left = growth.n_left[rows] - growth.is_due[rows]
        allowed = allowed_children(grammar, growth.paths, rows, wanted, grammar.fine_needs, n_left)
        depth, kind = self._choose(self.model.fine, known, growth.paths, rows, allowed)
        for row, d, k in zip(rows.tolist(), depth.tolist(), kind.tolist(), strict=True):
            trees[row].turn_to(int(growth.focus[row]))
            trees[row].add(d, k, is_coarse=False)
        growth.place(rows, depth, kind, grammar.is_start[kind])

    def _choose(
        self,
        stage: Stage,
        known: Float[Tensor, "b 1 h"],
        paths: Paths,
        rows: np.ndarray,
        allowed: Bool[np.ndarray, "r depths kinds"],
    ) -> tuple[Int[np.ndarray, " r"], Int[np.ndarray, " r"]]:
        """Depth and kind of the next object of some rows."""
        known = known[rows, 0]
        has_any = allowed.sum(axis=-1) > 0
        depth = 1 + self.chooser.choose(rows, stage.depth_logits(known), has_any)
        siblings = [torch.from_numpy(p).to(known.device) for p in paths.siblings(rows, depth)]
        logits = stage.kind_logits(
            known, torch.from_numpy(depth).to(known.device), siblings, self.table
        )
        kind = self.chooser.choose(rows, logits, allowed[np.arange(len(rows)), depth - 1])
        return depth, kind
