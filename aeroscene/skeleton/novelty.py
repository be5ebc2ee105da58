"""Whether skeletons are new, and whether they are like those of a corpus."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from aeroscene.tokens.kinds import Vocabulary
from aeroscene.tokens.skeleton import Skeleton

_PRIOR = 0.5
"""Added to each count, so that what was not seen has a finite surprise."""
_LARGE = 10
"""Objects from which on a subtree is large: a furnished building, a square with what is on it."""


@dataclass(frozen=True, slots=True)
class SkeletonReport:
    """A set of skeletons beside those of training and a reference."""

    known_multisets: float
    """Share of the skeletons that have exactly the kinds, as often, of one in training."""
    known_trees: float
    """Share of the skeletons that are one in training, but for the order of siblings."""
    known_subtrees: float
    """The same for what stands on the site, where that is ten objects or more."""
    unseen_pairs: float
    """Share of the objects whose kind was never in training the child of their parent's kind."""
    kl_categories_bits: float
    """From these skeletons' categories to the reference's: Kullback-Leibler divergence."""
    kl_pairs_bits: float
    """The same of the pairs of categories that occur in one skeleton."""


def skeleton_report(
    skeletons: Sequence[Skeleton],
    training: Sequence[Skeleton],
    reference: Sequence[Skeleton],
    vocabulary: Vocabulary,
) -> SkeletonReport:
    """Compare skeletons with those that a model learned from and those that it did not see.

    Args:
        skeletons: What the model drew, at least one.
        training: What it learned from.
        reference: What to be like: the test split, as many as there are.
        vocabulary: The kinds of all.
    """
    trees, known_trees = _trees(skeletons), _trees(training)
    large, known = _large_subtrees(skeletons), set(_large_subtrees(training))
    pairs, known_pairs = _kind_pairs(skeletons), set(_kind_pairs(training))
    return SkeletonReport(
        _share_in(_multisets(skeletons), set(_multisets(training))),
        _share_in(trees, set(known_trees)),
        _share_in(large, known),
        1.0 - _share_in(pairs, known_pairs),
        _divergence_bits(_categories(reference, vocabulary), _categories(skeletons, vocabulary)),
        _divergence_bits(
            _category_pairs(reference, vocabulary), _category_pairs(skeletons, vocabulary)
        ),
    )


def _share_in(found: Sequence[Hashable], known: set) -> float:
    return sum(item in known for item in found) / max(1, len(found))


def _multisets(skeletons: Sequence[Skeleton]) -> list[Hashable]:
    return [tuple(np.sort(skeleton.kind_id).tolist()) for skeleton in skeletons]


def _trees(skeletons: Sequence[Skeleton]) -> list[Hashable]:
    return [_subtrees(skeleton)[0] for skeleton in skeletons]


def _large_subtrees(skeletons: Sequence[Skeleton]) -> list[Hashable]:
    found: list[Hashable] = []
    for skeleton in skeletons:
        size = np.ones(len(skeleton), dtype=np.int64)
        for i in range(len(skeleton) - 1, 0, -1):
            size[skeleton.parent[i]] += size[i]
        trees = _subtrees(skeleton)
        on_site = np.flatnonzero(skeleton.parent == 0)
        found += [trees[i] for i in on_site.tolist() if i > 0 and size[i] >= _LARGE]
    return found


def _subtrees(skeleton: Skeleton) -> list[Hashable]:
    """What hangs on each object, itself included, whatever the order of siblings."""
    below: list[list] = [[] for _ in range(len(skeleton))]
    trees: list[Hashable] = [()] * len(skeleton)
    for i in range(len(skeleton) - 1, -1, -1):
        trees[i] = (int(skeleton.kind_id[i]), *sorted(below[i], key=repr))
        if i:
            below[skeleton.parent[i]].append(trees[i])
    return trees


def _kind_pairs(skeletons: Sequence[Skeleton]) -> list[Hashable]:
    return [
        pair
        for s in skeletons
        for pair in zip(s.kind_id[s.parent[1:]].tolist(), s.kind_id[1:].tolist(), strict=True)
    ]


def _names(skeleton: Skeleton, vocabulary: Vocabulary) -> list[str]:
    return [vocabulary.kinds[kind].category for kind in skeleton.kind_id[1:].tolist()]


def _categories(skeletons: Sequence[Skeleton], vocabulary: Vocabulary) -> Counter[Hashable]:
    return Counter(name for s in skeletons for name in _names(s, vocabulary))


def _category_pairs(skeletons: Sequence[Skeleton], vocabulary: Vocabulary) -> Counter[Hashable]:
    return Counter(
        pair for s in skeletons for pair in combinations(sorted(set(_names(s, vocabulary))), 2)
    )


def _divergence_bits(of: Counter[Hashable], from_: Counter[Hashable]) -> float:
    """Kullback-Leibler divergence of one distribution from another, both smoothed, bits."""
    names = sorted(set(of) | set(from_), key=repr)
    p, q = (np.array([counts[name] for name in names]) + _PRIOR for counts in (of, from_))
    p, q = p / p.sum(), q / q.sum()
    return float((p * np.log2(p / q)).sum())
