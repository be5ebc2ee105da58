"""Loading of a checkpoint as a model that makes scenes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import torch

from aeroscene.learning.diffusion.sampling import SamplerCfg
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.generation.proposal import HierarchicalProposer, Proposer
from aeroscene.learning.generation.raw import GeometrySampler
from aeroscene.learning.guidance.config import GuidanceCfg
from aeroscene.learning.model.network import HierarchicalDenoiser
from aeroscene.learning.paper.guidance.layout import flat_reader
from aeroscene.learning.paper.guidance.objectives import Objectives
from aeroscene.learning.paper.guidance.semantic import SemanticPrior
from aeroscene.learning.paper.preset import PAPER_SAMPLER
from aeroscene.learning.paper.proposer import FlatProposer
from aeroscene.learning.paper.tokens import FlatStatistics
from aeroscene.learning.skeleton.config import SkeletonError
from aeroscene.learning.skeleton.model import SkeletonModel
from aeroscene.learning.tokens.kinds import Vocabulary
from aeroscene.learning.tokens.skeleton import Wish
from aeroscene.learning.tokens.statistics import Statistics
from aeroscene.learning.training.checkpoint import Checkpoint, CheckpointError, read_checkpoint
from aeroscene.learning.training.presets import sections_from_plain

_SHIPPED = Path(__file__).parents[1] / "checkpoints"
SHIPPED = {"default": _SHIPPED / "default.safetensors", "paper": _SHIPPED / "paper.safetensors"}
"""Checkpoints that come with the package, by preset."""
DEFAULT_SAMPLER = SamplerCfg(kind="ddim", n_steps=30)


def load_proposer(
    checkpoint: Path | None, preset: str, device: torch.device, n_steps: int | None
) -> tuple[Proposer, tuple[Wish, ...]]:
    """The model in a checkpoint, or the one that ships with a preset.

    Returns:
        The model, and contents of scenes that it was trained on; none where those are the corpus'.

    Raises:
        CheckpointError: If it cannot be used.
        DiffusionError: If the number of steps is out of range.
    """
    if checkpoint is None:
        if preset not in SHIPPED:
            raise CheckpointError(f"preset is {preset!r}, valid: {', '.join(SHIPPED)}")
        checkpoint = SHIPPED[preset]
    found = read_checkpoint(checkpoint)
    return _Loader(found, device, n_steps).proposer(), found.facts.data.wishes


class _Loader:
    """The parts of a checkpoint on a device."""

    def __init__(self, checkpoint: Checkpoint, device: torch.device, n_steps: int | None) -> None:
        self._checkpoint = checkpoint
        self._device = device
        self._sections = sections_from_plain(checkpoint.facts.configs)
        self._vocabulary = Vocabulary.from_json(checkpoint.facts.vocabulary)
        self._schedule = Schedule(self._sections["schedule"])
        self._n_steps = n_steps

    def proposer(self) -> Proposer:
        """Proposer of scenes with this checkpoint."""
        statistics = self._checkpoint.statistics
        if isinstance(statistics, FlatStatistics):
            return self._flat(statistics)
        return self._hierarchical(statistics)

    def _hierarchical(self, statistics: Statistics) -> HierarchicalProposer:
        geometry = GeometrySampler(
            self._denoiser(),
            self._vocabulary,
            statistics,
            self._schedule,
            self._sampler(DEFAULT_SAMPLER),
            GuidanceCfg(),
            self._device,
        )
        skeletons = self._skeletons().to(self._device)
        return HierarchicalProposer(self._vocabulary, statistics, skeletons, geometry, self._device)

    def _skeletons(self) -> SkeletonModel:
        weights = self._checkpoint.weights_of("skeleton")
        try:
            return SkeletonModel.restored(self._sections["skeleton"], self._vocabulary, weights)
        except SkeletonError as error:
            raise CheckpointError(f"checkpoint's {error}") from None

    def _flat(self, statistics: FlatStatistics) -> FlatProposer:
        prior = SemanticPrior(self._sections["prior"])
        self._checkpoint.load_into(prior, "prior")
        read = flat_reader(statistics, self._device)
        return FlatProposer(
            self._denoiser(),
            self._vocabulary,
            statistics,
            self._schedule,
            self._sampler(PAPER_SAMPLER),
            Objectives(read, self._sections["guidance"], prior.to(self._device).eval()),
            self._device,
        )

    def _denoiser(self) -> HierarchicalDenoiser:
        denoiser = HierarchicalDenoiser(self._sections["model"])
        self._checkpoint.load_into(denoiser, "denoiser")
        statistics = self._checkpoint.statistics
        if isinstance(statistics, Statistics):
            # Its weights are stored in half precision, and what scales channels with them.
            denoiser.use_statistics(self._vocabulary, statistics)
        return denoiser.to(self._device).eval()

    def _sampler(self, cfg: SamplerCfg) -> SamplerCfg:
        n_steps = cfg.n_steps if self._n_steps is None else self._n_steps
        kind = self._sections["loss"].parameterisation
        return replace(cfg, n_steps=n_steps, parameterisation=kind)
