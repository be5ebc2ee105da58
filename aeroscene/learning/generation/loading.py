"""Loading of a checkpoint as a model that makes scenes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

import torch
from torch import nn

from aeroscene.learning.diffusion.config import SamplerCfg
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.generation.denoising import Denoising
from aeroscene.learning.generation.layouts import FlatModel, FlatProposer
from aeroscene.learning.generation.programs import ProgramProposer
from aeroscene.learning.generation.proposal import Proposer
from aeroscene.learning.paper.channels import FlatStatistics
from aeroscene.learning.paper.contents.model import ContentsModel
from aeroscene.learning.paper.guidance.layout import FlatReader
from aeroscene.learning.paper.guidance.objectives import Objectives
from aeroscene.learning.paper.guidance.semantic import SemanticPrior
from aeroscene.learning.paper.looks import Looks
from aeroscene.learning.program import DecodingCfg
from aeroscene.learning.training.checkpoint import Checkpoint, read_checkpoint
from aeroscene.learning.training.checkpoint_facts import CheckpointError, DataSource, Part
from aeroscene.learning.training.networks import new_denoiser
from aeroscene.learning.training.paper_preset import paper_sampler
from aeroscene.learning.training.presets import read_sections
from aeroscene.learning.training.settings import changed
from aeroscene.learning.writer.language import Language
from aeroscene.learning.writer.model import new_writer

Module = TypeVar("Module", bound=nn.Module)

_SHIPPED = Path(__file__).parents[1] / "checkpoints"
SHIPPED = {name: _SHIPPED / f"{name}.safetensors" for name in ("default", "paper", "progressive")}
"""Checkpoints that come with the package, by preset."""
DEFAULT_SAMPLER = SamplerCfg(kind="dpm-solver++", n_steps=14)
"""Sampler of the default preset."""


def load_proposer(
    checkpoint: Path | None,
    preset: str,
    device: torch.device,
    n_steps: int | None,
    *,
    changes: Mapping[str, Mapping[str, Any]] = MappingProxyType({}),
    decoding: DecodingCfg | None = None,
) -> tuple[Proposer, DataSource]:
    """Load the model in a checkpoint, or the one that ships with a preset.

    Args:
        checkpoint: File of the checkpoint; None for the one that ships.
        preset: Preset of the one that ships; not read if `checkpoint` is given.
        device: Device on which the model computes.
        n_steps: Denoising steps; None are the preset's.
        changes: New values of fields of its configuration that sampling reads, by section; the
            section `sampler` is `SamplerCfg`.
        decoding: Corrections of drawn programs.

    Returns:
        The model, and its training data.

    Raises:
        CheckpointError: If it cannot be used.
        DiffusionError: If the number of steps is out of range.
        TrainingError: If a section or field of `changes` does not exist.
    """
    if checkpoint is None:
        if preset not in SHIPPED:
            raise CheckpointError(f"preset is {preset!r}; valid: {', '.join(SHIPPED)}")
        checkpoint = SHIPPED[preset]
    checkpoint = Path(checkpoint)
    # Sections first: they are cheap to read, and a wrong file is refused before its weights load.
    sections = read_sections(checkpoint)
    found = read_checkpoint(checkpoint)
    sections = changed({**sections, "sampler": _usual_sampler(found.known)}, changes)
    return _Loader(found, sections, device, n_steps, decoding).proposer(), found.facts.data


def _usual_sampler(known: Language | FlatStatistics) -> SamplerCfg:
    if isinstance(known, FlatStatistics):
        return paper_sampler(has_regions=bool(known.has_regions))
    return DEFAULT_SAMPLER


class _Loader:
    """The parts of a checkpoint on a device."""

    def __init__(
        self,
        checkpoint: Checkpoint,
        sections: Mapping[str, Any],
        device: torch.device,
        n_steps: int | None,
        decoding: DecodingCfg | None,
    ) -> None:
        self._checkpoint = checkpoint
        self._device = device
        self._sections = sections
        self._decoding = decoding
        self._schedule = Schedule(self._sections["schedule"])
        self._n_steps = n_steps

    def proposer(self) -> Proposer:
        """Return the proposer of scenes with this checkpoint."""
        known = self._checkpoint.known
        return self._flat(known) if isinstance(known, FlatStatistics) else self._ours(known)

    def _ours(self, language: Language) -> ProgramProposer:
        return ProgramProposer(
            language,
            self._loaded(new_writer(self._sections["writer"], language), "writer"),
            Denoising(
                language,
                self._denoiser(language),
                self._schedule,
                self._sampler(),
                self._device,
                self._decoding,
            ),
        )

    def _flat(self, statistics: FlatStatistics) -> FlatProposer:
        prior = self._loaded(SemanticPrior(self._sections["prior"]), "prior")
        read = FlatReader(statistics, self._device)
        # Categories that hold fine objects in training.
        is_hollow = torch.from_numpy(statistics.holds).to(self._device)
        return FlatProposer(
            FlatModel(
                contents=self._loaded(ContentsModel(self._sections["contents"]), "contents"),
                denoiser=self._denoiser(statistics),
                looks=Looks.from_json(self._checkpoint.facts.vocabulary),
                statistics=statistics,
                schedule=self._schedule,
                sampler=self._sampler(),
                guidance=Objectives(read, self._sections["guidance"], prior, is_hollow),
                device=self._device,
            )
        )

    def _denoiser(self, known: Language | FlatStatistics) -> nn.Module:
        network = new_denoiser(self._sections["model"], known, self._schedule)
        return self._loaded(network, "denoiser")

    def _loaded(self, module: Module, part: Part) -> Module:
        self._checkpoint.load_into(module, part)
        return module.to(self._device).eval()

    def _sampler(self) -> SamplerCfg:
        cfg: SamplerCfg = self._sections["sampler"]
        n_steps = cfg.n_steps if self._n_steps is None else self._n_steps
        # The network predicts the quantity that it was trained for, whatever `changes` says.
        kind = self._sections["loss"].parameterisation
        return replace(cfg, n_steps=n_steps, parameterisation=kind)
