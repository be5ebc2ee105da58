"""Loading of a checkpoint as a model that makes scenes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import torch
from torch import nn

from aeroscene.learning.diffusion.sampling import SamplerCfg
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.generation.denoising import Denoising
from aeroscene.learning.generation.programs import ProgramProposer
from aeroscene.learning.generation.proposal import Proposer
from aeroscene.learning.model.network import new_denoiser
from aeroscene.learning.paper.guidance.layout import flat_reader
from aeroscene.learning.paper.guidance.objectives import Objectives
from aeroscene.learning.paper.guidance.semantic import SemanticPrior
from aeroscene.learning.paper.preset import PAPER_SAMPLER
from aeroscene.learning.paper.proposer import FlatProposer
from aeroscene.learning.paper.tokens import FlatStatistics
from aeroscene.learning.tokens.kinds import Vocabulary
from aeroscene.learning.training.checkpoint import (
    Checkpoint,
    CheckpointError,
    DataSource,
    Part,
    read_checkpoint,
)
from aeroscene.learning.training.presets import sections_from_plain
from aeroscene.learning.writer.language import Language
from aeroscene.learning.writer.model import new_writer

Module = TypeVar("Module", bound=nn.Module)

_SHIPPED = Path(__file__).parents[1] / "checkpoints"
SHIPPED = {"default": _SHIPPED / "default.safetensors", "paper": _SHIPPED / "paper.safetensors"}
"""Checkpoints that come with the package, by preset."""
DEFAULT_SAMPLER = SamplerCfg(kind="ddim", n_steps=10)


def load_proposer(
    checkpoint: Path | None, preset: str, device: torch.device, n_steps: int | None
) -> tuple[Proposer, DataSource]:
    """The model in a checkpoint, or the one that ships with a preset.

    Returns:
        The model, and what it was trained on.

    Raises:
        CheckpointError: If it cannot be used.
        DiffusionError: If the number of steps is out of range.
    """
    if checkpoint is None:
        if preset not in SHIPPED:
            raise CheckpointError(f"preset is {preset!r}, valid: {', '.join(SHIPPED)}")
        checkpoint = SHIPPED[preset]
    found = read_checkpoint(checkpoint)
    return _Loader(found, device, n_steps).proposer(), found.facts.data


class _Loader:
    """The parts of a checkpoint on a device."""

    def __init__(self, checkpoint: Checkpoint, device: torch.device, n_steps: int | None) -> None:
        self._checkpoint = checkpoint
        self._device = device
        self._sections = sections_from_plain(checkpoint.facts.configs)
        self._schedule = Schedule(self._sections["schedule"])
        self._n_steps = n_steps

    def proposer(self) -> Proposer:
        """Proposer of scenes with this checkpoint."""
        known = self._checkpoint.known
        return self._flat(known) if isinstance(known, FlatStatistics) else self._ours(known)

    def _ours(self, language: Language) -> ProgramProposer:
        writer = new_writer(self._sections["writer"], language)
        return ProgramProposer(
            language,
            self._loaded(writer, "writer"),
            Denoising(
                language,
                self._loaded(new_denoiser(self._sections["model"], language), "denoiser"),
                self._schedule,
                self._sampler(DEFAULT_SAMPLER),
                self._device,
            ),
        )

    def _flat(self, statistics: FlatStatistics) -> FlatProposer:
        prior = self._loaded(SemanticPrior(self._sections["prior"]), "prior")
        read = flat_reader(statistics, self._device)
        return FlatProposer(
            self._loaded(new_denoiser(self._sections["model"], None), "denoiser"),
            Vocabulary.from_json(self._checkpoint.facts.vocabulary),
            statistics,
            self._schedule,
            self._sampler(PAPER_SAMPLER),
            Objectives(read, self._sections["guidance"], prior),
            self._device,
        )

    def _loaded(self, module: Module, part: Part) -> Module:
        self._checkpoint.load_into(module, part)
        return module.to(self._device).eval()

    def _sampler(self, cfg: SamplerCfg) -> SamplerCfg:
        n_steps = cfg.n_steps if self._n_steps is None else self._n_steps
        kind = self._sections["loss"].parameterisation
        return replace(cfg, n_steps=n_steps, parameterisation=kind)
