"""The training of a network, step by step: the paper's algorithm 1.

Batch, time and noise of step k come from the seed and k alone. A training that was stopped and
continued therefore takes the same steps as an unbroken one, if its length is given in steps. If it
is given in minutes, the learning rate follows the clock.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from aeroscene.learning.training.average import MovingAverage
from aeroscene.learning.training.batches.source import Batch, Batches, StoppedError
from aeroscene.learning.training.best import Best
from aeroscene.learning.training.config import Budget, TrainCfg, TrainingError
from aeroscene.learning.training.rates import rate_factor

LossTerms = Mapping[str, Tensor]
"""Terms of the loss by name; `total` is minimised."""
LossFunction = Callable[[Callable[..., Any], Any, torch.Generator], LossTerms]
"""Loss of a network on a batch that it reads; the network may run with other weights."""

TOTAL = "total"


@dataclass(frozen=True, slots=True, kw_only=True)
class StepReport:
    """Report of one step."""

    step: int
    """Counted from 1."""
    seconds: float
    """Time spent on training until now, over all its runs."""
    share: float
    """Share of the training that is done."""
    losses: Mapping[str, Tensor]
    """Terms of the loss, still on the device: reading them waits for it."""
    gradient_norm: Tensor
    learning_rate: float


@dataclass
class PartTraining:
    """A network in training: everything that changes from step to step."""

    model: nn.Module
    cfg: TrainCfg
    device: torch.device
    step: int = 0
    """Steps done."""
    seconds: float = 0.0
    """Time spent on these steps."""
    average: MovingAverage = field(init=False)
    """Moving average of the weights."""
    best: Best = field(init=False)
    """Weights with the least held-out loss."""
    optimiser: torch.optim.Optimizer = field(init=False)
    called: Callable[..., Any] = field(init=False)
    """The network as a step calls it, compiled if `is_compiled`."""

    def __post_init__(self) -> None:
        self.model.to(self.device).train()
        # Batches have any number of scenes and objects, so one program is compiled for all shapes.
        is_compiled = self.cfg.is_compiled
        self.called = torch.compile(self.model, dynamic=True) if is_compiled else self.model
        self.average = MovingAverage(self.model, self.cfg.average_decay)
        self.best = Best(keeps_weights=self.cfg.keep == "best")
        kind = torch.optim.AdamW if self.cfg.optimiser == "adamw" else torch.optim.Adam
        self.optimiser = kind(
            self.model.parameters(),
            lr=self.cfg.learning_rate,
            betas=(0.9, self.cfg.second_decay),
            weight_decay=self.cfg.weight_decay,
            fused=True,
        )

    def advance(self, batches: Batches, loss: LossFunction, budget: Budget) -> StepReport:
        """Take one step.

        Args:
            batches: Gives the batch of the step.
            loss: Loss of a batch.
            budget: Length of the training, which the learning rate follows.

        Raises:
            StoppedError: If the user wants the training to end before there is a batch.
            TrainingError: If the loss is not finite any more.
        """
        # The rate follows the share of the training before this step.
        share = budget.share(self.step, self.seconds)
        rate = self.cfg.learning_rate * rate_factor(
            self.cfg.schedule,
            share,
            self.step,
            warmup_steps=self.cfg.warmup_steps,
            cooldown_share=self.cfg.cooldown_share,
        )
        for group in self.optimiser.param_groups:
            group["lr"] = rate
        terms = self._terms(batches(self.step), loss)
        self.optimiser.zero_grad(set_to_none=True)
        terms[TOTAL].backward()
        longest = self.cfg.clip_norm or math.inf
        norm = nn.utils.clip_grad_norm_(self.model.parameters(), longest)
        # Before the optimiser steps: a gradient that is not finite would spoil every weight.
        self._check(norm, rate)
        self.optimiser.step()
        self.step += 1
        self.average.update(self.step)
        return StepReport(
            step=self.step,
            seconds=self.seconds,
            share=budget.share(self.step, self.seconds),
            losses={name: term.detach() for name, term in terms.items()},
            gradient_norm=norm,
            learning_rate=rate,
        )

    @property
    def kept(self) -> Mapping[str, Tensor]:
        """Weights that generate: the best ones, or the last average if none were kept."""
        return self.best.weights or self.average.weights

    def _terms(self, batch: Batch, loss: LossFunction) -> LossTerms:
        generator = noise_generator(self.cfg.seed, self.step, self.device)
        precision = self.cfg.precision
        is_mixed = precision == "mixed" or (precision == "auto" and self.device.type == "cuda")
        with torch.autocast(self.device.type, torch.bfloat16, enabled=is_mixed):
            return loss(self.called, batch.to(self.device), generator)

    def _check(self, norm: Tensor, rate: float) -> None:
        # On the processor every step; on a GPU now and then, because the check waits for it.
        if self.device.type != "cpu" and self.step % 50:
            return
        if not math.isfinite(float(norm)):
            raise TrainingError(
                f"gradient is {float(norm)} in step {self.step + 1} at a learning rate of "
                f"{rate:.3g}; valid: finite; lower learning_rate or clip_norm, then --resume"
            )


def noise_generator(seed: int, step: int, device: torch.device) -> torch.Generator:
    """Return the random generator of times and noise of a step."""
    # The last entry keeps this stream apart from that of the batches.
    number = int(np.random.SeedSequence([seed, step, 1]).generate_state(1, np.uint64)[0])
    return torch.Generator(device).manual_seed(number >> 1)


def train_steps(
    training: PartTraining,
    batches: Batches,
    loss: LossFunction,
    budget: Budget,
    on_step: Callable[[StepReport], bool],
    clock: Callable[[], float],
) -> None:
    """Train until the budget is spent or `on_step` returns False.

    Args:
        training: The training, which is advanced.
        batches: Gives the batch of each step.
        loss: Loss of a batch.
        budget: Length of the training.
        on_step: Called after each step; False ends the training.
        clock: Seconds that count for the budget, and for nothing else.

    Raises:
        TrainingError: If the loss is not finite any more.
    """
    before_s = clock()
    # The clock also runs through `on_step`, so that logging and saving count as training.
    while budget.share(training.step, training.seconds) < 1.0:
        try:
            report = training.advance(batches, loss, budget)
        except StoppedError:
            return
        now_s = clock()
        training.seconds += now_s - before_s
        before_s = now_s
        if not on_step(report):
            return
