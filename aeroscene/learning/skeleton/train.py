"""Training of the skeleton model: AdamW, a cosine, the best weights on a held-out part."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import torch

from aeroscene.learning.skeleton.config import SkeletonCfg, SkeletonError, SkeletonTrainingCfg
from aeroscene.learning.skeleton.embedding import kind_traits
from aeroscene.learning.skeleton.grammar import learn_grammar
from aeroscene.learning.skeleton.lesson import lesson_of
from aeroscene.learning.skeleton.loss import skeleton_loss
from aeroscene.learning.skeleton.model import SkeletonModel
from aeroscene.learning.skeleton.sequence import to_device
from aeroscene.learning.tokens.kinds import Vocabulary
from aeroscene.learning.tokens.skeleton import Skeleton, Wish

_WARM_UP = 0.03
"""Share of the training in which the learning rate rises."""
_LONGEST_GRADIENT = 1.0

Example = tuple[Skeleton, Wish]


@dataclass(frozen=True, slots=True, kw_only=True)
class SkeletonProgress:
    """How far a training is."""

    step: int
    share: float
    """Share of the training that is behind, 0 to 1."""
    loss: float
    """Loss of the last batch, nats an object."""
    held_out: float | None
    """Loss of the held-out part, nats an object, where this step looked at it."""


@dataclass(frozen=True, slots=True)
class TrainedSkeletonModel:
    """A model with the weights that were best on the held-out part."""

    model: SkeletonModel
    held_out: float
    """Surprise of those weights at the held-out part, nats an object."""
    steps: int
    """Steps of the whole training."""


def train_skeleton(
    examples: Sequence[Example],
    vocabulary: Vocabulary,
    generator: np.random.Generator,
    cfg: SkeletonCfg | None = None,
    training: SkeletonTrainingCfg | None = None,
    device: torch.device | str = "cpu",
    on_step: Callable[[SkeletonProgress], bool] | None = None,
    clock: Callable[[], float] = time.process_time,
) -> TrainedSkeletonModel:
    """Train a model on skeletons of scenes with what each scene has.

    With a budget in steps the same generator gives the same weights on the same device. After each
    step `on_step` is called, whose true ends the training. The budget counts seconds of the clock:
    those of this process, unless told otherwise.

    Raises:
        SkeletonError: If there are too few examples, or the loss does not stay finite.
    """
    if len(examples) < 2:
        raise SkeletonError(f"there are {len(examples)} skeletons to learn from, valid: from 2 on")
    training = training or SkeletonTrainingCfg()
    device = torch.device(device)
    with torch.random.fork_rng([device] if device.type == "cuda" else []):
        torch.manual_seed(int(generator.integers(2**31)))
        grammar = learn_grammar(vocabulary, [skeleton for skeleton, _ in examples])
        model = SkeletonModel(cfg or SkeletonCfg(), grammar, kind_traits(vocabulary)).to(device)
        run = _Run(model, training, *_split(examples, training.held_out, generator))
        run.train(generator, on_step or (lambda _: False), clock)
    return run.result()


def _split(
    examples: Sequence[Example], share: float, generator: np.random.Generator
) -> tuple[list[Example], list[Example]]:
    order = generator.permutation(len(examples)).tolist()
    n_held_out = max(1, round(share * len(examples)))
    return [examples[i] for i in order[n_held_out:]], [examples[i] for i in order[:n_held_out]]


def _batches(
    examples: Sequence[Example], size: int, generator: np.random.Generator
) -> Iterator[list[Example]]:
    """Batches without end: every example once, in a new order, again and again."""
    size = min(size, len(examples))
    while True:
        order = generator.permutation(len(examples))
        for start in range(0, len(order) - size + 1, size):
            yield [examples[i] for i in order[start : start + size]]


@dataclass
class _Run:
    model: SkeletonModel
    cfg: SkeletonTrainingCfg
    seen: list[Example]
    held_out: list[Example]
    best: float = math.inf
    weights: dict[str, Any] = field(default_factory=dict)
    steps: int = 0

    def train(
        self,
        generator: np.random.Generator,
        on_step: Callable[[SkeletonProgress], bool],
        clock: Callable[[], float],
    ) -> None:
        optimiser = self._optimiser()
        begin, n_looks, share = clock(), 0, 0.0
        for batch in _batches(self.seen, self.cfg.batch, generator):
            for group in optimiser.param_groups:
                group["lr"] = self.cfg.learning_rate * _rate(share)
            loss = self._step(batch, optimiser)
            self.steps += 1
            share = self.cfg.spent(self.steps, clock() - begin)
            held_out = None
            if share * self.cfg.looks >= n_looks + 1:
                n_looks = int(share * self.cfg.looks)
                held_out = self._look()
            progress = SkeletonProgress(
                step=self.steps, share=min(share, 1.0), loss=loss, held_out=held_out
            )
            if on_step(progress) or share >= 1.0:
                break
        if not self.weights:
            self._look()

    def result(self) -> TrainedSkeletonModel:
        self.model.load_state_dict(self.weights)
        return TrainedSkeletonModel(self.model.eval(), self.best, self.steps)

    def _optimiser(self) -> torch.optim.AdamW:
        parameters = list(self.model.parameters())
        groups = [
            {"params": [p for p in parameters if p.ndim > 1]},
            {"params": [p for p in parameters if p.ndim <= 1], "weight_decay": 0.0},
        ]
        return torch.optim.AdamW(
            groups, betas=(0.9, 0.99), weight_decay=self.cfg.weight_decay, fused=False
        )

    def _step(self, batch: Sequence[Example], optimiser: torch.optim.AdamW) -> float:
        self.model.train()
        loss = self._loss(batch)
        if not math.isfinite(loss.item()):
            raise SkeletonError(
                f"loss is {loss.item()} after {self.steps} steps, valid: a finite number; a "
                f"learning_rate below {self.cfg.learning_rate:g} may do"
            )
        optimiser.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(self.model.parameters(), _LONGEST_GRADIENT)
        optimiser.step()
        return loss.item()

    def _look(self) -> float:
        """Surprise at the held-out part; the weights are kept if there were none better."""
        self.model.eval()
        size = self.cfg.batch
        parts = [self.held_out[i : i + size] for i in range(0, len(self.held_out), size)]
        with torch.no_grad():
            total = sum(self._loss(part).item() * _n_objects(part) for part in parts)
        held_out = total / _n_objects(self.held_out)
        if held_out < self.best:
            self.best = held_out
            self.weights = copy.deepcopy(self.model.state_dict())
        return held_out

    def _loss(self, batch: Sequence[Example]) -> torch.Tensor:
        skeletons, wishes = zip(*batch, strict=True)
        lesson = lesson_of(skeletons, wishes, self.model.grammar)
        return skeleton_loss(self.model, to_device(lesson, self.model.most.device))


def _n_objects(examples: Sequence[Example]) -> int:
    return sum(len(skeleton) - 1 for skeleton, _ in examples)


def _rate(share: float) -> float:
    """Learning rate over its greatest: a rise, then half a cosine."""
    return min(1.0, (share + 1e-3) / _WARM_UP) * 0.5 * (1.0 + math.cos(math.pi * share))
