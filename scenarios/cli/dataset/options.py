"""Options that several of the dataset's commands share."""

from __future__ import annotations

from aeroscene.dataset import Dataset, DatasetError
from scenarios.cli.scene_numbers import scene_numbers

MAX_JOBS = 512


def check_jobs(jobs: int) -> None:
    """Refuse a number of processes that makes no sense.

    Raises:
        DatasetError: Saying what is valid.
    """
    if not 1 <= jobs <= MAX_JOBS:
        raise DatasetError(f"jobs {jobs} is out of range, valid: 1 to {MAX_JOBS} processes")


def select_scenes(dataset: Dataset, scenes: str) -> Dataset:
    """The part of a dataset that a user names; everything for an empty text.

    Raises:
        SceneNumbersError: If the text names no scenes.
        DatasetError: If a scene that is named is not in the folder.
    """
    if not scenes:
        return dataset
    wanted = scene_numbers(scenes)
    present = {entry.index for entry in dataset.entries}
    missing = [number for number in wanted if number not in present]
    if missing:
        raise DatasetError(
            f"scene {missing[0]} is not in {str(dataset.folder)!r} ({len(missing)} of those asked "
            f"for are not), valid: aeroscene dataset build --scenes {scenes} makes them"
        )
    return dataset.select(frozenset(wanted))
