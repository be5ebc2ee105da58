"""FLOP of a training step, counted beside the training, so that methods can be compared by work.

The count leaves weights and the state of the optimiser as they were.
"""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch.utils.flop_counter import FlopCounterMode

from aeroscene.learning.training.batches.source import Batch
from aeroscene.learning.training.loop import TOTAL, LossFunction, PartTraining, noise_generator


def flop_per_step(training: PartTraining, batches: Sequence[Batch], loss: LossFunction) -> float:
    """Mean FLOP of a step forwards and backwards.

    Matrix products, convolutions and attention count. Attention counts by its definition, whatever
    kernel computes it.

    Args:
        training: The training whose model and device are used.
        batches: Batches to average over; at least one.
        loss: Loss of a batch; its term `total` is differentiated.
    """
    model, device = training.model, training.device
    was_training = model.training
    model.train()
    total = 0
    for number, batch in enumerate(batches):
        generator = noise_generator(training.cfg.seed, number, device)
        with torch.enable_grad(), FlopCounterMode(display=False) as counter:
            loss(model, batch.to(device), generator)[TOTAL].backward()
        total += counter.get_total_flops()
    model.zero_grad(set_to_none=True)
    model.train(was_training)
    return total / len(batches)
