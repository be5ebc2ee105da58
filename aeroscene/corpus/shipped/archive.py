"""The file that holds the shipped scenes: what made them, a table, then blocks of scenes.

    magic, length and SHA-256 of the header
    header       JSON: format, version, provenance, sizes and digests of the parts
    summaries    what `aeroscene.corpus.dataset.SceneSummary` says of each scene
    blocks       sixteen scenes each, in the order of their numbers

A part is read only where its digest is the header's, and the header only where its own is right: a
damaged file gives one line instead of another scene.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import NoReturn

import msgspec

from aeroscene.corpus.shipped.block import Block, decode_block, encode_block
from aeroscene.corpus.shipped.summaries import decode_summaries, encode_summaries
from aeroscene.corpus.summary import SceneSummary, summarise
from aeroscene.files import replacing
from aeroscene.scene import Scene, SceneError
from aeroscene.scene.io import scene_from_json, scene_to_json

FORMAT = "aeroscene-archive"
VERSION = 1
SCENES_A_BLOCK = 16
"""More take less room and longer to open."""
_MAGIC = b"\x89AEROSCN"
_HEAD = struct.Struct("<8sI32s")
_LARGEST_HEADER = 1 << 20


class ArchiveError(SceneError):
    """An archive that cannot be read or made; one line saying which, what and what is valid."""


class Provenance(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What made the scenes of an archive."""

    generator: str
    """What drew them: the preset of the model, or curation."""
    checkpoint: str
    """SHA-256 of the file with the weights, hexadecimal; empty where there are none."""
    code: str
    """Version of the package and digest of the sources that decide what is in a scene."""
    environment: Mapping[str, str]
    """What else decides it to the last bit: versions of libraries, device, system."""
    attempts: Mapping[int, int]
    """Draws that were rejected before a scene's own, by its number, where there were any. The seed
    of a draw is the scene's seed, which it says itself, with the number of the attempt."""


class _Part(msgspec.Struct, frozen=True):
    size: int
    sha256: str


class _Header(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    format: str
    version: int
    scenes: int
    scenes_a_block: int
    provenance: Provenance
    parts: tuple[_Part, ...]
    """The summaries, then the blocks."""


class _Version(msgspec.Struct, frozen=True):
    format: str
    version: int


@dataclass(frozen=True, slots=True)
class Archive:
    """An archive whose header has been read."""

    path: Path
    header: _Header
    start: int
    """Where the parts begin in the file."""

    @property
    def provenance(self) -> Provenance:
        """What made the scenes."""
        return self.header.provenance

    def __len__(self) -> int:
        """Number of scenes."""
        return self.header.scenes

    def read(self, number: int) -> Scene:
        """One scene, validated.

        Raises:
            ArchiveError: If the number is none of the archive's, or the file is damaged.
        """
        if not 0 <= number < len(self):
            raise ArchiveError(
                f"scene {number} is not in {str(self.path)!r}, valid: 0 to {len(self) - 1}"
            )
        block, place = divmod(number, self.header.scenes_a_block)
        return _block(self.path, *self._place(1 + block)).scene(place)

    def summaries(self) -> tuple[SceneSummary, ...]:
        """What there is to know of each scene, in the order of the numbers.

        Raises:
            ArchiveError: If the file is damaged.
        """
        return decode_summaries(_read_part(self.path, *self._place(0)))

    def _place(self, number: int) -> tuple[int, _Part]:
        """Where a part begins in the file, and what the header says of it."""
        parts = self.header.parts
        return self.start + sum(part.size for part in parts[:number]), parts[number]


# Scenes are often read one after another.
@lru_cache(maxsize=2)
def _block(path: Path, start: int, part: _Part) -> Block:
    return decode_block(_read_part(path, start, part))


def _read_part(path: Path, start: int, part: _Part) -> bytes:
    data = _read_bytes(path, start, part.size)
    if hashlib.sha256(data).hexdigest() != part.sha256:
        _damaged(path, "cut short or changed")
    return data


def open_archive(path: Path) -> Archive:
    """Read the header of an archive.

    Raises:
        ArchiveError: If there is none, or it is damaged, or of another version.
    """
    head = _read_bytes(path, 0, _HEAD.size)
    if len(head) < _HEAD.size or not head.startswith(_MAGIC):
        _damaged(path, "no archive of scenes, or cut short")
    _, size, digest = _HEAD.unpack(head)
    text = _read_bytes(path, _HEAD.size, min(size, _LARGEST_HEADER))
    if hashlib.sha256(text).digest() != digest:
        _damaged(path, "cut short or changed")
    found = msgspec.json.decode(text, type=_Version)
    if (found.format, found.version) != (FORMAT, VERSION):
        raise ArchiveError(
            f"archive {str(path)!r}: format is {found.format!r} version {found.version}, "
            f"valid: {FORMAT!r} version {VERSION}"
        )
    return Archive(path, msgspec.json.decode(text, type=_Header), _HEAD.size + size)


def _read_bytes(path: Path, start: int, size: int) -> bytes:
    try:
        with path.open("rb") as file:
            file.seek(start)
            return file.read(size)
    except OSError as error:
        reason = (error.strerror or type(error).__name__).lower()
        raise ArchiveError(
            f"archive {str(path)!r} cannot be read ({reason}), valid: the file that comes with the "
            "package; installing it again brings it back"
        ) from None


def _damaged(path: Path, how: str) -> NoReturn:
    raise ArchiveError(
        f"archive {str(path)!r} is damaged ({how}), valid: the file that comes with the package; "
        "installing it again brings it back"
    ) from None


def write_archive(path: Path, scenes: Iterable[Scene], provenance: Provenance) -> int:
    """Write scenes 0, 1, 2 ... whole or not at all, once each of them comes back as it was.

    Returns:
        Size of the file, bytes.

    Raises:
        ArchiveError: If a scene would not come back byte for byte as the JSON that it is now.
        OSError: If the file cannot be written.
    """
    summaries: list[SceneSummary] = []
    blocks: list[bytes] = []
    for group in _groups(scenes):
        texts = [scene_to_json(scene) for scene in group]
        data = encode_block([scene_from_json(text) for text in texts])
        _compare(decode_block(data), texts)
        summaries += [summarise(scene, len(summaries) + i) for i, scene in enumerate(group)]
        blocks.append(data)
    parts = (encode_summaries(summaries), *blocks)
    header = msgspec.json.encode(
        _Header(
            format=FORMAT,
            version=VERSION,
            scenes=len(summaries),
            scenes_a_block=SCENES_A_BLOCK,
            provenance=provenance,
            parts=tuple(_Part(len(part), hashlib.sha256(part).hexdigest()) for part in parts),
        )
    )
    head = _HEAD.pack(_MAGIC, len(header), hashlib.sha256(header).digest())
    with replacing(path) as file:
        return sum(file.write(data) for data in (head, header, *parts))


def _groups(scenes: Iterable[Scene]) -> Iterator[list[Scene]]:
    rest = iter(scenes)
    while group := list(islice(rest, SCENES_A_BLOCK)):
        yield group


def _compare(block: Block, texts: list[bytes]) -> None:
    for place, text in enumerate(texts):
        scene = block.scene(place)
        if scene_to_json(scene) != text:
            raise ArchiveError(f"scene {scene.scene_id!r} does not come back from the archive")
