"""Sentences of contents as padded tensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from aeroscene.learning.batch import scaled_wish
from aeroscene.learning.paper.contents.sentences import Sentence
from aeroscene.learning.wishes import Wish
from aeroscene.scene import DOMAINS


@dataclass(frozen=True)
class SentenceBatch:
    """Sentences as padded tensors, with the domain and wish of each scene."""

    token: Int[Tensor, "batch n"]
    """Token numbers; -1 in padding."""
    place: Int[Tensor, "batch n"]
    """Place of the list that each token is in, see `sentences`."""
    domain: Int[Tensor, " batch"]
    wish: Float[Tensor, "batch 3"]

    def to(self, device: torch.device | str, *, non_blocking: bool = False) -> SentenceBatch:
        """Copy the batch to another device."""
        move = {"device": device, "non_blocking": non_blocking}
        return SentenceBatch(
            self.token.to(**move),
            self.place.to(**move),
            self.domain.to(**move),
            self.wish.to(**move),
        )

    def pinned(self) -> SentenceBatch:
        """Copy the batch to page-locked memory, which a GPU reads while the processor goes on."""
        return SentenceBatch(
            self.token.pin_memory(),
            self.place.pin_memory(),
            self.domain.pin_memory(),
            self.wish.pin_memory(),
        )


def sentence_batch(sentences: Sequence[Sentence], wishes: Sequence[Wish]) -> SentenceBatch:
    """Pad sentences and add domain and wish of their scenes."""
    length = max(len(each.token) for each in sentences)
    token = np.full((len(sentences), length), -1, dtype=np.int64)
    place = np.zeros((len(sentences), length), dtype=np.int64)
    for row, each in enumerate(sentences):
        token[row, : len(each.token)], place[row, : len(each.token)] = each.token, each.place
    scaled = np.array([scaled_wish(wish) for wish in wishes], dtype=np.float32)
    return SentenceBatch(
        torch.from_numpy(token),
        torch.from_numpy(place),
        torch.tensor([DOMAINS.index(wish.domain) for wish in wishes]),
        torch.from_numpy(scaled),
    )
