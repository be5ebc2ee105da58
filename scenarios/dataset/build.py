"""Building of a dataset in a folder, which continues an interrupted build.

A build of all scenes takes minutes and may be killed. Each finished scene is therefore written to a
journal at once, and the manifest is written when the build ends, however it ends. Scenes carry the
digest of the sources that made them, so that a later build knows which ones to make again.
"""

from __future__ import annotations

import fcntl
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import BinaryIO

from aeroscene.corpus.dataset import (
    JOURNAL,
    SCENES,
    DatasetError,
    SceneEntry,
    is_whole,
    journal_line,
    make_scene,
    read_entries,
    write_manifest,
)
from aeroscene.corpus.provenance import curation_digest
from aeroscene.processes import run_all


@dataclass(frozen=True, kw_only=True, slots=True)
class BuildPlan:
    """Content of a build's folder, and the work left to do."""

    folder: Path
    make: Callable[[int], SceneEntry]
    """Function that makes a scene by its number, in any process."""
    kept: tuple[SceneEntry, ...]
    """Existing scenes, and scenes that were not requested."""
    to_make: tuple[int, ...]
    """Numbers of the scenes to make."""
    outdated: tuple[int, ...]
    """Requested scenes that exist but were made by other sources."""
    foreign: tuple[int, ...]
    """Kept scenes, not requested, that were made by other sources."""


def plan_build(folder: Path, indices: Sequence[int]) -> BuildPlan:
    """Plan the build of the corpus in a folder.

    Args:
        folder: Folder of the dataset, existing or not.
        indices: Numbers of the requested scenes.

    Raises:
        DatasetError: If the folder's manifest cannot be read.
    """
    return plan_folder(folder, indices, partial(make_scene, folder), curation_digest())


def plan_folder(
    folder: Path, indices: Sequence[int], make: Callable[[int], SceneEntry], sources: str
) -> BuildPlan:
    """Plan the build of a dataset in a folder.

    Args:
        folder: Folder of the dataset, existing or not.
        indices: Numbers of the requested scenes.
        make: Function that makes one scene and writes its file.
        sources: Digest of the sources; scenes with another digest are made again.

    Raises:
        DatasetError: If the folder's manifest cannot be read.
    """
    # An entry whose file is damaged or missing counts as not made.
    present = {e.index: e for e in read_entries(folder) if is_whole(folder, e)}
    is_current = {index: entry.sources == sources for index, entry in present.items()}
    wanted = sorted(set(indices))
    to_make = [index for index in wanted if not is_current.get(index, False)]
    return BuildPlan(
        folder=folder,
        make=make,
        kept=tuple(entry for index, entry in present.items() if index not in to_make),
        to_make=tuple(to_make),
        outdated=tuple(index for index in to_make if index in present),
        foreign=tuple(i for i in present if not is_current[i] and i not in to_make),
    )


def build(plan: BuildPlan, jobs: int, on_scene: Callable[[SceneEntry], None]) -> int:
    """Execute a plan; however it ends, the folder holds what is finished.

    Args:
        plan: Plan from `plan_build`.
        jobs: Number of processes.
        on_scene: Called with each finished scene.

    Returns:
        Total size of the scenes' files in the manifest, bytes.

    Raises:
        DatasetError: If another build is running in the folder.
        OSError: If a file cannot be written.
        WorkerDiedError: If a process was killed.
    """
    folder = plan.folder
    (folder / SCENES).mkdir(parents=True, exist_ok=True)
    entries = list(plan.kept)
    with _journal(folder) as journal:
        try:
            with closing(run_all(plan.make, plan.to_make, jobs)) as made:
                for entry in made:
                    # Flushed for each scene, because a killed process writes nothing more.
                    journal.write(journal_line(entry))
                    journal.flush()
                    entries.append(entry)
                    on_scene(entry)
        finally:
            _remove_unfinished(folder)
            write_manifest(folder, entries)
            # Only once the manifest has its entries.
            (folder / JOURNAL).unlink()
    return sum((folder / entry.file).stat().st_size for entry in entries)


@contextmanager
def _journal(folder: Path) -> Iterator[BinaryIO]:
    """Open the journal for appending, with an exclusive lock."""
    with (folder / JOURNAL).open("ab") as journal:
        try:
            # The system releases the lock of a killed process, unlike a file that marks it.
            fcntl.flock(journal, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise DatasetError(
                f"folder {str(folder)!r} is being built by another process; "
                "valid: wait for its end, or another folder"
            ) from None
        _remove_unfinished(folder)
        # The last line of a killed build may be incomplete; a line break ends it.
        journal.write(b"\n" if journal.tell() else b"")
        yield journal


def _remove_unfinished(folder: Path) -> None:
    """Remove the unfinished files of a killed process."""
    for path in (folder / SCENES).glob(".*.json.gz.*"):
        path.unlink(missing_ok=True)
