"""Builds a dataset into a folder, goes on where an earlier build stopped."""

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
from scenarios.dataset.pool import run_all


@dataclass(frozen=True, kw_only=True, slots=True)
class BuildPlan:
    """What a build finds in its folder and what is left to do."""

    folder: Path
    make: Callable[[int], SceneEntry]
    """Makes a scene by its number, in any process."""
    kept: tuple[SceneEntry, ...]
    """Scenes that are there already, or that were not asked for."""
    to_make: tuple[int, ...]
    """Numbers of the scenes to make."""
    outdated: tuple[int, ...]
    """Scenes that were asked for and are there, but were made by other sources."""
    foreign: tuple[int, ...]
    """Scenes that stay, not asked for, made by other sources."""


def plan_build(folder: Path, indices: Sequence[int]) -> BuildPlan:
    """Look at what is there of the corpus.

    Raises:
        DatasetError: If the folder's manifest cannot be read.
    """
    return plan_folder(folder, indices, partial(make_scene, folder), curation_digest())


def plan_folder(
    folder: Path, indices: Sequence[int], make: Callable[[int], SceneEntry], sources: str
) -> BuildPlan:
    """Look at what is there of a dataset.

    Args:
        folder: Where it is, or will be.
        indices: Numbers of the scenes that are wanted.
        make: Makes one of them and writes its file.
        sources: Digest of what it is made by; scenes with another one are made again.

    Raises:
        DatasetError: If the folder's manifest cannot be read.
    """
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
    """Make what the plan says; however it ends, the folder holds what is finished.

    Args:
        plan: From `plan_build`.
        jobs: Processes.
        on_scene: Told of each scene when it is finished.

    Returns:
        Size of the scenes' files that the manifest lists, bytes.

    Raises:
        DatasetError: If another build is at work in the folder.
        OSError: If a file cannot be written.
        WorkerDiedError: If a process was ended from outside.
    """
    folder = plan.folder
    (folder / SCENES).mkdir(parents=True, exist_ok=True)
    entries = list(plan.kept)
    with _journal(folder) as journal:
        try:
            with closing(run_all(plan.make, plan.to_make, jobs)) as made:
                for entry in made:
                    journal.write(journal_line(entry))
                    journal.flush()
                    entries.append(entry)
                    on_scene(entry)
        finally:
            _remove_unfinished(folder)
            write_manifest(folder, entries)
            (folder / JOURNAL).unlink()
    return sum((folder / entry.file).stat().st_size for entry in entries)


@contextmanager
def _journal(folder: Path) -> Iterator[BinaryIO]:
    """The journal to append to, ours alone."""
    with (folder / JOURNAL).open("ab") as journal:
        try:
            fcntl.flock(journal, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise DatasetError(
                f"folder {str(folder)!r} is being built by another process, "
                "valid: wait for its end, or another folder"
            ) from None
        _remove_unfinished(folder)
        # The last line of a build that was killed may be cut short.
        journal.write(b"\n" if journal.tell() else b"")
        yield journal


def _remove_unfinished(folder: Path) -> None:
    """Remove what a process that was killed was writing."""
    for path in (folder / SCENES).glob(".*.json.gz.*"):
        path.unlink(missing_ok=True)
