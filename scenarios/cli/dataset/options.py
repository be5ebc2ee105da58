"""Options that several of the dataset's commands share."""

from __future__ import annotations

import sys
from pathlib import Path

from aeroscene.dataset import Dataset, DatasetError, open_dataset
from aeroscene.provenance import curation_digest
from scenarios.cli.scene_numbers import scene_numbers

MAX_JOBS = 512


def check_jobs(jobs: int) -> None:
    """Refuse a number of processes that makes no sense.

    Raises:
        DatasetError: Saying what is valid.
    """
    if not 1 <= jobs <= MAX_JOBS:
        raise DatasetError(f"jobs {jobs} is out of range, valid: 1 to {MAX_JOBS} processes")


def open_scenes(folder: Path, scenes: str) -> Dataset:
    """The part of a folder that a user names, all of it for an empty text.

    Says on standard error when it does not hold what the code that runs would make.

    Raises:
        SceneNumbersError: If the text names no scenes.
        DatasetError: If there is no dataset, or a scene that is named is not in it.
    """
    dataset = open_dataset(folder)
    if scenes:
        dataset = _select(dataset, scenes)
    n_foreign = sum(entry.sources != curation_digest() for entry in dataset.entries)
    if n_foreign:
        sys.stderr.write(
            f"aeroscene dataset: {n_foreign} of {len(dataset.entries)} scenes in {folder} were "
            "made by other sources than these; aeroscene dataset build makes them again\n"
        )
    return dataset


def _select(dataset: Dataset, scenes: str) -> Dataset:
    wanted = scene_numbers(scenes)
    present = {entry.index for entry in dataset.entries}
    missing = [number for number in wanted if number not in present]
    if missing:
        raise DatasetError(
            f"scene {missing[0]} is not in {str(dataset.folder)!r} ({len(missing)} of those asked "
            f"for are not), valid: aeroscene dataset build --scenes {scenes} makes them"
        )
    return dataset.select(frozenset(wanted))
