"""The whole training: skeleton model, denoiser, semantic prior; saved often, resumed exactly.

FOLDER/checkpoint.safetensors   what generates, so far
FOLDER/state.safetensors        what training goes on from
FOLDER/log.jsonl, curves.png    how it went
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Protocol

import torch
from torch import Tensor

from aeroscene.learning.model.network import HierarchicalDenoiser
from aeroscene.learning.tokens.training_set import TrainingSet
from aeroscene.learning.training.batches.opened import open_batches
from aeroscene.learning.training.batches.stream import STAGE, StreamedBatches
from aeroscene.learning.training.checkpoint import (
    CheckpointFacts,
    Part,
    Weights,
    category_names,
    write_checkpoint,
)
from aeroscene.learning.training.code_version import code_version
from aeroscene.learning.training.config import Budget, Preset, TrainCfg, TrainingError
from aeroscene.learning.training.curves import draw_curves
from aeroscene.learning.training.data import TrainingData
from aeroscene.learning.training.devices import naming_memory
from aeroscene.learning.training.held_out import held_out_loss
from aeroscene.learning.training.journal import append_line, forget_after
from aeroscene.learning.training.loop import (
    TOTAL,
    DenoiserTraining,
    LossFunction,
    StepReport,
    train_denoiser,
)
from aeroscene.learning.training.presets import Sections, sections_to_plain
from aeroscene.learning.training.prior_stage import loss_function, train_prior_part
from aeroscene.learning.training.same_data import check_same_data
from aeroscene.learning.training.skeleton_stage import train_skeleton_part
from aeroscene.learning.training.state import STATE, TrainingState, write_state

CHECKPOINT = "checkpoint.safetensors"

PartTrainer = Callable[..., tuple[Weights, Mapping[str, float]] | None]
"""`train_skeleton_part` or `train_prior_part`."""


class Watcher(Protocol):
    """Observer of a training, which may stop it."""

    def on_progress(self, stage: str, share: float, figures: Mapping[str, float]) -> None:
        """A stage has come so far, 0 to 1; `figures` are losses by name, now and then."""
        ...

    def wants_stop(self) -> bool:
        """Asked after every step."""
        ...


@dataclass(frozen=True, kw_only=True)
class Plan:
    """Plan of a training: parts, data, length and folder."""

    folder: Path
    """Made where there is none."""
    preset: Preset
    sections: Sections
    data: TrainingData
    budget: Budget
    """Length of the denoiser's training."""
    device: torch.device
    save_seconds: float = 300.0
    """Time between two saves."""
    log_steps: int = 25
    """Steps between two lines of the log."""
    parts: tuple[Part, ...]
    """Parts to train, see `presets.PARTS`."""
    taken: Mapping[Part, Weights] = field(default_factory=dict)
    """Parts that another training has made."""
    n_workers: int = 1
    """Processes that make the scenes of a stream."""


