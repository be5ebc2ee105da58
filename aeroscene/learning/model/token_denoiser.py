"""The default network: hierarchy blocks over the tokens of a program."""

from __future__ import annotations

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.diffusion.loss import Prediction
from aeroscene.learning.model.config import ModelCfg
from aeroscene.learning.model.embedding import ProgramEmbedding
from aeroscene.learning.model.hierarchy import HierarchyBlock
from aeroscene.learning.model.relations import Relations, relations_of


class TokenDenoiser(nn.Module):
    """Embedding, alternating top-down and bottom-up `HierarchyBlock`s, a linear head.

    The paper's UNet over a list of tokens is left out. A list has no neighbourhood that a
    convolution could use, and the blocks already relate every token to its kin.
    """

    def __init__(self, cfg: ModelCfg, embedding: ProgramEmbedding) -> None:
        super().__init__()
        self.cfg = cfg
        self.embedding = embedding
        self.blocks = nn.ModuleList(
            HierarchyBlock(cfg.width, cfg.heads, cfg.ffn_ratio, is_top_down=i % 2 == 0)
            for i in range(cfg.blocks)
        )
        self.modulation = nn.Linear(cfg.width, 2 * cfg.width + cfg.channels)
        self.head = nn.Linear(cfg.width, cfg.channels)
        self._known: tuple[TokenBatch, Relations] | None = None
        for layer in (self.modulation, self.head):
            nn.init.zeros_(layer.weight)
            nn.init.zeros_(layer.bias)

    def forward(
        self, x_t: Float[Tensor, "batch n channels"], t: Float[Tensor, " batch"], batch: TokenBatch
    ) -> Prediction:
        """Predict for a batch of noisy layouts; the result is zero before training.

        Args:
            x_t: Noisy standardised channels.
            t: Time of each scene, 0 clean to 1 noise.
            batch: Tokens with `extra`.
        """
        real = batch.mask.unsqueeze(-1)
        # Padding may hold noise, which the parents' channels would read.
        x_t = x_t * real
        relations = self._relations(batch)
        condition = self.embedding.condition(t, batch)
        token = self.embedding(x_t, batch)
        coarse, fine = token.split(
            [batch.n_coarse_slots, token.shape[1] - batch.n_coarse_slots], dim=1
        )
        for block in self.blocks:
            coarse, fine = block(coarse, fine, condition, relations)
        return Prediction(self._head(torch.cat([coarse, fine], 1), condition, x_t) * real)

    def _relations(self, batch: TokenBatch) -> Relations:
        """Return the masks of a batch, kept because sampling asks for the same at every step."""
        known = self._known
        if known is None or known[0] is not batch:
            cfg = self.cfg
            found = relations_of(batch, cfg.heads, cfg.width, cfg.has_narrow_heads)
            self._known = known = (batch, found)
        return known[1]

    def _head(
        self,
        token: Float[Tensor, "batch n d"],
        condition: Float[Tensor, "batch d"],
        x_t: Float[Tensor, "batch n channels"],
    ) -> Float[Tensor, "batch n channels"]:
        width = token.shape[-1]
        parts = self.modulation(condition).unsqueeze(1)
        shift, scale, gain = parts.split([width, width, x_t.shape[-1]], dim=-1)
        level = functional.layer_norm(token, (width,))
        # Much of the target follows from x_t and the time alone. A term of its own spares the
        # blocks from carrying x_t through.
        return torch.addcmul(self.head(torch.addcmul(shift, level, 1.0 + scale)), gain, x_t)
