"""The three presets: every section of a training's configuration, by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

from aeroscene.learning.diffusion.config import LossCfg, ScheduleCfg
from aeroscene.learning.model.config import ModelCfg
from aeroscene.learning.training.checkpoint_facts import Part, read_facts
from aeroscene.learning.training.config import Budget, Preset, TrainCfg, TrainingError
from aeroscene.learning.training.network_sizes import require_filled
from aeroscene.learning.training.paper_preset import PAPER_SECTIONS, PROGRESSIVE_SECTIONS
from aeroscene.learning.training.settings import section_from_plain, section_to_plain
from aeroscene.learning.writer.config import WriterCfg

_SHARED = ("model", "schedule", "loss", "training")
Sections = Mapping[str, Any]
"""Frozen dataclasses by the name of their section."""

_DEFAULT: Sections = {
    "model": ModelCfg(),
    "schedule": ScheduleCfg(),
    "loss": LossCfg(),
    "training": TrainCfg(learning_rate=1e-3, second_decay=0.99),
    "writer": WriterCfg(),
    "writer_training": TrainCfg(learning_rate=1e-3, second_decay=0.99, weight_decay=0.02),
}
_SECTIONS: Mapping[Preset, Sections] = {
    "default": _DEFAULT,
    "paper": PAPER_SECTIONS,
    "progressive": PROGRESSIVE_SECTIONS,
}
_CONTENTS_SHARE = 0.08
"""Share of the minutes of a training for the contents model."""
_KINDS: Mapping[str, type] = {
    name: type(section) for name, section in {**_DEFAULT, **PAPER_SECTIONS}.items()
}
PARTS: Mapping[Preset, tuple[Part, ...]] = {
    "default": ("writer", "denoiser"),
    "paper": ("contents", "prior", "denoiser"),
    "progressive": ("contents", "prior", "denoiser"),
}
"""Parts of each preset, in the order of their training. The prior comes before the denoiser,
because L_guide reads it."""


def preset_sections(preset: Preset) -> dict[str, Any]:
    """Return the sections of a preset.

    Raises:
        TrainingError: If there is no such preset.
    """
    if preset not in get_args(Preset):
        raise TrainingError(f"preset is {preset!r}; valid: {', '.join(get_args(Preset))}")
    return dict(_SECTIONS[preset])


def part_budgets(
    parts: Sequence[Part], steps: int | None, minutes: float | None
) -> dict[Part, Budget]:
    """Return the length of each part's training: equal steps, or equal shares of the minutes.

    The contents model has a small share, and the semantic prior a length of its own.

    Args:
        parts: Parts to train.
        steps: Steps of each part.
        minutes: Minutes of the whole training.

    Raises:
        TrainingError: If there is no end, or it is out of range.
    """
    shared: list[Part] = [part for part in parts if part != "prior"]
    seconds = None if minutes is None else 60.0 * minutes
    # Checks the range of the whole, before it is divided.
    Budget(steps, seconds)
    if seconds is None:
        return dict.fromkeys(shared, Budget(steps))
    if "contents" in shared and len(shared) > 1:
        # The contents model takes a small share, the denoiser the rest.
        shares = {"contents": _CONTENTS_SHARE, "denoiser": 1 - _CONTENTS_SHARE}
    else:
        shares = dict.fromkeys(shared, 1 / max(1, len(shared)))
    return {part: Budget(steps, shares[part] * seconds) for part in shared}


def is_flat(sections: Sections) -> bool:
    """True if the model sees scenes as the paper does: lists of boxes with categories."""
    return sections["model"].n_categories > 0


def sections_to_plain(sections: Sections) -> dict[str, dict[str, Any]]:
    """Return sections as plain data, as a checkpoint stores them."""
    return {name: section_to_plain(section) for name, section in sections.items()}


def sections_from_plain(plain: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Return sections from the plain data of `sections_to_plain`.

    Raises:
        TrainingError: If a section is missing, unknown, or out of range.
    """
    unknown = [name for name in plain if name not in _KINDS]
    if unknown:
        raise TrainingError(f"section [{unknown[0]}] is unknown; valid: {', '.join(_KINDS)}")
    missing = [name for name in _SHARED if name not in plain]
    if missing:
        raise TrainingError(f"section [{missing[0]}] is missing; valid: {', '.join(_KINDS)}")
    return {name: section_from_plain(_KINDS[name], values, name) for name, values in plain.items()}


def read_sections(path: Path, *, any_catalogue: bool = False) -> dict[str, Any]:
    """Read the sections of a checkpoint's training, after a check of its file.

    Args:
        path: File of the checkpoint.
        any_catalogue: True accepts the categories of an earlier catalogue.

    Raises:
        CheckpointError: If the file cannot be used.
        TrainingError: If a section is missing, unknown, or out of range.
    """
    try:
        sections = sections_from_plain(read_facts(path, any_catalogue=any_catalogue).configs)
    except TrainingError as error:
        raise error.within(f"checkpoint {str(path)!r}") from None
    require_filled(path, sections)
    return sections