@dataclass
class Training:
    """A training under way."""

    plan: Plan
    watcher: Watcher
    parts: dict[Part, Weights] = field(default_factory=dict)
    """Weights of the parts that are done, but for the denoiser."""
    figures: dict[str, Any] = field(default_factory=dict)
    """Figures of the training for the checkpoint."""
    _denoiser: DenoiserTraining | None = None
    _stream: StreamedBatches | None = None
    _pending: list[StepReport] = field(default_factory=list)
    _saved_s: float = 0.0

    def run(self, state: TrainingState | None = None) -> bool:
        """Train what is not trained yet, from where an earlier training was stopped.

        Returns:
            Whether it came to its end; it is saved either way.

        Raises:
            TrainingError: If the state is of other data, or the loss does not stay finite.
            DeviceError: If memory runs out.
            OSError: If a file cannot be written.
        """
        self.plan.folder.mkdir(parents=True, exist_ok=True)
        self.parts = dict(self.plan.taken)
        self.figures["held_out_skipped"] = self.plan.data.n_skipped
        if state is not None:
            check_same_data(self.plan.folder, state.facts, self.plan.data.source)
            self.parts |= state.parts
            self.figures = dict(state.facts.training)
        with naming_memory(self.plan.device, "a smaller training.batch_size (--config)"):
            is_done = self._train_part("skeleton", train_skeleton_part)
            is_done = is_done and self._train_part("prior", train_prior_part)
            is_done = is_done and self._train_denoiser(state)
        self.save()
        return is_done

    def _train_part(self, part: Part, train: PartTrainer) -> bool:
        """Whether a part beside the denoiser is there, trained now or before."""
        if part not in self.plan.parts or part in self.parts:
            return True
        plan = self.plan
        on_step = partial(self._on_step, part)
        found = train(plan.folder, plan.sections, plan.data, plan.device, on_step)
        if found is None:
            return False
        self.parts[part], figures = found
        self.figures |= figures
        self.save()
        return True

    def _on_step(self, stage: Part, share: float, figures: Mapping[str, float]) -> bool:
        self.watcher.on_progress(stage, share, figures)
        return not self.watcher.wants_stop()

    def _train_denoiser(self, state: TrainingState | None) -> bool:
        """Whether the denoiser's training came to its end."""
        if "denoiser" not in self.plan.parts:
            return True
        training = self._denoiser = self._new_denoiser()
        if state is not None and state.has_denoiser:
            state.restore(training)
            forget_after(self.plan.folder, "denoiser", training.step)
        self._saved_s = time.perf_counter()
        plan, budget, clock = self.plan, self.plan.budget, time.perf_counter
        stop = self.watcher.wants_stop
        with open_batches(
            plan.data, training.cfg, plan.device, plan.folder, training.step, plan.n_workers, stop
        ) as opened:
            self._stream = opened.stream
            train_denoiser(training, opened.batches, self._loss, budget, self._after_step, clock)
        return budget.share(training.step, training.seconds) >= 1.0

    def _new_denoiser(self) -> DenoiserTraining:
        """A denoiser with its first weights, which the seed decides."""
        cfg = self._cfg
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(cfg.seed)
            model = HierarchicalDenoiser(self.plan.sections["model"])
        known = self.plan.data.train
        if isinstance(known, TrainingSet):
            model.use_statistics(known.vocabulary, known.statistics)
        return DenoiserTraining(model, cfg, self.plan.device)

    @property
    def _cfg(self) -> TrainCfg:
        return self.plan.sections["training"]

    @cached_property
    def _loss(self) -> LossFunction:
        plan = self.plan
        return loss_function(plan.sections, plan.data, plan.device, self.parts.get("prior"))

    def _after_step(self, report: StepReport) -> bool:
        self._pending.append(report)
        figures: dict[str, float] = {}
        if report.step % self.plan.log_steps == 0:
            figures = self._log()
        if report.step % self._cfg.look_steps == 0 or report.share >= 1.0:
            figures |= self._look()
        self.watcher.on_progress("denoiser", report.share, figures)
        if self.watcher.wants_stop():
            return False
        if time.perf_counter() - self._saved_s > self.plan.save_seconds and report.share < 1.0:
            self.save()
        return True

    def _log(self) -> dict[str, float]:
        """Write the means of the steps since the last line."""
        reports, self._pending = self._pending, []
        last = reports[-1]
        figures = {name: _mean([report.losses[name] for report in reports]) for name in last.losses}
        figures["gradient_norm"] = _mean([report.gradient_norm for report in reports])
        figures = {name: value for name, value in figures.items() if value > 0}
        figures["learning_rate"] = last.learning_rate
        line = {"stage": "denoiser", "step": last.step, "seconds": round(last.seconds, 2)}
        append_line(self.plan.folder, line | {k: float(f"{v:.6g}") for k, v in figures.items()})
        self.figures["loss"] = figures[TOTAL]
        if self._stream is not None:
            streamed = self._stream.figures(last.step)
            append_line(self.plan.folder, {"stage": STAGE, "step": last.step} | streamed)
            self.figures["scenes"] = streamed["scenes"]
        return figures

    def _look(self) -> dict[str, float]:
        """Measure the averaged weights on held-out scenes, and keep them where they are best."""
        training = self._denoiser
        assert training is not None
        _check_finite(training)
        loss = held_out_loss(training, self.plan.data.held_out, self._loss)
        if loss is None:
            return {}
        best, step = training.best, training.step
        is_best = best.offer(step, loss, training.average.weights)
        line = {"stage": "denoiser", "step": step, "held_out": round(loss, 6), "is_best": is_best}
        append_line(self.plan.folder, line)
        kept = best.loss if best.keeps_weights else loss
        self.figures |= {"held_out_loss": kept, "held_out_least_step": best.step}
        self.figures["held_out_least"] = best.loss
        return {"held_out": loss}

    def save(self) -> None:
        """Write state, checkpoint and curves.

        Raises:
            TrainingError: If weights are not finite: what was saved before stays.
            OSError: If a file cannot be written.
        """
        parts = dict(self.parts)
        if self._denoiser is not None:
            _check_finite(self._denoiser)
            if self._pending:
                self._log()
            training = self._denoiser
            self.figures |= {"steps": training.step, "seconds": round(training.seconds, 1)}
            parts["denoiser"] = training.kept
        self.figures |= {"device": str(self.plan.device), "torch": str(torch.__version__)}
        facts = self._facts()
        folder = self.plan.folder
        write_state(folder / STATE, facts, self._denoiser, self.parts)
        write_checkpoint(folder / CHECKPOINT, facts, parts, self.plan.data.train.statistics)
        draw_curves(folder)
        self._saved_s = time.perf_counter()

    def _facts(self) -> CheckpointFacts:
        plan = self.plan
        return CheckpointFacts(
            preset=plan.preset,
            configs=sections_to_plain(plan.sections),
            vocabulary=plan.data.vocabulary.to_json(),
            categories=category_names(),
            data=plan.data.source,
            code=code_version(),
            training=self.figures,
        )


def _check_finite(training: DenoiserTraining) -> None:
    for name, value in training.average.weights.items():
        if not torch.isfinite(value).all():
            raise TrainingError(
                f"weights {name} are not finite after step {training.step}, valid: a lower "
                "training.learning_rate; the last save is as it was"
            )


def _mean(values: list[Tensor]) -> float:
    return math.fsum(float(value) for value in values) / len(values)
