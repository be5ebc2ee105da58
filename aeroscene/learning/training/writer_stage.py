"""The writer's loss in a training, and the threshold below which it never draws a kind."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import torch
from torch import Tensor

from aeroscene.learning.training.loop import TOTAL, LossTerms
from aeroscene.learning.writer.batch import LessonBatch
from aeroscene.learning.writer.config import WriterCfg
from aeroscene.learning.writer.language import Language
from aeroscene.learning.writer.model import new_writer, shares_of_likeliest
from aeroscene.learning.writer.training_set import LessonSet

_LEFT_OUT = 0.06
"""Share of the kinds of held-out programs that may fall below the threshold. A greater share gives
more plausible neighbours and fewer rare kinds."""
_MOST, _AT_ONCE = 96, 8
"""Number of programs for the threshold, in all and at once."""


def writer_loss(
    model: Callable[..., Any], batch: LessonBatch, generator: torch.Generator
) -> LossTerms:
    """Mean negative log-likelihood in nats for each token, in all and by symbol.

    Args:
        model: The writer.
        batch: Programs.
        generator: Seeds the dropout, so that it depends on the step alone.
    """
    seed = int(torch.randint(2**62, (), generator=generator, device=generator.device))
    device = batch.kind.device
    # Dropout draws from the global generator, which is restored afterwards.
    with torch.random.fork_rng(devices=[device] if device.type == "cuda" else []):
        torch.manual_seed(seed)
        nats = model(batch)
    n_tokens = (batch.kind >= 0).sum().clamp(min=1)
    terms = {name: value / n_tokens for name, value in nats.items()}
    return {TOTAL: sum(terms.values(), n_tokens.new_zeros((), dtype=torch.float32))} | terms


def with_fitting_share(
    cfg: WriterCfg, weights: Mapping[str, Tensor], language: Language, held_out: LessonSet
) -> WriterCfg:
    """Return a configuration whose `least_share` suits held-out programs.

    It is lowered so that at most `_LEFT_OUT` of their kinds can never be drawn.
    """
    n_programs = min(len(held_out.examples), _MOST)
    if n_programs == 0:
        return cfg
    with torch.random.fork_rng(devices=[]):
        writer = new_writer(cfg, language)
    writer.load_state_dict(dict(weights))
    writer.eval()
    with torch.no_grad():
        shares = torch.cat(
            [
                shares_of_likeliest(
                    writer, held_out.in_order(start, min(_AT_ONCE, n_programs - start))
                )
                for start in range(0, n_programs, _AT_ONCE)
            ]
        )
    fitting = round(float(shares.quantile(_LEFT_OUT)), 4)
    return replace(cfg, least_share=min(cfg.least_share, fitting))
