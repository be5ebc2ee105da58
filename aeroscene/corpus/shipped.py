"""The scenes that ship: a zip file of scene documents, each opened by its number.

    provenance.json     origin of the scenes, a `Provenance`
    summaries.json      a `SceneSummary` of each scene, in the order of their numbers
    scenes/0042.json    scene 42 as `scene.io` writes it, without the corners of the boxes

Zip was measured against Parquet. Both take 10 to 12 MB, but a process that opens a scene has loaded
zipfile already, whereas importing pyarrow alone takes longer than opening the scene.
"""

from __future__ import annotations

import hashlib
import lzma
import os
import struct
import zlib
from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import NoReturn
from zipfile import ZIP_DEFLATED, BadZipFile, ZipFile, ZipInfo

import msgspec

from aeroscene.corpus.summary import SceneSummary, Split, summarise
from aeroscene.files import replacing
from aeroscene.files.bounds import MOST_JSON_BYTES
from aeroscene.scene import Scene, SceneError
from aeroscene.scene.io import scene_from_json, scene_to_json

SHIPPED = Path(__file__).with_name("shipped_scenes.zip")
"""The archive in this package: 1,016 scenes, made by the model."""
_PROVENANCE, _SUMMARIES = "provenance.json", "summaries.json"
_WAY_OUT = "valid: the file that comes with the package; installing it again brings it back"
# What zipfile raises on damage; RuntimeError is its word for an unknown compression or a password.
_DAMAGE = (BadZipFile, EOFError, RuntimeError, ValueError, struct.error, zlib.error, lzma.LZMAError)


class ArchiveError(SceneError):
    """An archive that cannot be read; one line with its path, the reason and the way out."""


class Provenance(msgspec.Struct, frozen=True, kw_only=True):
    """Origin of the scenes of an archive, from which they can be made again."""

    generator: str
    """Name of the maker: the preset of the model, or curation."""
    checkpoint: str
    """SHA-256 of the file with the weights, hexadecimal; empty if there are none."""
    code: str
    """Version of the package, and digest of the sources that determine a scene."""
    environment: Mapping[str, str]
    """Versions of libraries, device and system, which determine a scene to the last bit."""
    attempts: Mapping[int, int]
    """Number of draws that were rejected before the one that ships, by number of scene, if there
    were any. The seed of a draw is the scene's seed with the number of the attempt.
    """


@dataclass(frozen=True, slots=True)
class ArchivedScenes:
    """Scenes of an archive, all of them or some."""

    place: Path
    """Archive of the set."""
    entries: tuple[SceneSummary, ...]
    """Scenes, in the order of their numbers."""

    @property
    def title(self) -> str:
        """Name of the set in a sentence."""
        return "shipped scenes"

    def of_split(self, split: Split) -> ArchivedScenes:
        """Select the scenes that stand for the paper's training scenes, or for its test scenes."""
        return ArchivedScenes(self.place, tuple(e for e in self.entries if e.split == split))

    def select(self, indices: Container[int]) -> ArchivedScenes:
        """Select the scenes whose numbers are among these, as far as they are there."""
        return ArchivedScenes(self.place, tuple(e for e in self.entries if e.index in indices))

    def read(self, entry: SceneSummary) -> Scene:
        """Read and validate one scene.

        Raises:
            SceneError: If the archive is missing or damaged, or the scene breaks a rule.
        """
        return _read_scene(self.place, entry.index)

    def scenes(self) -> Iterator[Scene]:
        """Read every scene, in the order of the numbers.

        Raises:
            SceneError: As `read` does.
        """
        return (self.read(entry) for entry in self.entries)


def open_shipped(path: Path | None = None) -> ArchivedScenes:
    """Open all scenes of an archive.

    Args:
        path: Archive; None stands for the one that comes with the package.

    Raises:
        ArchiveError: If the archive is missing or damaged.
    """
    path = path or SHIPPED
    try:
        entries = msgspec.json.decode(_member(path, _SUMMARIES), type=tuple[SceneSummary, ...])
    except (KeyError, msgspec.DecodeError):
        _damaged(path)
    return ArchivedScenes(path, entries)


def read_shipped(number: int) -> Scene:
    """Read one of the scenes that come with the package, validated: the same on every machine.

    Args:
        number: Number of the scene, 0 to 1015.

    Raises:
        SceneError: If there is no such scene, or the archive is missing or damaged.
    """
    return _read_scene(SHIPPED, number)


@cache
def shipped_digest() -> str:
    """SHA-256 of the archive in this package, hexadecimal: it identifies all its scenes."""
    with SHIPPED.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def write_archive(path: Path, scenes: Iterable[Scene], provenance: Provenance) -> int:
    """Write scenes 0, 1, 2 ... whole or not at all; equal scenes give equal files.

    Args:
        path: Archive to be replaced.
        scenes: Scenes in the order of their numbers.
        provenance: Origin of the scenes.

    Returns:
        Size of the file, bytes.

    Raises:
        OSError: If the file cannot be written.
    """
    summaries: list[SceneSummary] = []
    with replacing(path) as file:
        with ZipFile(file, "w", ZIP_DEFLATED, compresslevel=9) as archive:
            for number, scene in enumerate(scenes):
                # Corners follow from the boxes; leaving them out makes the archive smaller.
                text = scene_to_json(scene, with_corners=False)
                _add(archive, f"scenes/{number:04d}.json", text)
                summaries.append(summarise(scene, number))
            _add(archive, _SUMMARIES, msgspec.json.encode(summaries))
            _add(archive, _PROVENANCE, msgspec.json.encode(provenance))
        return file.tell()


def _add(archive: ZipFile, name: str, data: bytes) -> None:
    # Without the time of now, so that equal scenes give equal files.
    archive.writestr(ZipInfo(name), data, ZIP_DEFLATED, compresslevel=9)


def _read_scene(path: Path, number: int) -> Scene:
    try:
        text = _member(path, f"scenes/{number:04d}.json")
    except KeyError:
        last = len(open_shipped(path).entries) - 1
        raise ArchiveError(f"scene {number} is not in {str(path)!r}; valid: 0 to {last}") from None
    return scene_from_json(text, f"scene {number} of {str(path)!r}")


def _member(path: Path, name: str) -> bytes:
    """One file of an archive, whose checksum zipfile compares; KeyError if there is none."""
    try:
        archive = _opened(path)
        info = archive.getinfo(name)
        # A forged size would otherwise fill the memory before it is compared.
        if info.file_size > MOST_JSON_BYTES:
            _damaged(path)
        return archive.read(info)
    except _DAMAGE:
        _damaged(path)
    except OSError as error:
        reason = (error.strerror or type(error).__name__).lower()
        raise ArchiveError(f"archive {str(path)!r} cannot be read ({reason}); {_WAY_OUT}") from None


# Reading the table of contents takes 4 ms.
@lru_cache(maxsize=2)
def _opened(path: Path) -> ZipFile:
    return ZipFile(path)


# A file that a forked process shares with its parent has one position for both.
os.register_at_fork(after_in_child=_opened.cache_clear)


def _damaged(path: Path) -> NoReturn:
    raise ArchiveError(
        f"archive {str(path)!r} is damaged (cut short or changed); {_WAY_OUT}"
    ) from None
