"""The loss on scenes that are not trained on, which shows when a model begins to memorise."""

from __future__ import annotations

from collections.abc import Sized
from typing import Any, Protocol

import torch
from torch.func import functional_call

from aeroscene.learning.training.batches.source import Batch
from aeroscene.learning.training.loop import TOTAL, LossFunction, PartTraining

# Times and noise of every measurement are equal, so that differences are the weights'.
_SEED = 20260
_MOST = 48
"""Number of scenes that are measured; they take a second of one core."""


class HeldOutSet(Protocol):
    """Scenes that are not trained on."""

    @property
    def examples(self) -> Sized:
        """The scenes; only their number is read."""
        ...

    def in_order(self, start: int, size: int) -> Batch:
        """Return at most `size` scenes from a place on."""
        ...


def held_out_loss(training: PartTraining, data: HeldOutSet, loss: LossFunction) -> float | None:
    """Return the mean loss of the averaged weights on held-out scenes.

    Times and noise are the same on every call.

    Returns:
        None if there are no such scenes.
    """
    n_scenes = min(len(data.examples), _MOST)
    if n_scenes == 0:
        return None
    total = 0.0
    generator = torch.Generator(training.device).manual_seed(_SEED)

    # The model runs with other weights, without a second copy of it.
    def averaged(*args: Any) -> Any:
        return functional_call(training.model, training.average.weights, args)

    training.model.eval()
    with torch.no_grad():
        for start in range(0, n_scenes, training.cfg.batch_size):
            size = min(training.cfg.batch_size, n_scenes - start)
            batch = data.in_order(start, size).to(training.device)
            total += float(loss(averaged, batch, generator)[TOTAL]) * size
    training.model.train()
    return total / n_scenes
