"""Checks that a training continues on the data that it began on, and takes parts of the same.

Vocabulary and statistics come from the data, and weights mean nothing with others.
"""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from aeroscene.learning.training.checkpoint import Weights, read_checkpoint
from aeroscene.learning.training.checkpoint_facts import CheckpointFacts, DataSource, Part
from aeroscene.learning.training.config import TrainingError
from aeroscene.learning.training.data import TrainingData


def taken_parts(path: Path, data: TrainingData, trained: Collection[Part]) -> dict[Part, Weights]:
    """Read the parts of a checkpoint that are not trained here.

    The checkpoint must be of the same data. Scenes that were streamed after those that fix
    vocabulary and statistics do not matter.

    Args:
        path: File of the checkpoint.
        data: Data of this training.
        trained: Parts that are trained here.

    Raises:
        CheckpointError: If the checkpoint cannot be used.
        TrainingError: If the checkpoint is of other data.
    """
    checkpoint = read_checkpoint(path)
    theirs, ours = checkpoint.facts.data, data.source
    if theirs.digest != ours.digest:
        raise TrainingError(
            f"checkpoint {str(path)!r} is of other data: {theirs.name!r} ({theirs.n_scenes} "
            f"scenes), not {ours.name!r} ({ours.n_scenes}); valid: one that was trained on the same"
        )
    return {part: checkpoint.parts[part] for part in checkpoint.parts if part not in trained}


def check_same_data(folder: Path, facts: CheckpointFacts, now: DataSource) -> None:
    """Refuse to continue a training with other data than it began on.

    Raises:
        TrainingError: If the scenes differ, or the stream after them does.
    """
    begun = facts.data
    if begun.digest != now.digest:
        raise TrainingError(
            f"data {now.name!r} ({now.n_scenes} scenes, digest {now.digest}) is not what the "
            f"training in {str(folder)!r} was begun on ({begun.n_scenes} scenes, digest "
            f"{begun.digest}); valid: the same data, or another folder"
        )
    if begun.stream != now.stream:
        raise TrainingError(
            f"stream is {now.stream or 'none'}; valid: {begun.stream or 'none'}, with which the "
            f"training in {str(folder)!r} was begun; or another folder"
        )
