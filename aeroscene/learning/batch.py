"""Scenes as padded tensors, the one form in which every network reads them.

Scenes differ in their number of tokens, so a batch pads each of them and says in `mask` which slots
count. Coarse tokens come first, because the networks cut a batch in two at `n_coarse_slots`.
Programs, flat layouts and other projects' baselines share this form; each leaves the fields None
that it does not use.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace

import numpy as np
import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from aeroscene.learning.wishes import Wish

MOST_SIBLINGS = 63
"""Largest place among siblings. Later siblings share this place."""
# Centre and scale of a wish: coarse objects, fine objects, landing areas. Checkpoints were trained
# with these numbers, so changing one changes the meaning of their input.
_WISH_MEAN = np.array([34.0, 113.0, 56.0])
_WISH_SPREAD = np.array([6.0, 22.0, 12.0])


@dataclass(frozen=True)
class TokenBatch:
    """Tokens of several scenes: coarse slots first, then fine ones, each padded at its end.

    `batch` counts scenes, `n` slots, `channels` the continuous numbers of a token. Sequence fields
    are integers that embeddings look up.
    """

    kind: Int[Tensor, "batch n"]
    """Symbol of the token: a kind of the vocabulary, or a category in a flat layout."""
    parent: Int[Tensor, "batch n"]
    """Slot of the parent. The site is in slot 0; it and padding have parent 0."""
    depth: Int[Tensor, "batch n"]
    """Number of ancestors."""
    ordinal: Int[Tensor, "batch n"]
    """Place among the children of the parent, 0 to `MOST_SIBLINGS`."""
    twin: Int[Tensor, "batch n"]
    """Place among the siblings that have the same kind, 0 to `MOST_SIBLINGS`."""
    mask: Bool[Tensor, "batch n"]
    """True in slots that hold a token."""
    domain: Int[Tensor, " batch"]
    """Place of the scene's domain among `DOMAINS`."""
    wish: Float[Tensor, "batch 3"]
    """Wished numbers of coarse objects, fine objects and landing areas, standardised."""
    n_coarse_slots: int
    """Slots from this one on hold fine tokens."""
    x0: Float[Tensor, "batch n channels"] | None = None
    """Clean values of the channels, the target of the training; None while sampling."""
    weight: Float[Tensor, "batch n channels"] | None = None
    """Weight of an error of each channel, 0 to 1. It is 0 in padding and where a channel does not
    vary."""
    extra: Int[Tensor, "batch n 3"] | None = None
    """Three more symbols of a program's token: member, rank of the host, and array."""
    turn: Int[Tensor, "batch n"] | None = None
    """Quarter turn of each object of a flat layout. It is a condition, as the category is."""
    frame: Float[Tensor, "batch n 7"] | None = None
    """Frame of each object of a flat layout, m: origin, cosine and sine of yaw, half extents."""
    held: Float[Tensor, "batch n categories"] | None = None
    """Number of objects of each category in each region of a flat layout, shown or not."""
    given: Bool[Tensor, "batch n"] | None = None
    """True for objects whose `x0` is known: coarse ones while fine ones are drawn."""

    @property
    def n_scenes(self) -> int:
        """Number of scenes in the batch."""
        return self.kind.shape[0]

    def to(self, device: torch.device | str, *, non_blocking: bool = False) -> TokenBatch:
        """Copy the batch to another device.

        Args:
            device: Device of the copy.
            non_blocking: Let the processor go on while a GPU copies; needs `pinned` memory.
        """
        return self._with_each(lambda value: value.to(device, non_blocking=non_blocking))

    def pinned(self) -> TokenBatch:
        """Copy the batch to page-locked memory.

        A GPU reads such memory by itself, so the processor can prepare the next batch meanwhile.
        """
        return self._with_each(lambda value: value.pin_memory())

    def scenes(self, some: slice) -> TokenBatch:
        """Select scenes of the batch by a slice over its first axis."""
        return self._with_each(lambda value: value[some])

    def _with_each(self, change: Callable[[Tensor], Tensor]) -> TokenBatch:
        changed = {
            field.name: change(value)
            for field in fields(self)
            if isinstance(value := getattr(self, field.name), Tensor)
        }
        return replace(self, **changed)


def scaled_wish(wish: Wish) -> Float[np.ndarray, " 3"]:
    """Standardise a wish for the networks: coarse objects, fine objects, landing areas."""
    return (np.array([wish.n_coarse, wish.n_fine, wish.n_areas]) - _WISH_MEAN) / _WISH_SPREAD
