"""Measurement of a row: programs of the test split placed, judged and projected."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np
import torch
from shapely.errors import ShapelyError
from torch import nn

from aeroscene.corpus.dataset import Dataset
from aeroscene.feasibility import validity
from aeroscene.feasibility.layout import layout_of
from aeroscene.feasibility.report import report_of
from aeroscene.feasibility.stages import project
from aeroscene.learning.diffusion.config import SamplerCfg
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.generation.denoising import Denoising, Draft
from aeroscene.learning.generation.loading import DEFAULT_SAMPLER
from aeroscene.learning.training.batches.source import drawn_from
from aeroscene.learning.training.checkpoint import Checkpoint
from aeroscene.learning.training.checkpoint_facts import CheckpointError, DataSource
from aeroscene.learning.training.config import Budget
from aeroscene.learning.training.data import TrainingData
from aeroscene.learning.training.loop import PartTraining
from aeroscene.learning.training.networks import new_denoiser
from aeroscene.learning.training.presets import sections_from_plain
from aeroscene.learning.training.prior_stage import loss_function
from aeroscene.learning.wishes import Wish
from aeroscene.learning.writer.examples import ProgramEncoder, UnencodableError, Written
from aeroscene.learning.writer.language import Language
from aeroscene.learning.writer.training_set import ProgramSet
from aeroscene.scene import Scene, SceneError

_DEVICE = torch.device("cpu")
_TIMED_STEPS = 4
_NOISE_STRIDE = 1_000_003
"""Between the seeds of two draws, beyond all numbers of scenes; PyTorch reads 32 bits of a seed."""


class SceneOutcome(msgspec.Struct, frozen=True, kw_only=True):
    """One sampled scene."""

    n_objects: int
    n_free: int
    """Without a forbidden overlap deeper than 1 cm, before the projection."""
    n_supported: int
    """Rightly supported, before the projection."""
    n_valid: int
    """Both."""
    moved_m: float
    """Mean displacement by the projection; 0 where it came to no end."""
    n_dropped: int
    """Objects dropped by the projection; all where it came to no end."""
    cpu_s: float
    """CPU time of the sampling."""


@dataclass(frozen=True)
class Case:
    """A real scene, whose program is to be placed."""

    written: Written
    number: int
    """Number of the scene; it decides the noise."""


@dataclass(frozen=True)
class Model:
    """A checkpoint's denoiser with the language of what it places."""

    network: nn.Module
    language: Language
    sections: dict[str, Any]
    digest: str
    """Digest of the weights."""

    @staticmethod
    def of(checkpoint: Checkpoint) -> Model:
        """The denoiser in a checkpoint.

        Raises:
            CheckpointError: If it is of the paper's preset, which knows no programs.
        """
        language = checkpoint.known
        if not isinstance(language, Language):
            raise CheckpointError("checkpoint is of preset 'paper', valid: preset 'default'")
        sections = sections_from_plain(checkpoint.facts.configs)
        schedule = Schedule(sections["schedule"])
        network = new_denoiser(sections["model"], language, schedule)
        checkpoint.load_into(network, "denoiser")
        return Model(network.eval(), language, sections, checkpoint.facts.digest)

    def cases(self, dataset: Dataset, count: int) -> list[Case]:
        """Scenes of the test split, evenly spread over it.

        Those that have no program in the model's language are left out.
        """
        found: list[Case] = []
        entries = dataset.of_split("test").entries
        encode = ProgramEncoder(self.language)
        picked = np.linspace(0, len(entries), count, endpoint=False).astype(int)
        for index in np.unique(picked).tolist():
            with suppress(UnencodableError):
                scene = dataset.read(entries[index])
                written = encode(scene, Wish.of(scene))
                found.append(Case(written, entries[index].index))
        return found

    def denoising(self, **fields: Any) -> Denoising:
        """Denoising as `aeroscene generate` does it, but for some fields of `SamplerCfg`."""
        parameterisation = self.sections["loss"].parameterisation
        cfg: SamplerCfg = replace(DEFAULT_SAMPLER, parameterisation=parameterisation, **fields)
        schedule = Schedule(self.sections["schedule"])
        return Denoising(self.language, self.network, schedule, cfg, _DEVICE)

    def step_cpu_s(self, cases: Sequence[Case]) -> float:
        """CPU seconds of a training step, the least of some."""
        known = ProgramSet(self.language, tuple(case.written for case in cases))
        source = DataSource(name="cases", digest=known.digest, n_scenes=len(cases))
        data = TrainingData(source, known, known)
        schedule = Schedule(self.sections["schedule"])
        network = new_denoiser(self.sections["model"], self.language, schedule)
        training = PartTraining(network, self.sections["training"], _DEVICE)
        batches = drawn_from(known, training.cfg.batch_size, training.cfg.seed)
        loss = loss_function(self.sections, data, _DEVICE, None)
        spent_s: list[float] = []
        for _ in range(_TIMED_STEPS):
            start_s = time.process_time()
            training.advance(batches, loss, Budget(steps=_TIMED_STEPS))
            spent_s.append(time.process_time() - start_s)
        return min(spent_s)


def measure(
    denoising: Denoising, cases: Sequence[Case], noise: int, on_scene: Callable[[], object]
) -> list[SceneOutcome]:
    """Place every case once, each with noise of its own in one of several draws."""
    outcomes: list[SceneOutcome] = []
    for case in cases:
        draft = Draft(case.written.example, case.written.wish)
        generator = torch.Generator(_DEVICE).manual_seed(case.number + _NOISE_STRIDE * noise)
        start_s = time.process_time()
        proposal = denoising.denoise([draft], generator)[0]
        cpu_s = time.process_time() - start_s
        rng = np.random.default_rng(case.number)
        scene = proposal.scene(f"ablation-{case.number:04d}", case.number, rng)
        outcomes.append(_judged(scene, cpu_s))
        on_scene()
    return outcomes


def _judged(scene: Scene, cpu_s: float) -> SceneOutcome:
    verdict = validity(scene)
    moved_m, n_dropped = _projected(scene)
    return SceneOutcome(
        n_objects=len(scene.objects),
        n_free=int(verdict.is_free.sum()),
        n_supported=int(verdict.is_supported.sum()),
        n_valid=int(verdict.is_valid.sum()),
        moved_m=moved_m,
        n_dropped=n_dropped,
        cpu_s=cpu_s,
    )


def _projected(scene: Scene) -> tuple[float, int]:
    """Mean displacement, m, and objects dropped; areas are not looked for."""
    layout = layout_of(scene)
    try:
        project(layout)
    except (SceneError, ShapelyError):
        return 0.0, len(scene.objects)
    report = report_of(layout)
    return report.mean_moved_m, report.n_dropped
