"""Our own presets, trained on the same scenes and within the same budget as the baselines."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import torch

from aeroscene.learning.baselines.budget import flop_per_step
from aeroscene.learning.baselines.fitting import Lessons, Spent
from aeroscene.learning.generation.generator import Generator
from aeroscene.learning.generation.request import Request
from aeroscene.learning.program import WHOLE, DecodingCfg, EncodingCfg
from aeroscene.learning.training.batches.source import batch_generator
from aeroscene.learning.training.checkpoint_facts import FLAT_PRESETS, Part
from aeroscene.learning.training.config import Preset
from aeroscene.learning.training.contents_stage import contents_loss
from aeroscene.learning.training.course import Watcher, part_set
from aeroscene.learning.training.data import prepared
from aeroscene.learning.training.fitted import fitted
from aeroscene.learning.training.loop import LossFunction
from aeroscene.learning.training.presets import PARTS, part_budgets, preset_sections
from aeroscene.learning.training.prior_stage import loss_function
from aeroscene.learning.training.procedure import CHECKPOINT, Plan, Training
from aeroscene.learning.training.settings import changed
from aeroscene.learning.training.state import read_state
from aeroscene.learning.training.state_head import STATE
from aeroscene.learning.training.writer_stage import writer_loss
from aeroscene.learning.wishes import Wish
from aeroscene.scene import Scene, SceneDomain

_SAVE_S = 60.0
_N_COUNTED = 2
"""Batches in which operations are counted. The writer's batches differ in length."""
_LOOK_STEPS = 100
_STEP_LOSSES: Mapping[Part, LossFunction] = {"writer": writer_loss, "contents": contents_loss}
"""Losses of the parts that need nothing but a batch."""
# Share of the budget for the semantic prior, and the time that one of its steps is taken to last.
_PRIOR_SHARE = 0.1
_PRIOR_STEP_S = 0.15
_PRIOR_STEPS = (10, 400)
"""Least and greatest number of steps of the semantic prior."""


@dataclass(frozen=True, eq=False)
class FittedPreset:
    """A trained preset that draws scenes."""

    generator: Generator
    spent: Spent | None
    """Cost of its training; None for a checkpoint that somebody else has trained."""

    def sample(self, seed: int, domain: SceneDomain) -> Scene:
        """Draw the scene of a seed as sampled: before the projection, without areas.

        Raises:
            RequestError: If there was no training scene of the domain.
        """
        return self.generator.sampled(Request(seed=seed, domain=domain))


def fit_preset(
    preset: Preset,
    lessons: Lessons,
    watcher: Watcher,
    *,
    encoding: EncodingCfg = WHOLE,
    changes: Mapping[str, Mapping[str, Any]] = MappingProxyType({}),
) -> FittedPreset:
    """Train a preset as `aeroscene train` does, with a budget in CPU seconds.

    Args:
        preset: Name of the preset.
        lessons: Scenes, budget and folder.
        watcher: Reports progress, and may stop the training.
        encoding: Details of scenes that programs keep; the paper's presets have no programs.
        changes: New values of fields of the preset's configuration, by section.

    Raises:
        TrainingError: If the folder holds a training of other data, or too few scenes can be read.
        OSError: If a file cannot be written.
    """
    has_wishes = not (preset in FLAT_PRESETS and lessons.is_corpus)
    data = prepared(
        lessons.name,
        lessons.train,
        lessons.held_out,
        preset=preset,
        wishes=[Wish.from_scene(scene) for scene in lessons.train] if has_wishes else [],
        is_corpus=lessons.is_corpus,
        encoding=encoding,
    )
    parts = PARTS[preset]
    steps, seconds = lessons.budget.steps, lessons.budget.seconds
    state = read_state(lessons.folder / STATE)
    training = Training(
        Plan(
            folder=lessons.folder,
            preset=preset,
            sections=fitted(
                changed(_sections(preset, seconds, lessons.seed), changes), data.train.known
            ),
            data=data,
            budgets=part_budgets(parts, steps, None if seconds is None else seconds / 60),
            device=torch.device("cpu"),
            save_seconds=_SAVE_S,
            parts=parts,
            clock=time.process_time,
        ),
        watcher,
    )
    # CPU time, as for the baselines.
    begun_s = time.process_time()
    is_done = training.run(state)
    spent_s = time.process_time() - begun_s
    generator = Generator.load(lessons.folder / CHECKPOINT, device="cpu")
    return FittedPreset(generator, _spent(training, spent_s, is_done=is_done))


def shipped_preset(preset: Preset) -> FittedPreset:
    """Load a preset with the weights that ship; its training was another one.

    Raises:
        CheckpointError: If the checkpoint is missing.
    """
    return FittedPreset(Generator.load(preset=preset, device="cpu"), None)


def _sections(preset: Preset, seconds: float | None, seed: int) -> dict[str, Any]:
    sections = preset_sections(preset)
    for name in ("training", "writer_training", "contents_training"):
        if name in sections:
            changes: dict[str, Any] = {"seed": seed, "look_steps": _LOOK_STEPS}
            if name == "training" and preset in FLAT_PRESETS and seconds is not None:
                steps = round(_PRIOR_SHARE * seconds / _PRIOR_STEP_S)
                changes["prior_steps"] = min(max(steps, _PRIOR_STEPS[0]), _PRIOR_STEPS[1])
            sections[name] = replace(sections[name], **changes)
    return sections


def _spent(training: Training, spent_s: float, *, is_done: bool) -> Spent:
    """Add up steps, seconds and operations of all parts that are trained step by step.

    The semantic prior is trained anew when a training is resumed, so its CPU seconds count in an
    unbroken training only.
    """
    trainings = training.trainings
    parameters = [
        *(value for weights in training.parts.values() for value in weights.values()),
        *(p for each in trainings.values() for p in each.model.parameters()),
    ]
    return Spent(
        parameters=sum(value.numel() for value in parameters),
        steps=sum(each.step for each in trainings.values()),
        # The greater one: seconds of the parts survive an interruption, and the
        # whole also has the prior.
        cpu_s=max(sum(each.seconds for each in trainings.values()), spent_s),
        flop=sum(each.step * _flop(training, part) for part, each in trainings.items()),
        is_done=is_done,
    )


def _flop(training: Training, part: Part) -> float:
    plan, each = training.plan, training.trainings[part]
    scenes = part_set(plan.data.train, part)
    loss = (
        _STEP_LOSSES[part]
        if part in _STEP_LOSSES
        else loss_function(plan.sections, plan.data, plan.device, training.parts.get("prior"))
    )
    batches = [
        scenes.sample_batch(each.cfg.batch_size, batch_generator(each.cfg.seed, step))
        for step in range(_N_COUNTED)
    ]
    return flop_per_step(each, batches, loss)


def without(
    folder: Path | None,
    preset: Preset,
    changes: Mapping[str, Any],
    decoding: DecodingCfg,
    spent: Spent | None,
) -> FittedPreset:
    """Load a preset that samples otherwise than it was trained: an ablation.

    Args:
        folder: Folder of its training; None for the weights that ship.
        preset: Name of the preset.
        changes: New values of fields of its configuration that sampling reads, by section.
        decoding: Corrections of drawn programs.
        spent: Cost of its training, which is passed on.

    Raises:
        CheckpointError: If there is no checkpoint.
    """
    checkpoint = None if folder is None else folder / CHECKPOINT
    generator = Generator.load(
        checkpoint, preset=preset, device="cpu", changes=changes, decoding=decoding
    )
    return FittedPreset(generator, spent)
