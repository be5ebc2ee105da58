"""Scenes as padded tensors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace

import numpy as np
import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from aeroscene.learning.wishes import Wish

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
    domain: Int[Tensor, " batch"]
    wish: Float[Tensor, "batch 3"]
    """Objects coarse and fine, and landing areas wished for, standardised."""
    n_coarse_slots: int
    x0: Float[Tensor, "batch n channels"] | None = None
    weight: Float[Tensor, "batch n channels"] | None = None
    """How much an error of a channel counts, up to 1; 0 where it does not vary, and in padding."""
    extra: Int[Tensor, "batch n 3"] | None = None
    """Of tokens of programs member, rank of the host, and array."""
    turn: Int[Tensor, "batch n"] | None = None
    """Quarter turn of each object of a flat layout, which is given as its category is."""
    frame: Float[Tensor, "batch n 7"] | None = None
    """Frame of each object of a flat layout: origin, cosine, sine of the yaw, half extents; m."""
    held: Float[Tensor, "batch n categories"] | None = None
    """How many objects of each category are in each region of a flat layout, shown or not."""
    given: Bool[Tensor, "batch n"] | None = None
    """Objects of a flat layout whose `x0` is known: the coarse ones while fine ones are made."""

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
