"""Measurement of a row: layouts for skeletons of the test split, judged and projected."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np
import torch
from shapely.errors import ShapelyError

from aeroscene.corpus.dataset import Dataset
from aeroscene.feasibility import validity
from aeroscene.feasibility.layout import layout_of
from aeroscene.feasibility.report import report_of
from aeroscene.feasibility.stages import project
from aeroscene.learning.diffusion.sampling import SamplerCfg
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.generation.loading import DEFAULT_SAMPLER
from aeroscene.learning.generation.raw import GeometrySampler
from aeroscene.learning.guidance.config import GuidanceCfg
from aeroscene.learning.model.network import HierarchicalDenoiser
from aeroscene.learning.tokens.assembly import assemble
from aeroscene.learning.tokens.examples import Example, encode
from aeroscene.learning.tokens.kinds import Vocabulary
from aeroscene.learning.tokens.statistics import Statistics
from aeroscene.learning.tokens.training_set import TrainingSet
from aeroscene.learning.training.batches.source import drawn_from
from aeroscene.learning.training.checkpoint import Checkpoint, CheckpointError, DataSource
from aeroscene.learning.training.config import Budget
from aeroscene.learning.training.data import TrainingData
from aeroscene.learning.training.loop import DenoiserTraining
from aeroscene.learning.training.presets import sections_from_plain
from aeroscene.learning.training.prior_stage import loss_function
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
    """A real scene, whose skeleton is to be sampled."""

    example: Example
    number: int
    """Number of the scene; it decides the noise."""


@dataclass(frozen=True)
class Model:
    """A checkpoint's denoiser with what turns its channels into boxes."""

    network: HierarchicalDenoiser
    vocabulary: Vocabulary
    statistics: Statistics
    sections: dict[str, Any]
    source: DataSource
    digest: str
    """Digest of the weights."""

    @staticmethod
    def of(checkpoint: Checkpoint) -> Model:
        """The denoiser in a checkpoint.

        Raises:
            CheckpointError: If it is of the paper's preset, which has no skeletons to sample for.
        """
        statistics = checkpoint.statistics
        if not isinstance(statistics, Statistics):
            raise CheckpointError("checkpoint is of preset 'paper', valid: preset 'default'")
        sections = sections_from_plain(checkpoint.facts.configs)
        vocabulary = Vocabulary.from_json(checkpoint.facts.vocabulary)
        network = HierarchicalDenoiser(sections["model"])
        checkpoint.load_into(network, "denoiser")
        # Its weights are stored in half precision, and what scales channels with them.
        network.use_statistics(vocabulary, statistics)
        facts = checkpoint.facts
        return Model(network.eval(), vocabulary, statistics, sections, facts.data, facts.digest)

    def cases(self, dataset: Dataset, count: int) -> list[Case]:
        """Scenes of the test split, evenly spread over it.

        Those with an object of a kind that the model never saw are left out.
        """
        found: list[Case] = []
        entries = dataset.of_split("test").entries
        picked = np.linspace(0, len(entries), count, endpoint=False).astype(int)
        for index in np.unique(picked).tolist():
            try:
                example = encode(dataset.read(entries[index]), self.vocabulary, self.statistics)
            except KeyError:
                continue
            found.append(Case(example, entries[index].index))
        return found

    def sampler(self, guidance: GuidanceCfg, **fields: Any) -> GeometrySampler:
        """Sampling as `aeroscene generate` does it, but for some fields of `SamplerCfg`."""
        parameterisation = self.sections["loss"].parameterisation
        cfg: SamplerCfg = replace(DEFAULT_SAMPLER, parameterisation=parameterisation, **fields)
        schedule = Schedule(self.sections["schedule"])
        parts = (self.network, self.vocabulary, self.statistics, schedule)
        return GeometrySampler(*parts, cfg, guidance, _DEVICE)

    def step_cpu_s(self, cases: Sequence[Case]) -> float:
        """CPU seconds of a training step, the least of some."""
        known = TrainingSet(self.vocabulary, self.statistics, tuple(case.example for case in cases))
        data = TrainingData(self.source, self.vocabulary, (), known, known)
        network = HierarchicalDenoiser(self.sections["model"])
        network.use_statistics(self.vocabulary, self.statistics)
        training = DenoiserTraining(network, self.sections["training"], _DEVICE)
        batches = drawn_from(known, training.cfg.batch_size, training.cfg.seed)
        loss = loss_function(self.sections, data, _DEVICE, None)
        spent_s: list[float] = []
        for _ in range(_TIMED_STEPS):
            start_s = time.process_time()
            training.advance(batches, loss, Budget(steps=_TIMED_STEPS))
            spent_s.append(time.process_time() - start_s)
        return min(spent_s)


def measure(
    model: Model,
    sampler: GeometrySampler,
    cases: Sequence[Case],
    noise: int,
    on_scene: Callable[[], object],
) -> list[SceneOutcome]:
    """Sample every case once, each with noise of its own in one of several draws."""
    outcomes: list[SceneOutcome] = []
    for case in cases:
        example = case.example
        generator = torch.Generator(_DEVICE).manual_seed(case.number + _NOISE_STRIDE * noise)
        start_s = time.process_time()
        geometry = sampler.sample([example.skeleton], [example.wish], generator)[0]
        cpu_s = time.process_time() - start_s
        scene = assemble(
            example.skeleton,
            geometry,
            model.vocabulary,
            scene_id=f"ablation-{case.number:04d}",
            seed=case.number,
            rng=np.random.default_rng(case.number),
        )
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
