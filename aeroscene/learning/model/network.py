"""The denoiser of either preset."""

from __future__ import annotations

import torch
from jaxtyping import Float
from torch import Tensor, nn

from aeroscene.learning.diffusion.loss import Prediction
from aeroscene.learning.model.config import ModelCfg
from aeroscene.learning.model.token_denoiser import TokenDenoiser
from aeroscene.learning.paper.network.layout_denoiser import LayoutDenoiser
from aeroscene.learning.tokens.batch import TokenBatch
from aeroscene.learning.tokens.kinds import Vocabulary
from aeroscene.learning.tokens.statistics import Statistics


class HierarchicalDenoiser(nn.Module):
    """Noisy layout in, prediction out, by the network that a configuration describes.

    On CPUs with bfloat16 units (avx512_bf16) training under
    `torch.autocast("cpu", torch.bfloat16)` takes about 0.6 of the time of single precision.
    """

    def __init__(self, cfg: ModelCfg) -> None:
        super().__init__()
        self.cfg = cfg
        self.network = TokenDenoiser(cfg) if cfg.denoiser == "tokens" else LayoutDenoiser(cfg)

    def forward(
        self,
        x_t: Float[Tensor, "batch n channels"],
        t: Float[Tensor, " batch"],
        batch: TokenBatch,
    ) -> Prediction:
        """Predict for a batch of noisy layouts.

        Args:
            x_t: Noisy channels.
            t: Diffusion time of each scene, 0 (clean) to 1 (noise): the paper's t / T.
            batch: The tokens.
        """
        return self.network(x_t, t, batch)

    def use_statistics(self, vocabulary: Vocabulary, statistics: Statistics) -> None:
        """Tell the default network how channels are read; nothing to the paper's.

        What it is told is saved with its weights.
        """
        if not isinstance(self.network, TokenDenoiser):
            return
        scales = (statistics.mean, statistics.spread * statistics.is_free)
        mean, spread = (torch.from_numpy(array).float() for array in scales)
        is_aligned = torch.tensor([kind.is_aligned for kind in vocabulary.kinds])
        self.network.embedding.use_statistics(
            mean, spread, torch.from_numpy(statistics.is_relative), is_aligned
        )
