"""Skeletons as tensors: coarse parts, wishes, and steps with what should be said at each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from aeroscene.learning.skeleton.grammar import Grammar
from aeroscene.learning.skeleton.growth import FineGrowth
from aeroscene.learning.tokens.kinds import DOMAINS
from aeroscene.learning.tokens.skeleton import Skeleton, Wish

IGNORE = -100
"""Target of a step that has nothing of a sort to say."""
N_WISHES = 6
"""Numbers that a wish is told by."""


class Steps(NamedTuple):
    """A stage of many skeletons, padded to equally many steps."""

    view: tuple[Tensor, ...]
    """The fields of `View`, each [b, t, ...]."""
    siblings: tuple[Tensor, ...]
    """The fields of `Siblings` at the right depth, each [b, t, ...]."""
    depth: Int[Tensor, "b t"]
    """The right depth, IGNORE where a step places no object."""
    kind: Int[Tensor, "b t"]
    """The right kind, IGNORE where a step places no object."""
    quota: Int[Tensor, "b t"]
    """The right quota, IGNORE where a step gives none."""


class Coarse(NamedTuple):
    """The coarse parts of many skeletons, site first, padded to equally many objects."""

    kind: Int[Tensor, "b c"]
    depth: Int[Tensor, "b c"]
    length: Int[Tensor, " b"]


class Lesson(NamedTuple):
    """What training needs of a batch of skeletons."""

    wish: Float[Tensor, "b 6"]
    coarse: Coarse
    start: Int[Tensor, " b"]
    """Place of the coarse object that bears the start pad, IGNORE if none does."""
    coarse_steps: Steps
    fine_steps: Steps
    n_objects: int


def to_device(value: Any, device: torch.device) -> Any:
    """The same on a device: a tensor, or tuples with tensors in them."""
    if isinstance(value, Tensor):
        return value.to(device)
    if not isinstance(value, tuple):
        return value
    parts = (to_device(part, device) for part in value)
    return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)


def wish_numbers(wishes: Sequence[Wish]) -> Float[np.ndarray, "b 6"]:
    """Wishes as numbers about one: the domain, and how much of each."""
    domains = np.eye(len(DOMAINS))[[DOMAINS.index(wish.domain) for wish in wishes]]
    counts = np.array([(w.n_coarse, w.n_fine, w.n_areas) for w in wishes], dtype=float)
    # 34 coarse objects, 114 fine ones and 56 areas are the means of the corpus.
    return np.concatenate([domains, 2 * np.log1p(counts) - (7, 9.5, 8)], axis=1).astype(np.float32)


def coarse_parts(skeletons: Sequence[Skeleton], none: int) -> Coarse:
    """The coarse parts of skeletons; `none` stands where there is no object."""
    length = np.array([s.n_coarse for s in skeletons])
    kind = np.full((len(length), length.max()), none)
    depth = np.zeros_like(kind)
    for row, skeleton in enumerate(skeletons):
        kind[row, : length[row]] = skeleton.kind_id[: length[row]]
        depth[row, : length[row]] = skeleton.depth[: length[row]]
    return Coarse(torch.from_numpy(kind), torch.from_numpy(depth), torch.from_numpy(length))


def fine_growth(
    coarse: Coarse,
    is_bearer: Bool[np.ndarray, "b c"],
    start: Int[np.ndarray, " b"],
    n_fine: Int[np.ndarray, " b"],
    grammar: Grammar,
) -> FineGrowth:
    """The beginning of the fine stage on coarse parts."""
    kind = coarse.kind.cpu().numpy()
    usual = np.append(grammar.usual_quota, 0.0)[kind]
    levels, n_kinds = grammar.fine_levels, grammar.n_kinds
    return FineGrowth(is_bearer, kind, start, n_fine, usual, levels, n_kinds)
