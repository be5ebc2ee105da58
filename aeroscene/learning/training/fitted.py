"""Sections of a training, adapted to the kinds of its data."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from aeroscene.learning.program.program import N_CHANNELS
from aeroscene.learning.training.checkpoint import Known
from aeroscene.learning.training.config import TrainingError
from aeroscene.learning.training.presets import Sections
from aeroscene.learning.writer.language import Language


def fitted(sections: Sections, known: Known) -> dict[str, Any]:
    """Return sections whose network has a row for each kind of the data.

    Args:
        sections: Sections of a preset.
        known: Language or statistics of the data.

    Raises:
        TrainingError: If the network is not one for programs.
    """
    if not isinstance(known, Language):
        return dict(sections)
    model = sections["model"]
    if model.denoiser != "tokens" or model.channels != N_CHANNELS:
        raise TrainingError(
            f"model.denoiser is {model.denoiser!r} with {model.channels} channels; valid: 'tokens' "
            f"with {N_CHANNELS}; the paper's network needs --preset paper"
        )
    return {**sections, "model": replace(model, n_kinds=len(known.vocabulary.kinds))}
