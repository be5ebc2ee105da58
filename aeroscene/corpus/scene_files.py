"""Folders of scene files without a manifest, such as those that `aeroscene generate` writes."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass
from pathlib import Path

import msgspec

from aeroscene.areas.landing import derive_interaction_areas
from aeroscene.corpus.dataset import JOURNAL, MANIFEST, Dataset, open_dataset
from aeroscene.corpus.summary import SceneSummary, summarise
from aeroscene.scene import Scene
from aeroscene.scene.io import read_scene


class FileEntry(SceneSummary, frozen=True, kw_only=True):
    """Summary of a scene file; its index is its place among the names."""

    file: str
    """Name in the folder."""


@dataclass(frozen=True, slots=True)
class SceneFiles:
    """Scenes in the files of a folder, by name; a part of them is a `SceneFiles` too."""

    folder: Path
    entries: tuple[FileEntry, ...]

    @property
    def title(self) -> str:
        """Name of the set in a sentence."""
        return "folder"

    @property
    def place(self) -> Path:
        """Folder of the set."""
        return self.folder

    def select(self, indices: Container[int]) -> SceneFiles:
        """Select the scenes whose places among the names are among these."""
        return SceneFiles(self.folder, tuple(e for e in self.entries if e.index in indices))

    def read(self, entry: FileEntry) -> Scene:
        """Read and validate one scene.

        Raises:
            SceneError: If the file is missing, damaged, or no scene.
        """
        # Generated files may lack areas, which are derived as they are read.
        return read_scene(self.folder / entry.file, derive_interaction_areas)


def open_folder(folder: str | Path) -> Dataset | SceneFiles:
    """Open the scenes in a folder: a dataset if it has a manifest, else all its scene files.

    Without a manifest every file is read, because nothing else says what it contains.

    Args:
        folder: The folder.

    Raises:
        SceneError: If there is neither, or one of the files is no scene.
    """
    folder = Path(folder)
    # Without scene files the error of a missing dataset is the one that helps.
    names = [] if is_dataset(folder) or not folder.is_dir() else _scene_files(folder)
    if not names:
        return open_dataset(folder)
    return SceneFiles(folder, tuple(_entry(folder, *each) for each in enumerate(names)))


def is_dataset(folder: Path) -> bool:
    """Return true if a folder holds a dataset, whole or as far as its build has come."""
    return any((folder / name).exists() for name in (MANIFEST, JOURNAL))


def _scene_files(folder: Path) -> list[str]:
    endings = (".json", ".json.gz")
    return sorted(
        path.name
        for path in folder.iterdir()
        if path.name.endswith(endings) and not path.name.startswith(".")
    )


def _entry(folder: Path, index: int, name: str) -> FileEntry:
    summary = summarise(read_scene(folder / name, derive_interaction_areas), index)
    return FileEntry(**msgspec.structs.asdict(summary), file=name)
