"""What training skeletons have at all: who may be whose child, how often, how deep."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.learning.skeleton.needs import Needs, needs_of
from aeroscene.learning.tokens.kinds import Vocabulary
from aeroscene.learning.tokens.skeleton import Skeleton

FEW = 2
"""A parent that never had more than so many children of a kind never gets more: a building has
one roof. What there were more of may be repeated without end."""
_ENOUGH = 8
"""Objects of a kind that must have been seen for what they all have to be called needed."""


@dataclass(frozen=True, eq=False)
class Grammar:
    """The structure that samples keep: outside of it nothing is drawn."""

    is_coarse: Bool[np.ndarray, " kinds"]
    is_start: Bool[np.ndarray, " kinds"]
    most: Int[np.ndarray, "kinds kinds"]
    """Most children of a kind (column) that a parent of a kind (row) had."""
    usual_quota: Float[np.ndarray, " kinds"]
    """Fine objects that belonged to a coarse one of each kind, on average."""
    most_quota: Int[np.ndarray, " kinds"]
    """Fine objects that belonged to a coarse one of each kind, at most."""
    category: Int[np.ndarray, "kinds categories"]
    """One where a kind is of a category."""
    always: Bool[np.ndarray, "kinds categories"]
    """Which categories of children each kind never went without."""
    coarse_levels: int
    """Greatest depth of a coarse object, the site's 0 included."""
    fine_levels: int
    """Greatest depth of a fine object below its coarse one, the coarse one's 0 included."""

    @property
    def n_kinds(self) -> int:
        """Kinds, sites included."""
        return len(self.is_coarse)

    @property
    def max_quota(self) -> int:
        """Most fine objects that belonged to one coarse object."""
        return int(self.most_quota.max())

    @cached_property
    def coarse_needs(self) -> Needs:
        """Coarse children that kinds need."""
        return needs_of(self.category, self.always, self.is_coarse, self.is_start)

    @cached_property
    def fine_needs(self) -> Needs:
        """Fine children that kinds need."""
        return needs_of(self.category, self.always, ~self.is_coarse, self.is_start)

    @cached_property
    def cap(self) -> Int[np.ndarray, "kinds_and_none kinds"]:
        """How many children of a kind a parent of a kind may have; no parent has none."""
        many = np.where(self.most <= FEW, self.most, np.iinfo(np.int32).max)
        return np.concatenate([many, np.zeros_like(many[:1])])

    @cached_property
    def bears_fine(self) -> Bool[np.ndarray, " kinds_and_none"]:
        """Kinds that have fine children other than the start pad."""
        return (self.cap[:, ~self.is_coarse & ~self.is_start] > 0).sum(axis=1) > 0

    @cached_property
    def bears_start(self) -> Bool[np.ndarray, " kinds_and_none"]:
        """Kinds that bear the start pad."""
        return (self.cap[:, self.is_start] > 0).sum(axis=1) > 0


def learn_grammar(vocabulary: Vocabulary, skeletons: Sequence[Skeleton]) -> Grammar:
    """The structure of a set of skeletons."""
    n_kinds = vocabulary.n_kinds
    category = kind_categories(vocabulary)
    most = np.zeros((n_kinds, n_kinds), dtype=np.int32)
    most_quota = np.zeros(n_kinds, dtype=np.int32)
    n_found, n_borne = np.zeros((2, n_kinds))
    n_with = np.zeros(category.shape)
    coarse_levels, fine_levels = 2, 2
    for skeleton in skeletons:
        kinds, parents = skeleton.kind_id, skeleton.kind_id[skeleton.parent]
        np.maximum.at(most, (parents[1:], kinds[1:]), skeleton.twin[1:].astype(np.int32) + 1)
        has = np.zeros((len(skeleton), category.shape[1]))
        np.maximum.at(has, skeleton.parent[1:], category[kinds[1:]])
        np.add.at(n_with, kinds, has)
        np.add.at(n_found, kinds, 1)
        owner = owners(skeleton)
        below = skeleton.depth - skeleton.depth[owner]
        coarse = slice(skeleton.n_coarse)
        quotas = np.bincount(owner[skeleton.n_coarse :], minlength=skeleton.n_coarse)
        np.add.at(n_borne, kinds[coarse], quotas)
        np.maximum.at(most_quota, kinds[coarse], quotas.astype(np.int32))
        coarse_levels = max(coarse_levels, 1 + int(skeleton.depth[coarse].max()))
        fine_levels = max(fine_levels, 1 + int(below.max()))
    is_start = start_kinds(vocabulary)
    always = (n_with == n_found[:, None]) & (n_found[:, None] >= _ENOUGH)
    return Grammar(
        is_coarse=vocabulary.is_coarse,
        is_start=is_start,
        most=most,
        usual_quota=(n_borne / np.maximum(n_found, 1)).astype(np.float32),
        most_quota=most_quota,
        category=category,
        # The start pad is placed by a step of its own.
        always=always & ~(category[is_start].sum(axis=0) > 0),
        coarse_levels=coarse_levels,
        fine_levels=fine_levels,
    )


def kind_categories(vocabulary: Vocabulary) -> Int[np.ndarray, "kinds categories"]:
    """One where a kind is of a category; the categories by name."""
    names = [kind.category for kind in vocabulary.kinds]
    return (np.array(names)[:, None] == np.unique(names)).astype(np.int64)


def start_kinds(vocabulary: Vocabulary) -> Bool[np.ndarray, " kinds"]:
    """Which kinds are start pads."""
    return np.array([kind.is_start for kind in vocabulary.kinds])


def owners(skeleton: Skeleton) -> Int[np.ndarray, " n"]:
    """The coarse object that each object belongs to: itself, or the nearest one above it."""
    owner = np.arange(len(skeleton))
    for i in range(skeleton.n_coarse, len(skeleton)):
        owner[i] = owner[skeleton.parent[i]]
    return owner
