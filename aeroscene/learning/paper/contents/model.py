"""The recurrent network that models contents, and draws them.

A masked softmax allows only tokens that the grammar permits at each step, so every drawn sentence
can be read. A wish is only a condition, which a draw may miss. Therefore several sentences are
drawn together, and the nearest to the wish is kept.
"""

from __future__ import annotations

import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor, nn

from aeroscene.learning.batch import scaled_wish
from aeroscene.learning.paper.channels import FlatStatistics
from aeroscene.learning.paper.contents.batch import SentenceBatch
from aeroscene.learning.paper.contents.config import ContentsCfg
from aeroscene.learning.paper.contents.sentences import (
    COARSE_LIST,
    N_TOKENS,
    SITE,
    Contents,
    Reading,
    allowed,
)
from aeroscene.learning.wishes import Wish
from aeroscene.scene import DOMAINS

N_DRAWN = 8
"""Sentences that are drawn for a wish; the nearest one is kept."""
# A sentence that has not ended by then is read as it is.
_MOST_TOKENS = 1200


class ContentsModel(nn.Module):
    """P(contents | domain, wished numbers), token by token."""

    permitted: Tensor

    def __init__(self, cfg: ContentsCfg) -> None:
        super().__init__()
        width = cfg.width
        self.layers = cfg.layers
        self.token = nn.Embedding(1 + N_TOKENS, width)
        self.place = nn.Embedding(1 + SITE, width)
        self.domain = nn.Embedding(len(DOMAINS), width)
        self.wish = nn.Linear(3, width)
        self.recurrent = nn.GRU(width, width, cfg.layers, batch_first=True)
        self.norm = nn.LayerNorm(width)
        self.outward = nn.Linear(width, N_TOKENS)
        rows = np.stack([allowed(0, COARSE_LIST), allowed(2, COARSE_LIST), allowed(2, SITE)])
        self.register_buffer("permitted", torch.from_numpy(rows), persistent=False)

    def forward(self, batch: SentenceBatch) -> Float[Tensor, " batch"]:
        """Negative log-likelihood of each sentence, in nats."""
        # The input is shifted by one: 0 begins a sentence, and token k is k + 1.
        before = torch.cat([batch.token.new_zeros(len(batch.token), 1), batch.token[:, :-1] + 1], 1)
        feature, _ = self._advance(before.clamp(min=0), batch.place, batch, None)
        step = torch.arange(batch.token.shape[1], device=batch.token.device)
        logits = self._permitted(self.outward(self.norm(feature)), step, batch.place)
        nats = nn.functional.cross_entropy(
            logits.transpose(1, 2), batch.token, ignore_index=-1, reduction="none"
        )
        return nats.sum(1)

    def _advance(
        self, before: Tensor, place: Tensor, batch: SentenceBatch, state: Tensor | None
    ) -> tuple[Tensor, Tensor]:
        known = (self.domain(batch.domain) + self.wish(batch.wish)).unsqueeze(1)
        return self.recurrent(self.token(before) + self.place(place) + known, state)

    def _permitted(self, logits: Tensor, step: Tensor, place: Tensor) -> Tensor:
        phase = torch.where(place == COARSE_LIST, 1, 2)
        phase = torch.where((step < 2).expand_as(phase), 0, phase)
        return logits.masked_fill(~self.permitted[phase], torch.finfo(logits.dtype).min)

    @torch.no_grad()
    def draw(
        self,
        wish: Wish,
        statistics: FlatStatistics,
        is_usable: Bool[np.ndarray, " categories"],
        generator: torch.Generator,
    ) -> Contents:
        """Draw contents for a wish.

        `N_DRAWN` sentences are drawn. The one whose numbers of coarse and fine objects come nearest
        to the wish is kept.

        Args:
            wish: Domain and numbers of objects.
            statistics: Statistics of the training scenes.
            is_usable: Categories that may be drawn, by their numbers from 1.
            generator: Source of the draw.
        """
        device = self.permitted.device
        scaled = torch.from_numpy(np.asarray(scaled_wish(wish), dtype=np.float32))
        batch = SentenceBatch(
            token=torch.zeros((N_DRAWN, 1), dtype=torch.int64, device=device),
            place=torch.zeros((N_DRAWN, 1), dtype=torch.int64, device=device),
            domain=torch.full((N_DRAWN,), DOMAINS.index(wish.domain), device=device),
            wish=scaled.to(device).expand(N_DRAWN, 3),
        )
        banned = torch.zeros(N_TOKENS, dtype=torch.bool, device=device)
        # Four tokens for each category, one for each quarter turn.
        banned[: 4 * (len(is_usable) - 1)] = torch.from_numpy(~is_usable[1:]).repeat_interleave(4)
        readings = [Reading(statistics) for _ in range(N_DRAWN)]
        before, state = batch.token, None
        for step in range(_MOST_TOKENS):
            # Finished sentences are padded with a harmless place; what they draw is not read.
            place = [[COARSE_LIST if each.is_done else each.place] for each in readings]
            places = torch.tensor(place, device=device)
            feature, state = self._advance(before, places, batch, state)
            number = torch.tensor([step], device=device)
            logits = self._permitted(self.outward(self.norm(feature)), number, places)[:, 0]
            chance = logits.masked_fill(banned, -torch.inf).softmax(-1)
            token = torch.multinomial(chance, 1, generator=generator)
            share = torch.rand(N_DRAWN, generator=generator, device=device).tolist()
            for each, drawn, at in zip(readings, token[:, 0].tolist(), share, strict=True):
                if not each.is_done:
                    each.take(drawn, at)
            if all(each.is_done for each in readings):
                break
            before = token + 1
        return min((each.contents for each in readings), key=lambda found: _off(found, wish))


def _off(contents: Contents, wish: Wish) -> int:
    n_fine = len(contents.category) - contents.n_coarse
    # An empty scene is the last resort.
    empty = 10**6 * (len(contents.category) == 0)
    return abs(contents.n_coarse - wish.n_coarse) + abs(n_fine - wish.n_fine) + empty
