"""The small denoisers of the rows: found in their folders, or trained now."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import torch

from ablation.rows import TrainedRow
from aeroscene.corpus.dataset import open_dataset
from aeroscene.learning.model.config import ModelCfg
from aeroscene.learning.training.checkpoint import Checkpoint, read_checkpoint
from aeroscene.learning.training.config import Budget, TrainCfg, TrainingError
from aeroscene.learning.training.data import TrainingData, prepared
from aeroscene.learning.training.fitted import fitted
from aeroscene.learning.training.presets import preset_sections, sections_from_plain
from aeroscene.learning.training.procedure import CHECKPOINT, Plan, Training
from aeroscene.learning.training.settings import changed
from aeroscene.learning.training.state import read_state
from aeroscene.learning.training.state_head import STATE
from aeroscene.scene import Scene
from scenarios.cli.progress import progress_bar
from scenarios.cli.training_bar import TrainingBar, training_bar

_NOT_COMPARED = ("writer", "writer_training")
"""Sections of another part of the model."""


@dataclass(frozen=True, kw_only=True)
class Trainer:
    """Trains rows on one dataset, for equally many steps."""

    data: Path
    out: Path
    steps: int
    precision: str
    """Precision of `TrainCfg`; rows that are there already may have another."""

    def found(self, row: TrainedRow) -> Checkpoint | None:
        """The trained row, None where it is missing or not at its end.

        Raises:
            TrainingError: If its folder holds something else.
        """
        path = self.out / row.name / CHECKPOINT
        if not path.exists():
            return None
        checkpoint = read_checkpoint(path)
        strange = _difference(_sections(row), checkpoint)
        if strange:
            raise TrainingError(
                f"out {str(path.parent)!r} holds another training ([{strange}] differs), "
                f"valid: one of row {row.name}, or another --out"
            )
        return checkpoint if checkpoint.facts.training.get("steps", 0) >= self.steps else None

    def train(self, row: TrainedRow) -> Checkpoint:
        """Train a row, from where it was stopped.

        Raises:
            SceneError: If data or folder cannot be used.
            OSError: If a file cannot be written.
        """
        folder = self.out / row.name
        state = read_state(folder / STATE)
        data = self._prepared
        asked = changed(_sections(row), {"training": {"precision": self.precision}})
        begun = None if state is None else sections_from_plain(state.facts.configs)
        plan = Plan(
            folder=folder,
            preset="default",
            sections=begun or fitted(asked, data.train.known),
            data=data,
            budgets={"denoiser": Budget(steps=self.steps)},
            device=torch.device("cpu"),
            parts=("denoiser",),
        )
        with training_bar() as bar:
            Training(plan, _Watcher(bar, row.name)).run(state)
        return read_checkpoint(folder / CHECKPOINT)

    @cached_property
    def _prepared(self) -> TrainingData:
        """Scenes to train on and to watch by."""
        dataset = open_dataset(self.data)
        train: list[Scene] = []
        held_out: list[Scene] = []
        with progress_bar("reading scenes", len(dataset.entries)) as advance:
            for entry in dataset.entries:
                (train if entry.split == "train" else held_out).append(dataset.read(entry))
                advance()
        return prepared(self.data.name, train, held_out)


@dataclass(frozen=True)
class _Watcher:
    """Moves the bar of a row; Ctrl-C ends the tool, and what was saved goes on."""

    bar: TrainingBar
    row: str

    def on_progress(self, stage: str, share: float, figures: Mapping[str, float]) -> None:
        del stage
        self.bar.show(self.row, share, figures)

    def wants_stop(self) -> bool:
        return False


def _sections(row: TrainedRow) -> dict[str, Any]:
    return changed(preset_sections("default"), row.changes)


def _difference(asked: Mapping[str, Any], checkpoint: Checkpoint) -> str | None:
    """First section in which a checkpoint is not what was asked for."""
    there = sections_from_plain(checkpoint.facts.configs)
    for name, section in asked.items():
        other = there.get(name, type(section)())
        if name not in _NOT_COMPARED and _alike(section, other) != section:
            return name
    return None


def _alike(here: Any, there: Any) -> Any:
    """The section there, but for what is no choice of a row: speed, and the number of kinds."""
    if isinstance(here, TrainCfg):
        return replace(there, precision=here.precision)
    return replace(there, n_kinds=here.n_kinds) if isinstance(here, ModelCfg) else there
