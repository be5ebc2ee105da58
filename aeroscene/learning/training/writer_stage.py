"""The writer's loss in a training."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import torch

from aeroscene.learning.training.loop import TOTAL, LossTerms
from aeroscene.learning.writer.batch import LessonBatch


def writer_loss(
    model: Callable[..., Any], batch: LessonBatch, generator: torch.Generator
) -> LossTerms:
    """Nats a token, in all and by what is said; the generator seeds what dropout leaves out."""
    seed = int(torch.randint(2**62, (), generator=generator, device=generator.device))
    device = batch.kind.device
    with torch.random.fork_rng(devices=[device] if device.type == "cuda" else []):
        torch.manual_seed(seed)
        nats = model(batch)
    n_tokens = (batch.kind >= 0).sum().clamp(min=1)
    terms = {name: value / n_tokens for name, value in nats.items()}
    return {TOTAL: sum(terms.values(), n_tokens.new_zeros((), dtype=torch.float32))} | terms
