"""Writing of the scenes of a dataset as JSON files, in parallel."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path

from aeroscene.corpus.summary import Entry, SceneSet
from aeroscene.files.names import file_name
from aeroscene.processes import run_all
from aeroscene.scene.io import write_scene


def unpack_all(
    dataset: SceneSet[Entry], folder: Path, suffix: str, jobs: int, on_scene: Callable[[], None]
) -> int:
    """Write every scene into a folder, each file whole or not at all.

    Args:
        dataset: Scenes to write.
        folder: Target folder; it is created if missing.
        suffix: `.json`, or `.json.gz` for compressed files.
        jobs: Number of processes.
        on_scene: Called after each scene.

    Returns:
        Total size of the files, bytes.

    Raises:
        SceneError: If a scene cannot be read.
        OSError: If a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    n_bytes = 0
    # A set without entries can still read scenes, and is quick to send to a process.
    unpack = partial(_unpack, dataset.select(()), folder, suffix)
    with closing(run_all(unpack, dataset.entries, jobs)) as sizes:
        for size in sizes:
            n_bytes += size
            on_scene()
    return n_bytes


def _unpack(reader: SceneSet[Entry], folder: Path, suffix: str, entry: Entry) -> int:
    # Names of scenes come from files, and may hold what a file's name cannot.
    path = folder / f"{file_name(entry.scene_id)}{suffix}"
    write_scene(reader.read(entry), path)
    return path.stat().st_size
