"""The course of one part's training: logging, measuring on held-out scenes, and saving.

The loop calls `Course.after_step` after every step. Losses stay on the device until a line of the
log is due, because reading them would make the processor wait for a GPU.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import torch
from torch import Tensor

from aeroscene.learning.paper.contents.lessons import ContentsLessons
from aeroscene.learning.paper.training_set import FlatTrainingSet
from aeroscene.learning.training.batches.opened import stream_stage
from aeroscene.learning.training.batches.stream import StreamedBatches
from aeroscene.learning.training.checkpoint_facts import Part
from aeroscene.learning.training.config import TrainingError
from aeroscene.learning.training.data import Set
from aeroscene.learning.training.held_out import HeldOutSet, held_out_loss
from aeroscene.learning.training.journal import append_line
from aeroscene.learning.training.loop import TOTAL, LossFunction, PartTraining, StepReport
from aeroscene.learning.writer.training_set import LessonSet, ProgramSet


class Watcher(Protocol):
    """Observer of a training, which may stop it."""

    def on_progress(self, stage: str, share: float, figures: Mapping[str, float]) -> None:
        """Report that a stage has come so far.

        Args:
            stage: Name of the stage.
            share: Share of it that is done, 0 to 1.
            figures: Losses by name; empty in most calls.
        """
        ...

    def wants_stop(self) -> bool:
        """Return True to stop the training; asked after every step."""
        ...


@dataclass(kw_only=True)
class Course:
    """Everything that happens beside the steps of one part's training."""

    part: Part
    training: PartTraining
    loss: LossFunction
    held_out: HeldOutSet
    stream: StreamedBatches | None
    folder: Path
    log_steps: int
    watcher: Watcher
    figures: dict[str, Any]
    """Figures of the whole training, to which this part adds."""
    save: Callable[[], None]
    """Called after every step but the last; it decides if it is time to save."""
    pending: list[StepReport] = field(default_factory=list)
    """Reports since the last line of the log."""

    def after_step(self, report: StepReport) -> bool:
        """Log, measure and save as due; return False if the training should stop."""
        self.pending.append(report)
        figures: dict[str, float] = {}
        if report.step % self.log_steps == 0:
            figures = self.log()
        if report.step % self.training.cfg.look_steps == 0 or report.share >= 1.0:
            figures |= self.look()
        self.watcher.on_progress(self.part, report.share, figures)
        if self.watcher.wants_stop():
            return False
        # The end of a part is saved by the procedure.
        if report.share < 1.0:
            self.save()
        return True

    def log(self) -> dict[str, float]:
        """Write the means of the steps since the last line, and return them."""
        reports, self.pending = self.pending, []
        if not reports:
            return {}
        folder, last = self.folder, reports[-1]
        figures = {name: _mean([report.losses[name] for report in reports]) for name in last.losses}
        figures["gradient_norm"] = _mean([report.gradient_norm for report in reports])
        # Terms that are switched off are 0; the curves are logarithmic.
        figures = {name: value for name, value in figures.items() if value > 0}
        figures["learning_rate"] = last.learning_rate
        line = {"stage": self.part, "step": last.step, "seconds": round(last.seconds, 2)}
        append_line(folder, line | {k: float(f"{v:.6g}") for k, v in figures.items()})
        self._tell({"loss": figures.get(TOTAL, 0.0)})
        if self.stream is not None:
            streamed = self.stream.figures(last.step)
            stage = stream_stage(self.part)
            append_line(folder, {"stage": stage, "step": last.step} | streamed)
            self._tell({"scenes": streamed["scenes"]})
        return figures

    def look(self) -> dict[str, float]:
        """Measure the averaged weights on held-out scenes, and keep them if they are the best.

        Returns:
            The loss as `held_out`; empty if no scene is held out.

        Raises:
            TrainingError: If weights are not finite.
        """
        training = self.training
        check_finite(training)
        loss = held_out_loss(training, self.held_out, self.loss)
        if loss is None:
            return {}
        best, step = training.best, training.step
        is_best = best.offer(step, loss, training.average.weights)
        line = {"stage": self.part, "step": step, "held_out": round(loss, 6), "is_best": is_best}
        append_line(self.folder, line)
        # The figure belongs to the weights that the checkpoint has.
        kept = best.loss if best.keeps_weights else loss
        self._tell({"held_out_loss": kept, "held_out_least_step": best.step})
        self._tell({"held_out_least": best.loss})
        return {"held_out": loss}

    def _tell(self, figures: Mapping[str, float]) -> None:
        prefix = figure_prefix(self.part)
        self.figures |= {f"{prefix}{name}": value for name, value in figures.items()}


def figure_prefix(part: Part) -> str:
    """Return the prefix of the names of a part's figures; the denoiser's have none."""
    return "" if part == "denoiser" else f"{part}_"


def part_set(data: Set, part: Part) -> Set | LessonSet | ContentsLessons:
    """Return scenes in the form that a part learns from."""
    if part == "contents":
        assert isinstance(data, FlatTrainingSet)
        return ContentsLessons(data)
    return data.lessons if part == "writer" and isinstance(data, ProgramSet) else data


def check_finite(training: PartTraining) -> None:
    """Refuse weights that are not finite.

    Raises:
        TrainingError: If one is not.
    """
    for name, value in training.average.weights.items():
        if not torch.isfinite(value).all():
            raise TrainingError(
                f"weights {name} are not finite after step {training.step}; valid: a lower "
                "learning_rate; the last save is as it was"
            )


def _mean(values: list[Tensor]) -> float:
    return math.fsum(float(value) for value in values) / len(values)
