"""Scenes as padded tensors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from weakref import finalize

import numpy as np
import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from aeroscene.learning.tokens.channels import attachment_heights
from aeroscene.learning.tokens.examples import Example
from aeroscene.learning.tokens.kinds import DOMAINS, Vocabulary
from aeroscene.learning.tokens.skeleton import Skeleton, Wish
from aeroscene.learning.tokens.statistics import Statistics

MOST_SIBLINGS = 63
"""Places among siblings are counted up to here."""
_WISH_MEAN = np.array([34.0, 113.0, 56.0])
_WISH_SPREAD = np.array([6.0, 22.0, 12.0])


@dataclass(frozen=True)
class TokenBatch:
    """Tokens of several scenes: coarse slots first, then fine ones, each padded at its end."""

    kind: Int[Tensor, "batch n"]
    parent: Int[Tensor, "batch n"]
    """Slot of the parent; the site, in slot 0, and padding have slot 0."""
    depth: Int[Tensor, "batch n"]
    ordinal: Int[Tensor, "batch n"]
    """Place among the children of the parent, up to `MOST_SIBLINGS`."""
    twin: Int[Tensor, "batch n"]
    """Place among those that are of the same kind, too."""
    mask: Bool[Tensor, "batch n"]
    """Which slots hold a token."""
    stands_on_top: Bool[Tensor, "batch n"]
    lift_m: Float[Tensor, "batch n"]
    """Height of the underside above the parent's; NaN where it is a channel or on top."""
    domain: Int[Tensor, " batch"]
    wish: Float[Tensor, "batch 3"]
    """Objects coarse and fine, and landing areas wished for, standardised."""
    n_coarse_slots: int
    x0: Float[Tensor, "batch n channels"] | None = None
    weight: Float[Tensor, "batch n channels"] | None = None
    """1 where a channel of a token varies, 0 elsewhere and in padding."""

    @property
    def n_scenes(self) -> int:
        """Scenes in the batch."""
        return self.kind.shape[0]

    def to(self, device: torch.device | str, *, non_blocking: bool = False) -> TokenBatch:
        """The same batch on another device."""
        return self._with_each(lambda value: value.to(device, non_blocking=non_blocking))

    def pinned(self) -> TokenBatch:
        """The same batch in memory that a GPU reads while the processor goes on."""
        return self._with_each(lambda value: value.pin_memory())

    def scenes(self, some: slice) -> TokenBatch:
        """Some of the batch's scenes."""
        return self._with_each(lambda value: value[some])

    def _with_each(self, change: Callable[[Tensor], Tensor]) -> TokenBatch:
        changed = {
            field.name: change(value)
            for field in fields(self)
            if isinstance(value := getattr(self, field.name), Tensor)
        }
        return replace(self, **changed)


def scaled_wish(wish: Wish) -> Float[np.ndarray, " 3"]:
    """A wish as the networks read it."""
    return (np.array([wish.n_coarse, wish.n_fine, wish.n_areas]) - _WISH_MEAN) / _WISH_SPREAD


class Collator:
    """Makes batches of skeletons, with geometry where there is one."""

    def __init__(self, vocabulary: Vocabulary, statistics: Statistics) -> None:
        self._vocabulary = vocabulary
        self._is_free = statistics.is_free
        self._heights: dict[int, tuple[np.ndarray, np.ndarray]] = {}

    def examples(self, examples: Sequence[Example]) -> TokenBatch:
        """Batch for training."""
        batch = self.skeletons([e.skeleton for e in examples], [e.wish for e in examples])
        slots = [_slots(e.skeleton, batch.n_coarse_slots) for e in examples]
        shape = (*batch.kind.shape, self._is_free.shape[1])
        x0, weight = np.zeros(shape, dtype=np.float32), np.zeros(shape, dtype=np.float32)
        for row, (example, slot) in enumerate(zip(examples, slots, strict=True)):
            x0[row, slot] = example.x0
            weight[row, slot] = self._is_free[example.skeleton.kind_id]
        return replace(batch, x0=torch.from_numpy(x0), weight=torch.from_numpy(weight))

    def skeletons(self, skeletons: Sequence[Skeleton], wishes: Sequence[Wish]) -> TokenBatch:
        """Batch for sampling."""
        n_coarse = max(skeleton.n_coarse for skeleton in skeletons)
        n = n_coarse + max(len(skeleton) - skeleton.n_coarse for skeleton in skeletons)
        whole = np.zeros((5, len(skeletons), n), dtype=np.int64)
        mask, on_top = np.zeros((2, len(skeletons), n), dtype=bool)
        lift = np.zeros((len(skeletons), n), dtype=np.float32)
        weight = np.zeros((len(skeletons), n, self._is_free.shape[1]), dtype=np.float32)
        for row, skeleton in enumerate(skeletons):
            slot = _slots(skeleton, n_coarse)
            places = (
                skeleton.kind_id,
                slot[skeleton.parent],
                skeleton.depth,
                skeleton.ordinal.clip(max=MOST_SIBLINGS),
                skeleton.twin.clip(max=MOST_SIBLINGS),
            )
            whole[:, row, slot] = np.stack(places)
            mask[row, slot] = True
            weight[row, slot] = self._is_free[skeleton.kind_id]
            on_top[row, slot], lift[row, slot] = self._attachments(skeleton)
        kind, parent, depth, ordinal, twin = torch.from_numpy(whole)
        wish = np.array([scaled_wish(wish) for wish in wishes], dtype=np.float32)
        return TokenBatch(
            kind=kind,
            parent=parent,
            depth=depth,
            ordinal=ordinal,
            twin=twin,
            mask=torch.from_numpy(mask),
            stands_on_top=torch.from_numpy(on_top),
            lift_m=torch.from_numpy(lift),
            domain=torch.tensor([DOMAINS.index(skeleton.domain) for skeleton in skeletons]),
            wish=torch.from_numpy(wish),
            n_coarse_slots=n_coarse,
            weight=torch.from_numpy(weight),
        )

    def _attachments(self, skeleton: Skeleton) -> tuple[np.ndarray, np.ndarray]:
        # Training asks for the same skeletons again and again; answers go with their skeletons,
        # whose identity may be another's then.
        known = self._heights.get(id(skeleton))
        if known is None:
            known = attachment_heights(skeleton, self._vocabulary)
            self._heights[id(skeleton)] = known
            finalize(skeleton, self._heights.pop, id(skeleton)).atexit = False
        return known


def slots_of(skeleton: Skeleton, batch: TokenBatch) -> Int[np.ndarray, " n"]:
    """Slots that the tokens of a skeleton have in a batch."""
    return _slots(skeleton, batch.n_coarse_slots)


def _slots(skeleton: Skeleton, n_coarse_slots: int) -> Int[np.ndarray, " n"]:
    fine = n_coarse_slots + np.arange(len(skeleton) - skeleton.n_coarse)
    return np.concatenate([np.arange(skeleton.n_coarse), fine])
