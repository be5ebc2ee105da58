"""Training of a baseline within a budget, logged, saved and resumed like our own training.

Baselines share the loop, the batches, the checkpoints and the learning curves of
`aeroscene.learning.training`, so that a comparison of methods is not one of training code.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import torch

from aeroscene.learning.baselines.budget import flop_per_step
from aeroscene.learning.baselines.layouts import LayoutCode, LayoutSet
from aeroscene.learning.baselines.model import BaselineCfg, BaselineModel
from aeroscene.learning.training.batches.source import Batch, batch_generator, drawn_from
from aeroscene.learning.training.checkpoint_facts import CheckpointFacts, DataSource, category_names
from aeroscene.learning.training.code_version import code_version
from aeroscene.learning.training.config import Budget, TrainCfg, TrainingError
from aeroscene.learning.training.course import Course, Watcher, check_finite
from aeroscene.learning.training.curves import draw_curves
from aeroscene.learning.training.journal import forget_after
from aeroscene.learning.training.loop import LossTerms, PartTraining, train_steps
from aeroscene.learning.training.same_data import check_same_data
from aeroscene.learning.training.settings import section_to_plain
from aeroscene.learning.training.state import TrainingState, read_state, write_state
from aeroscene.learning.training.state_head import STATE
from aeroscene.scene import DOMAINS, Scene, SceneDomain

BASELINE_TRAINING = TrainCfg(
    batch_size=16, learning_rate=1e-3, second_decay=0.99, look_steps=100, warmup_steps=50
)
"""Settings as in our own training: the papers' rates (1e-4, 2e-4) are made for days of a GPU."""
_LOG_STEPS = 10
# A whole state is written at most this often.
_SAVE_S = 60.0
# Bits of a noise seed: they fit into PyTorch's signed 64-bit seeds.
_NOISE_BITS = 62


@dataclass(frozen=True, kw_only=True)
class Lessons:
    """Scenes, budget and folder of a training."""

    folder: Path
    name: str
    """Name of the data, as it is written into the checkpoint."""
    train: Sequence[Scene]
    held_out: Sequence[Scene]
    budget: Budget
    """Steps or seconds; seconds are CPU seconds of the process."""
    seed: int = 0
    is_corpus: bool = True
    """True if our grammar made the scenes."""


@dataclass(frozen=True, kw_only=True)
class Spent:
    """Cost of a training, and the size of its network."""

    parameters: int
    steps: int
    cpu_s: float
    flop: float
    """Number of steps times the operations of one step."""
    is_done: bool
    """True if the training used its whole budget, False if somebody stopped it."""


@dataclass(frozen=True, eq=False)
class FittedBaseline:
    """A trained baseline that draws scenes."""

    model: BaselineModel
    spent: Spent
    domains: frozenset[SceneDomain] = field(default_factory=frozenset)
    """Domains of its training scenes; it draws no others."""

    def sample(self, seed: int, domain: SceneDomain) -> Scene:
        """Draw the scene of a seed.

        The scene is as the method draws it: it has no landing areas and has not been projected.

        Args:
            seed: Seed of all random numbers; equal seeds give equal scenes.
            domain: One of `domains`.

        Raises:
            TrainingError: If there was no training scene of the domain.
        """
        if domain not in self.domains:
            valid = ", ".join(sorted(self.domains))
            raise TrainingError(f"domain is {domain!r}; valid: {valid}; no other was trained on")
        device = next(self.model.parameters()).device
        # Neighbouring seeds would give related noise, so a hash of the seed is used.
        number = int(np.random.SeedSequence(seed).generate_state(1, np.uint64)[0])
        generator = torch.Generator(device).manual_seed(number >> (64 - _NOISE_BITS))
        boxes = self.model.draw(DOMAINS.index(domain), generator)
        return self.model.code.scene(boxes, domain, seed, np.random.default_rng(seed))


