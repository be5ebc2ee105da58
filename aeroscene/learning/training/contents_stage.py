"""The loss of the contents model in a training."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import torch

from aeroscene.learning.paper.contents.batch import SentenceBatch
from aeroscene.learning.training.loop import TOTAL, LossTerms


def contents_loss(
    model: Callable[..., Any],
    batch: SentenceBatch,
    generator: torch.Generator,  # noqa: ARG001 - of the protocol
) -> LossTerms:
    """Mean negative log-likelihood, in nats for each token."""
    n_tokens = (batch.token >= 0).sum().clamp(min=1)
    return {TOTAL: model(batch).sum() / n_tokens}
