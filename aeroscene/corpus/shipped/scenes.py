"""The scenes that come with the package: 1,016 of them, made by the model."""

from __future__ import annotations

import hashlib
from collections.abc import Container, Iterator
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

from aeroscene.corpus.shipped.archive import open_archive
from aeroscene.corpus.summary import SceneSummary, Split
from aeroscene.scene import Scene

SHIPPED = Path(__file__).with_name("scenes.aeroscenes")
"""The archive in this package."""


@cache
def shipped_digest() -> str:
    """SHA-256 of the archive in this package, hexadecimal: which scenes the numbers name."""
    with SHIPPED.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


_opened = lru_cache(maxsize=2)(open_archive)


@dataclass(frozen=True, slots=True)
class ArchivedScenes:
    """Scenes of an archive, all of them or some."""

    place: Path
    """The archive."""
    entries: tuple[SceneSummary, ...]
    """Scenes, in the order of their numbers."""

    @property
    def title(self) -> str:
        """What to call the set in a sentence."""
        return "shipped scenes"

    def of_split(self, split: Split) -> ArchivedScenes:
        """The scenes that stand for the paper's training scenes, or those for its test scenes."""
        return ArchivedScenes(self.place, tuple(e for e in self.entries if e.split == split))

    def select(self, indices: Container[int]) -> ArchivedScenes:
        """The scenes whose numbers are among these."""
        return ArchivedScenes(self.place, tuple(e for e in self.entries if e.index in indices))

    def read(self, entry: SceneSummary) -> Scene:
        """Read and validate one scene.

        Raises:
            ArchiveError: If the archive is missing or damaged.
        """
        return _opened(self.place).read(entry.index)

    def scenes(self) -> Iterator[Scene]:
        """Read every scene, in the order of the numbers.

        Raises:
            ArchiveError: As `read` does.
        """
        return (self.read(entry) for entry in self.entries)


def open_shipped(path: Path | None = None) -> ArchivedScenes:
    """All scenes of an archive, where None of the one that comes with the package.

    Raises:
        ArchiveError: If the archive is missing or damaged.
    """
    path = path or SHIPPED
    return ArchivedScenes(path, _opened(path).summaries())


def read_shipped(number: int) -> Scene:
    """One of the scenes that come with the package, validated: the same on every machine.

    Args:
        number: From 0 to 1015.

    Raises:
        ArchiveError: If there is no such scene, or the archive is missing or damaged.
    """
    return _opened(SHIPPED).read(number)
