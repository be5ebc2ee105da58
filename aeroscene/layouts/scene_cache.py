"""Cache of layouts that have been mapped to scenes.

Mapping takes a tenth of a second a room, and a file has a thousand. Scenes are kept under a hash of
the file and of all sources on which mapping depends; a damaged or foreign file counts as missing.
They are in the folder `layouts` of the user's cache (or of `AEROSCENE_CACHE_DIR`);
`AEROSCENE_CACHE=off` reads and writes no file. The last few files are kept.
"""

from __future__ import annotations

import gzip
import hashlib
import os
import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path

from aeroscene.files import cache_folder, open_regular, replacing
from aeroscene.layouts.neutral_format import read_neutral
from aeroscene.layouts.text_file import text_lines
from aeroscene.scene import Scene
from aeroscene.scene.io import scene_from_json, scene_to_json

MOST_KEPT = 8
"""Number of files whose scenes are kept; those that were not used for longest go first."""
_MAGIC = b"aeroscene mapped layouts 1\n"
_DIGEST_BYTES = 16
_PIECE_BYTES = 1 << 20
_END = b"\0"
"""End of a scene; JSON texts do not contain it."""
_SOURCES = ("scene", "solids", "areas", "layouts")
"""Packages on which mapping depends."""
_DAMAGED = (OSError, EOFError, zlib.error, ValueError)


def mapped_scenes(path: Path, on_scene: Callable[[], None] = lambda: None) -> list[Scene]:
    """Map each layout of a file to a scene to fly in, in the order of the lines.

    Args:
        path: File of neutral layouts.
        on_scene: Called after each scene, for example to show progress.

    Raises:
        LayoutError: If a line breaks a rule; it names file, line, scene, object and field.
    """
    kept = _kept_file(path)
    if kept is not None:
        try:
            scenes = _decode(kept.read_bytes())
            # The time of modification serves as time of last use.
            os.utime(kept)
        except _DAMAGED:
            pass
        else:
            for _ in scenes:
                on_scene()
            return scenes
    scenes = _mapped(path, on_scene)
    if kept is not None:
        _keep(kept, scenes)
    return scenes


def count_layouts(path: Path) -> int:
    """Number of layouts in a file of lines, readable or not.

    Raises:
        LayoutError: If the file cannot be read.
    """
    return sum(1 for _ in text_lines(path))


def _mapped(path: Path, on_scene: Callable[[], None]) -> list[Scene]:
    from aeroscene.layouts.flyable import make_flyable

    scenes: list[Scene] = []
    for layout in read_neutral(path):
        scenes.append(make_flyable(layout)[0])
        on_scene()
    return scenes


def _kept_file(path: Path) -> Path | None:
    """Path of the kept scenes of a file; None if none are kept, or it cannot be read."""
    folder = cache_folder("layouts")
    if folder is None:
        return None
    digest = hashlib.blake2b(_code(), digest_size=_DIGEST_BYTES)
    try:
        with open_regular(path) as file:
            while piece := file.read(_PIECE_BYTES):
                digest.update(piece)
    except OSError:
        return None  # the reader of the file reports why
    return folder / f"{digest.hexdigest()}.scenes"


@cache
def _code() -> bytes:
    """Hash of the code on which a mapped scene depends."""
    package = Path(__file__).parents[1]
    digest = hashlib.blake2b(_MAGIC, digest_size=_DIGEST_BYTES)
    for folder in _SOURCES:
        for path in sorted((package / folder).rglob("*.py")):
            digest.update(path.relative_to(package).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.digest()


def _encode(scenes: list[Scene]) -> bytes:
    text = b"".join(scene_to_json(scene) + _END for scene in scenes)
    # Without the time, so that equal scenes give equal files.
    body = gzip.compress(text, 6, mtime=0)
    return _MAGIC + hashlib.blake2b(body, digest_size=_DIGEST_BYTES).digest() + body


def _decode(data: bytes) -> list[Scene]:
    """Decode the scenes that `_encode` wrote.

    Raises:
        ValueError: If the data is not of this version.
    """
    head = len(_MAGIC) + _DIGEST_BYTES
    body = data[head:]
    # The digest finds a file that was cut short or changed.
    if data[:head] != _MAGIC + hashlib.blake2b(body, digest_size=_DIGEST_BYTES).digest():
        raise ValueError("not mapped layouts of this version; valid: what was written here")
    return [scene_from_json(text) for text in gzip.decompress(body).split(_END)[:-1]]


def _keep(path: Path, scenes: list[Scene]) -> None:
    """Write a file and remove those beyond the limit that were not used for longest.

    A folder that cannot be written to is no error. Other processes may do the same at the same
    time.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as file:
            file.write(_encode(scenes))
        files = sorted(path.parent.iterdir(), key=lambda one: one.stat().st_mtime, reverse=True)
        for one in files[MOST_KEPT:]:
            one.unlink(missing_ok=True)
    except OSError:
        return
