"""Options that several of the dataset's commands share."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import tyro

from aeroscene.corpus.dataset import Dataset, DatasetError, open_dataset
from aeroscene.corpus.provenance import curation_digest
from aeroscene.corpus.summary import SceneSet
from scenarios.cli.scene_numbers import scene_numbers

Data = tyro.conf.Positional[
    Annotated[str, tyro.conf.arg(metavar="[DIR|shipped]", help_behavior_hint="")]
]
"""Name of a dataset: a folder, or `shipped`; empty for the default."""
SceneNumbers = Annotated[str, tyro.conf.arg(help_behavior_hint="")]
"""Numbers of scenes as `scene_numbers` reads them; empty for the default."""

MAX_JOBS = 512
SHIPPED_NAME = "shipped"
_USUAL_FOLDER = Path("corpus")


def check_jobs(jobs: int) -> None:
    """Refuse a number of processes that is out of range.

    Raises:
        DatasetError: If the number is out of range.
    """
    if not 1 <= jobs <= MAX_JOBS:
        raise DatasetError(f"jobs {jobs} is out of range, valid: 1 to {MAX_JOBS} processes")


def open_scenes(data: str, scenes: str) -> SceneSet[Any]:
    """Open the scenes of a dataset that a user names, or all of them for an empty text.

    Args:
        data: A folder, or `shipped`; where it is empty, ./corpus if that is there, else shipped.
        scenes: Numbers as `scene_numbers` reads them.

    Raises:
        SceneNumbersError: If the text names no scenes.
        SceneError: If there is no dataset, or a scene that is named is not in it.
    """
    if data == SHIPPED_NAME or not (data or _USUAL_FOLDER.is_dir()):
        from aeroscene.corpus.shipped import open_shipped  # noqa: PLC0415 - only for these

        return _select(open_shipped(), scenes)
    dataset = _select(open_dataset(data or _USUAL_FOLDER), scenes)
    _mention_foreign(dataset)
    return dataset


def _select(dataset: SceneSet[Any], scenes: str) -> SceneSet[Any]:
    if not scenes:
        return dataset
    wanted = scene_numbers(scenes)
    present = {entry.index for entry in dataset.entries}
    missing = [number for number in wanted if number not in present]
    if missing:
        way_out = (
            f"aeroscene dataset build --scenes {scenes} makes them"
            if isinstance(dataset, Dataset)
            else f"0 to {len(present) - 1}"
        )
        raise DatasetError(
            f"scene {missing[0]} is not in {str(dataset.place)!r} ({len(missing)} of those asked "
            f"for are not), valid: {way_out}"
        )
    return dataset.select(frozenset(wanted))


def _mention_foreign(dataset: SceneSet[Any]) -> None:
    """Say on standard error when the present code would make other scenes than those."""
    curated = [entry for entry in dataset.entries if entry.scene_id.startswith("corpus-")]
    n_foreign = sum(entry.sources != curation_digest() for entry in curated)
    if n_foreign:
        sys.stderr.write(
            f"aeroscene dataset: {n_foreign} of {len(dataset.entries)} scenes in {dataset.place} "
            "were made by other sources than these; aeroscene dataset build makes them again\n"
        )
