"""Options that several of the dataset's commands share."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import tyro

from aeroscene.corpus.dataset import Dataset, DatasetError, open_dataset, shortfall
from aeroscene.corpus.provenance import curation_digest
from aeroscene.corpus.scene_files import is_dataset, open_folder
from aeroscene.corpus.summary import SceneSet
from aeroscene.ranges import Range
from scenarios.cli.scene_numbers import scene_numbers

Data = tyro.conf.Positional[
    Annotated[str, tyro.conf.arg(metavar="[DIR|shipped]", help_behavior_hint="")]
]
"""Name of a dataset: a folder, or `shipped`; empty for the default."""
SceneNumbers = Annotated[str, tyro.conf.arg(help_behavior_hint="")]
"""Numbers of scenes as `scene_numbers` reads them; empty for the default."""

_PROG = "aeroscene dataset"
JOBS = Range(1, 512)
"""Processes of a command."""
SHIPPED_NAME = "shipped"
_USUAL_FOLDER = Path("corpus")  # The default of `dataset build`, so both commands agree.


def open_scenes(data: str, scenes: str) -> SceneSet[Any]:
    """Open the scenes of a dataset that a user names, or all of them for an empty text.

    Args:
        data: A folder of a dataset or of scene files, or `shipped`. An empty text takes ./corpus if
            it exists, else shipped.
        scenes: Numbers as `scene_numbers` reads them.

    Raises:
        SceneNumbersError: If the text names no scenes.
        SceneError: If there is no dataset, or a scene that is named is not in it.
    """
    if _is_shipped(data):
        from aeroscene.corpus.shipped import open_shipped

        return _select(open_shipped(), scenes)
    dataset = _select(open_folder(data or _USUAL_FOLDER), scenes)
    if isinstance(dataset, Dataset):
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
            f"for are not); valid: {way_out}"
        )
    return dataset.select(frozenset(wanted))


def mention_part(data: str, scenes: str) -> None:
    """Report on standard error if a dataset holds only a part of the corpus.

    Args:
        data: As `open_scenes` takes it.
        scenes: Numbers that the user named. If there are any, nothing is printed, because a user
            who names scenes knows that there are others.
    """
    folder = Path(data or _USUAL_FOLDER)
    if not (scenes or _is_shipped(data)) and is_dataset(folder):
        mention_shortfall(_PROG, folder)


def mention_shortfall(prog: str, folder: Path) -> None:
    """Report on standard error if a folder holds only a part of the corpus.

    Args:
        prog: Command that names itself in the line.
        folder: Folder of a dataset.

    Raises:
        SceneError: If it holds no dataset.
    """
    said = shortfall(open_dataset(folder))
    if said is not None:
        sys.stderr.write(f"{prog}: {said}\n")


def _is_shipped(data: str) -> bool:
    return data == SHIPPED_NAME or not (data or _USUAL_FOLDER.is_dir())


def _mention_foreign(dataset: Dataset) -> None:
    """Report on standard error if the present code would make other scenes than those."""
    # Scenes of other origin, such as generated ones, have no curation to compare.
    curated = [entry for entry in dataset.entries if entry.scene_id.startswith("corpus-")]
    n_foreign = sum(entry.sources != curation_digest() for entry in curated)
    if n_foreign:
        sys.stderr.write(
            f"{_PROG}: {n_foreign} of {len(dataset.entries)} scenes in {dataset.place} "
            "were made by other sources than these; aeroscene dataset build makes them again\n"
        )
