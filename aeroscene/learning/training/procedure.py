"""The whole training of a preset, part by part; saved often, resumed exactly.

    FOLDER/checkpoint.safetensors   weights that generate, so far
    FOLDER/state.safetensors        everything that the training continues from
    FOLDER/log.jsonl, curves.png    the course of the training

The default preset trains the writer and the denoiser; the paper's presets train the contents model,
the semantic prior and the denoiser. Checkpoint and state are separate files, because a checkpoint
is small and complete at any time, while a state also has the optimiser's moments.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import torch

from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.paper.channels import FlatStatistics
from aeroscene.learning.paper.contents.model import ContentsModel
from aeroscene.learning.paper.training_set import FlatTrainingSet
from aeroscene.learning.training.batches.opened import Supply, open_batches
from aeroscene.learning.training.batches.stream import StreamedBatches
from aeroscene.learning.training.checkpoint import Weights, write_checkpoint
from aeroscene.learning.training.checkpoint_facts import CheckpointFacts, Part, category_names
from aeroscene.learning.training.code_version import code_version
from aeroscene.learning.training.config import Budget, Preset
from aeroscene.learning.training.contents_stage import contents_loss
from aeroscene.learning.training.course import (
    Course,
    Watcher,
    check_finite,
    figure_prefix,
    part_set,
)
from aeroscene.learning.training.curves import draw_curves
from aeroscene.learning.training.data import TrainingData
from aeroscene.learning.training.devices import naming_memory
from aeroscene.learning.training.journal import forget_after
from aeroscene.learning.training.loop import (
    LossFunction,
    PartTraining,
    train_steps,
)
from aeroscene.learning.training.networks import new_denoiser
from aeroscene.learning.training.presets import PARTS, Sections, sections_to_plain
from aeroscene.learning.training.prior_stage import loss_function, train_prior_part
from aeroscene.learning.training.same_data import check_same_data
from aeroscene.learning.training.state import TrainingState, write_state
from aeroscene.learning.training.state_head import STATE
from aeroscene.learning.training.trust_stage import with_trust
from aeroscene.learning.training.writer_stage import with_fitting_share, writer_loss
from aeroscene.learning.writer.language import Language
from aeroscene.learning.writer.model import new_writer
from aeroscene.learning.writer.training_set import LessonSet

CHECKPOINT = "checkpoint.safetensors"

_SECTIONS: Mapping[Part, str] = {
    "writer": "writer_training",
    "contents": "contents_training",
    "denoiser": "training",
}
"""Section of the training of each part that is trained step by step."""


@dataclass(frozen=True, kw_only=True)
class Plan:
    """Plan of a training: parts, data, length and folder."""

    folder: Path
    """Folder of the training; it is made if there is none."""
    preset: Preset
    sections: Sections
    data: TrainingData
    budgets: Mapping[Part, Budget]
    """Length of the training of each part that is trained step by step."""
    device: torch.device
    save_seconds: float = 300.0
    """Time between two saves."""
    log_steps: int = 25
    """Steps between two lines of the log."""
    parts: tuple[Part, ...]
    """Parts to train, see `presets.PARTS`."""
    taken: Mapping[Part, Weights] = field(default_factory=dict)
    """Parts that another training has made."""
    begun: Mapping[Part, Weights] = field(default_factory=dict)
    """First weights of parts that do not begin at random."""
    n_workers: int = 1
    """Processes that make the scenes of a stream."""
    clock: Callable[[], float] = time.perf_counter
    """Clock of the budgets, in seconds."""


@dataclass
class Training:
    """A training in progress."""

    plan: Plan
    watcher: Watcher
    parts: dict[Part, Weights] = field(default_factory=dict)
    """Weights of finished parts: taken, or trained in one go."""
    trainings: dict[Part, PartTraining] = field(default_factory=dict)
    """Parts that are trained step by step, as far as they are."""
    figures: dict[str, Any] = field(default_factory=dict)
    """Figures of the training for the checkpoint."""
    _saved_s: float = 0.0

    def run(self, state: TrainingState | None = None) -> bool:
        """Train everything that is not trained yet, from where an earlier training was stopped.

        Args:
            state: State of an earlier training in the same folder; None begins anew.

        Returns:
            True if it came to its end. It is saved either way.

        Raises:
            TrainingError: If the state is of other data, or the loss does not stay finite.
            DeviceError: If memory runs out.
            OSError: If a file cannot be written.
        """
        self.plan.folder.mkdir(parents=True, exist_ok=True)
        self.parts = dict(self.plan.taken)
        self.figures["held_out_skipped"] = self.plan.data.n_skipped
        with naming_memory(self.plan.device, "a smaller training.batch_size (--config)"):
            if state is not None:
                self._restore(state)
            # `all` stops at the first part that is not done, so later parts do not begin.
            is_done = all(self._train(part) for part in PARTS[self.plan.preset])
        self.save()
        return is_done

    def _restore(self, state: TrainingState) -> None:
        check_same_data(self.plan.folder, state.facts, self.plan.data.source)
        self.parts |= state.parts
        self.figures = dict(state.facts.training)
        for part in state.heads:
            training = self.trainings[part] = self._begun(part)
            state.restore(part, training)
            # Lines after the saved step would appear twice in the log.
            forget_after(self.plan.folder, part, training.step)

    def _train(self, part: Part) -> bool:
        """Train a part; True if it is at its end, now or from before."""
        # Taken parts and finished ones need no training.
        if part not in self.plan.parts or part in self.parts:
            return True
        if part == "prior":
            return self._train_prior()
        if part not in self.trainings:
            self.trainings[part] = self._begun(part)
        plan, training = self.plan, self.trainings[part]
        budget = plan.budgets[part]
        self._saved_s = time.perf_counter()
        stop, device = self.watcher.wants_stop, self.plan.device
        with open_batches(self._supply(part), training.cfg, device, training.step, stop) as opened:
            course = self._course(part, opened.stream)
            train_steps(
                training, opened.batches, course.loss, budget, course.after_step, plan.clock
            )
            course.log()
        is_done = budget.share(training.step, training.seconds) >= 1.0
        if is_done and part == "writer":
            self._fit_share(training)
        if is_done and part == "denoiser":
            self._fit_trust(training)
        return is_done

    def _fit_trust(self, training: PartTraining) -> None:
        """Fit how far the paper's network is followed, on held-out scenes."""
        known, held_out = self.plan.data.train.known, self.plan.data.held_out
        if not isinstance(held_out, FlatTrainingSet) or not held_out.examples:
            return
        assert isinstance(known, FlatStatistics)
        sections = self.plan.sections
        cfg = with_trust(sections["model"], training.kept, known, held_out, sections["schedule"])
        self.plan = replace(self.plan, sections={**sections, "model": cfg})

    def _fit_share(self, training: PartTraining) -> None:
        """Lower the writer's least share if held-out scenes have rarer kinds."""
        train, held_out = self.plan.data.train, part_set(self.plan.data.held_out, "writer")
        assert isinstance(train.known, Language)
        assert isinstance(held_out, LessonSet)
        cfg = with_fitting_share(self.plan.sections["writer"], training.kept, train.known, held_out)
        self.plan = replace(self.plan, sections={**self.plan.sections, "writer": cfg})

    def _train_prior(self) -> bool:
        plan = self.plan
        found = train_prior_part(
            plan.folder, plan.sections, plan.data, plan.device, self._on_prior_step
        )
        if found is None:
            return False
        self.parts["prior"] = found
        self.save()
        return True

    def _on_prior_step(self, share: float, figures: Mapping[str, float]) -> bool:
        self.watcher.on_progress("prior", share, figures)
        return not self.watcher.wants_stop()

    def _begun(self, part: Part) -> PartTraining:
        """Return a part with its first weights, which the seed decides."""
        sections, known = self.plan.sections, self.plan.data.train.known
        cfg = sections[_SECTIONS[part]]
        language = known if isinstance(known, Language) else None
        # The caller's random state stays as it was.
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(cfg.seed)
            if part == "writer":
                assert language is not None
                model = new_writer(sections["writer"], language)
            elif part == "contents":
                model = ContentsModel(sections["contents"])
            else:
                model = new_denoiser(sections["model"], known, Schedule(sections["schedule"]))
        if part in self.plan.begun:
            model.load_state_dict(dict(self.plan.begun[part]))
        return PartTraining(model, cfg, self.plan.device)

    def _course(self, part: Part, stream: StreamedBatches | None) -> Course:
        plan = self.plan

        def save() -> None:
            if time.perf_counter() - self._saved_s > plan.save_seconds:
                course.log()
                self.save()

        course = Course(
            part=part,
            training=self.trainings[part],
            loss=self._loss(part),
            held_out=part_set(plan.data.held_out, part),
            stream=stream,
            folder=plan.folder,
            log_steps=plan.log_steps,
            watcher=self.watcher,
            figures=self.figures,
            save=save,
        )
        return course

    def _loss(self, part: Part) -> LossFunction:
        plan = self.plan
        if part == "writer":
            return writer_loss
        if part == "contents":
            return contents_loss
        return loss_function(plan.sections, plan.data, plan.device, self.parts.get("prior"))

    def _supply(self, part: Part) -> Supply:
        plan = self.plan
        return Supply(
            scenes=part_set(plan.data.train, part),
            encode=plan.data.train.encoder,
            last_number=plan.data.last_number,
            folder=plan.folder,
            n_workers=plan.n_workers,
            stage=part,
            # Files of streamed scenes are deleted by the last part that uses them.
            is_last=part == "denoiser" or "denoiser" not in plan.parts,
        )

    def save(self) -> None:
        """Write state, checkpoint and curves.

        Raises:
            TrainingError: If weights are not finite; earlier files stay.
            OSError: If a file cannot be written.
        """
        parts = dict(self.parts)
        for part, training in self.trainings.items():
            check_finite(training)
            name = figure_prefix(part)
            seconds = round(training.seconds, 1)
            self.figures |= {f"{name}steps": training.step, f"{name}seconds": seconds}
            parts[part] = training.kept
        self.figures |= {"device": str(self.plan.device), "torch": str(torch.__version__)}
        facts = self._facts()
        folder = self.plan.folder
        # The state first: a training can be continued from it even if the checkpoint fails.
        write_state(folder / STATE, facts, self.trainings, self.parts)
        write_checkpoint(folder / CHECKPOINT, facts, parts, self.plan.data.train.known)
        draw_curves(folder)
        self._saved_s = time.perf_counter()

    def _facts(self) -> CheckpointFacts:
        plan = self.plan
        return CheckpointFacts(
            preset=plan.preset,
            configs=sections_to_plain(plan.sections),
            vocabulary=plan.data.train.kinds_json,
            categories=category_names(),
            data=plan.data.source,
            code=code_version(),
            training=self.figures,
        )
