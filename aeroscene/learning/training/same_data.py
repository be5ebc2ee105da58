"""What was begun on some data goes on with the same, and takes parts of the same alone."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from aeroscene.learning.training.checkpoint import Weights, read_checkpoint
from aeroscene.learning.training.checkpoint_facts import CheckpointFacts, DataSource, Part
from aeroscene.learning.training.config import TrainingError
from aeroscene.learning.training.data import TrainingData


def taken_parts(path: Path, data: TrainingData, trained: Collection[Part]) -> dict[Part, Weights]:
    """Parts of a checkpoint of the same data, without those that are trained here.

    What was streamed after the scenes that fix vocabulary and statistics does not matter.

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
    """Refuse to go on with other data than a training was begun on.

    Raises:
        TrainingError: If the scenes are others, or what is streamed after them.
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
