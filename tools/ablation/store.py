"""Store of outcomes, row by row, so that a stopped run can continue."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np
from jaxtyping import Float

from ablation.measure import Case, SceneOutcome
from aeroscene.files import replacing


class Outcome(msgspec.Struct, frozen=True, kw_only=True):
    """Outcome of a row."""

    key: str
    """Differs where weights, programs or the way of sampling do."""
    scenes: list[SceneOutcome] = []
    """As the row samples them."""
    step_cpu_s: float | None = None
    """CPU time of a training step."""


def valid_shares(scenes: Sequence[SceneOutcome]) -> Float[np.ndarray, " scenes"]:
    """Percent of each scene's objects that are free and rightly supported."""
    return np.array([100 * scene.n_valid / scene.n_objects for scene in scenes])


def outcome_key(digest: str, cases: Sequence[Case], settings: object) -> str:
    """Sixteen hexadecimal digits of weights, cases, and the `repr` of whatever else decides."""
    text = f"{digest} {[case.number for case in cases]} {settings!r}"
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def read_outcome(path: Path, key: str) -> Outcome | None:
    """Read an earlier outcome; None where there is none, or one of something else."""
    try:
        found = msgspec.json.decode(path.read_bytes(), type=Outcome)
    except (FileNotFoundError, msgspec.DecodeError):
        return None
    return found if found.key == key else None


def write_outcome(path: Path, outcome: Outcome) -> None:
    """Keep what was measured.

    Raises:
        OSError: If it cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as file:
        file.write(msgspec.json.encode(outcome))