def fit_baseline(
    method: str,
    make: Callable[[LayoutCode, BaselineCfg], BaselineModel],
    lessons: Lessons,
    cfg: BaselineCfg,
    watcher: Watcher,
    *,
    training_cfg: TrainCfg = BASELINE_TRAINING,
) -> FittedBaseline:
    """Train a baseline from where it was stopped, or load it if its budget is spent.

    Args:
        method: Name of the method, written into its checkpoint.
        make: Builds the untrained network for a layout code.
        lessons: Scenes, budget and folder.
        cfg: Size and sampling of the network.
        watcher: Reports progress, and may stop the training.
        training_cfg: Batch size, learning rate and the like.

    Returns:
        The baseline with its averaged weights.

    Raises:
        TrainingError: If the folder holds a training of other data or of another configuration.
        OSError: If a file cannot be written.
    """
    code = LayoutCode.from_scenes(lessons.train)
    train, held_out = (
        LayoutSet.from_scenes(lessons.train, code),
        LayoutSet.from_scenes(lessons.held_out, code),
    )
    # The caller's own random state stays as it was.
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(lessons.seed)
        model = make(code, cfg)
    cfgs = {"baseline": section_to_plain(cfg), "training": section_to_plain(training_cfg)}
    facts = CheckpointFacts(
        preset=method,
        configs=cfgs,
        vocabulary=code.looks.to_json(),
        categories=category_names(),
        data=DataSource(name=lessons.name, digest=train.digest, n_scenes=len(train.examples)),
        code=code_version(),
        training={},
    )
    training = PartTraining(model, training_cfg, torch.device("cpu"))
    lessons.folder.mkdir(parents=True, exist_ok=True)
    path = lessons.folder / STATE
    state = read_state(path)
    if state is not None:
        _restore(state, facts, training, lessons.folder)
    run = _Run(lessons, facts, training, watcher)
    is_done = lessons.budget.share(training.step, training.seconds) >= 1.0 or run.train(
        train, held_out
    )
    # One batch is enough: all batches of a layout code have the same shape.
    counted = [train.sample_batch(training_cfg.batch_size, batch_generator(lessons.seed, 0))]
    flop = training.step * flop_per_step(training, counted, _loss)
    model.load_state_dict(dict(training.kept))
    return FittedBaseline(
        model.eval(),
        Spent(
            parameters=sum(p.numel() for p in model.parameters()),
            steps=training.step,
            cpu_s=training.seconds,
            flop=flop,
            is_done=is_done,
        ),
        frozenset(scene.domain for scene in lessons.train),
    )


def _restore(
    state: TrainingState, facts: CheckpointFacts, training: PartTraining, folder: Path
) -> None:
    check_same_data(folder, state.facts, facts.data)
    if (state.facts.preset, state.facts.configs) != (facts.preset, facts.configs):
        raise TrainingError(
            f"out {str(folder)!r} holds a training of {state.facts.preset} with another "
            "configuration; valid: the one that it was begun with, or another folder"
        )
    state.restore("denoiser", training)
    # Rows of the log that are newer than the saved state would appear twice.
    forget_after(folder, "denoiser", training.step)


class _Run:
    """A training in progress."""

    def __init__(
        self, lessons: Lessons, facts: CheckpointFacts, training: PartTraining, watcher: Watcher
    ) -> None:
        self._lessons, self._facts, self._training = lessons, facts, training
        self._watcher = watcher
        self._saved_s = time.perf_counter()
        self._figures: dict[str, Any] = {}

    def train(self, train: LayoutSet, held_out: LayoutSet) -> bool:
        """Train until the budget is spent or the watcher stops; True if the budget was spent."""
        training, budget = self._training, self._lessons.budget
        course = Course(
            part="denoiser",
            training=training,
            loss=_loss,
            held_out=held_out,
            stream=None,
            folder=self._lessons.folder,
            log_steps=_LOG_STEPS,
            watcher=self._watcher,
            figures=self._figures,
            save=self._save_now_and_then,
        )
        batches = drawn_from(train, training.cfg.batch_size, training.cfg.seed + self._lessons.seed)
        # CPU time: other processes on the machine do not shorten the training.
        train_steps(training, batches, _loss, budget, course.after_step, time.process_time)
        course.log()
        self._save()
        return budget.share(training.step, training.seconds) >= 1.0

    def _save_now_and_then(self) -> None:
        if time.perf_counter() - self._saved_s > _SAVE_S:
            self._save()

    def _save(self) -> None:
        # A state with numbers that are not finite must never replace a good one.
        check_finite(self._training)
        facts = msgspec.structs.replace(self._facts, training=self._figures)
        write_state(self._lessons.folder / STATE, facts, {"denoiser": self._training}, {})
        draw_curves(self._lessons.folder)
        self._saved_s = time.perf_counter()


def _loss(model: Callable[..., Any], batch: Batch, generator: torch.Generator) -> LossTerms:
    return model(batch, generator)
