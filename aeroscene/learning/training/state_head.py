"""Progress and facts of a training in a folder, read without PyTorch."""

from __future__ import annotations

from pathlib import Path

import msgspec
from safetensors import SafetensorError, safe_open

from aeroscene.learning.training.checkpoint_facts import (
    CheckpointError,
    CheckpointFacts,
    Part,
    require_short_head,
)

STATE = "state.safetensors"
VERSION = 2
KEY = "aeroscene-training"


class PartHead(msgspec.Struct, frozen=True, kw_only=True):
    """Progress of a part."""

    step: int
    seconds: float
    best_step: int = 0
    best_loss: float | None = None
    """Least held-out loss so far; None if none was measured."""


class StateHead(msgspec.Struct, frozen=True):
    """Facts that a state file stores beside its tensors."""

    version: int
    parts: dict[Part, PartHead]
    """Parts that are trained step by step, as far as they are."""
    facts: CheckpointFacts

    @property
    def steps(self) -> int:
        """Sum of the steps of all parts."""
        return sum(part.step for part in self.parts.values())


class _Version(msgspec.Struct):
    version: int = 0


def read_head(path: Path) -> StateHead | None:
    """Read the head of a training's state file; None if there is no file.

    Raises:
        CheckpointError: If it is damaged or of another version.
    """
    if not path.exists():
        return None
    try:
        require_short_head(path)
        with safe_open(path, framework="np") as file:
            text = (file.metadata() or {}).get(KEY, "")
        # The version alone first: another version may have other fields.
        version = msgspec.json.decode(text, type=_Version).version
        if version == VERSION:
            return msgspec.json.decode(text, type=StateHead)
    except (OSError, SafetensorError, msgspec.DecodeError, RecursionError) as error:
        raise CheckpointError(
            f"state {str(path)!r} is truncated or no state of a training ({error}); "
            "valid: as aeroscene train has written it; delete it to train anew"
        ) from None
    raise CheckpointError(
        f"state {str(path)!r} is of version {version}; valid: {VERSION}; delete it to train anew"
    )
