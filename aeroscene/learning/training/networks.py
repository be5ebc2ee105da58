"""The denoiser of each preset."""

from __future__ import annotations

import torch
from torch import nn

from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.model.config import ModelCfg
from aeroscene.learning.model.embedding import ProgramEmbedding
from aeroscene.learning.model.token_denoiser import TokenDenoiser
from aeroscene.learning.paper.channels import FlatStatistics
from aeroscene.learning.paper.network.layout_denoiser import LayoutDenoiser
from aeroscene.learning.writer.language import Language
from aeroscene.learning.writer.model import program_traits


def new_denoiser(cfg: ModelCfg, known: Language | FlatStatistics, schedule: Schedule) -> nn.Module:
    """Build the network that a configuration describes, with its first weights.

    It is called as `aeroscene.learning.diffusion.loss.Denoiser`. On CPUs with bfloat16 units
    (avx512_bf16) training under `torch.autocast("cpu", torch.bfloat16)` takes about 0.6 of the time
    of single precision.

    Args:
        cfg: Shape of the network.
        known: Language or statistics of the data.
        schedule: Noise schedule, which the paper's network has within it.
    """
    if isinstance(known, FlatStatistics):
        return LayoutDenoiser(cfg, known, schedule)
    vocabulary, statistics = known.vocabulary, known.statistics
    embedding = ProgramEmbedding(cfg, program_traits(vocabulary), len(vocabulary.shapes))
    scales = (torch.from_numpy(each) for each in (statistics.mean, statistics.spread))
    embedding.use_statistics(*scales)
    return TokenDenoiser(cfg, embedding)
