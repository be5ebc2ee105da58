"""A recurrent reader of a growing tree that says at which depth and of which kind the next is."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from aeroscene.learning.skeleton.bucket import N_BUCKETS
from aeroscene.learning.skeleton.config import SkeletonCfg

_COUNT_WIDTH = 12
_BAG_WIDTH = 32


class Stage(nn.Module):
    """One of the two stages; `t` steps at once in training, one at a time in sampling."""

    def __init__(self, cfg: SkeletonCfg, n_kinds: int, n_levels: int, context: int) -> None:
        super().__init__()
        level_width = cfg.kind_width + _COUNT_WIDTH
        seen = n_levels * level_width + n_levels + 3 * _COUNT_WIDTH + 3 + context
        self.n_levels = n_levels
        self.count = nn.Embedding(N_BUCKETS, _COUNT_WIDTH)
        self.read = nn.Sequential(nn.Linear(seen, cfg.width), nn.GELU(), nn.Dropout(cfg.dropout))
        between = cfg.dropout if cfg.layers > 1 else 0.0
        self.recur = nn.GRU(cfg.width, cfg.width, cfg.layers, batch_first=True, dropout=between)
        self.drop = nn.Dropout(cfg.dropout)
        self.depth = nn.Sequential(
            nn.Linear(2 * cfg.width, cfg.width), nn.GELU(), nn.Linear(cfg.width, n_levels - 1)
        )
        self.bag = nn.Linear(n_kinds, _BAG_WIDTH, bias=False)
        local = 2 * cfg.kind_width + _COUNT_WIDTH + n_levels + _BAG_WIDTH
        self.kind = nn.Sequential(
            nn.Linear(2 * cfg.width + local, cfg.width),
            nn.GELU(),
            nn.Dropout(cfg.dropout),
            nn.Linear(cfg.width, cfg.kind_width),
        )
        self.bias = nn.Parameter(torch.zeros(n_kinds))

    def forward(
        self,
        view: Sequence[Tensor],
        context: Float[Tensor, "b t c"],
        table: Float[Tensor, "kinds_and_none w"],
        state: Tensor | None = None,
    ) -> tuple[Float[Tensor, "b t h"], Tensor]:
        """What the heads need to know at each step, and where the last one ended.

        `state` is where the steps before ended; None at the beginning.
        """
        path, n_children, depth, counts, flags, _, pressure = view
        seen = torch.cat(
            [
                table[path].flatten(-2),
                self.count(n_children).flatten(-2),
                nn.functional.one_hot(depth, self.n_levels),
                self.count(counts).flatten(-2),
                flags,
                pressure.unsqueeze(-1),
                context,
            ],
            dim=-1,
        )
        now = self.read(seen)
        past, end = self.recur(now, state)
        return self.drop(torch.cat([now, past], dim=-1)), end

    def depth_logits(self, known: Float[Tensor, "*b h"]) -> Float[Tensor, "*b depths"]:
        """Logits of the depths from 1."""
        return self.depth(known)

    def kind_logits(
        self,
        known: Float[Tensor, "*b h"],
        depth: Int[Tensor, "*b"],
        siblings: Sequence[Tensor],
        table: Float[Tensor, "kinds_and_none w"],
    ) -> Float[Tensor, "*b kinds"]:
        """Logits of the kind of an object at a depth from 1, among siblings that are there."""
        parent, last, n_siblings, bag = siblings
        local = [
            known,
            table[parent],
            table[last],
            self.count(n_siblings),
            nn.functional.one_hot(depth, self.n_levels),
            self.bag(torch.log1p(bag.to(known.dtype))),
        ]
        return self.kind(torch.cat(local, dim=-1)) @ table[:-1].T + self.bias
