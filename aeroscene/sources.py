"""Where scenes come from: a number of the corpus or a file, remembered on disk."""

from __future__ import annotations

import hashlib
import os
import re
from functools import cache
from pathlib import Path

from aeroscene.corpus import CORPUS_SIZE
from aeroscene.scene import Scene, SceneError
from aeroscene.scene_io import read_scene, write_scene


class UnknownSceneError(SceneError):
    """A scene that nobody knows by that name."""


def open_scene(spec: str) -> Scene:
    """The scene that a user names.

    Args:
        spec: A number from 0 to 1015 for a corpus scene, or the path of a `.json` file.

    Raises:
        SceneError: If there is no such scene or the file is not valid; one line.
    """
    if spec.endswith(".json"):
        return read_scene(spec)
    # ASCII digits only: int() would also take signs, blanks and other scripts.
    if not re.fullmatch("[0-9]{1,9}", spec) or int(spec) >= CORPUS_SIZE:
        raise UnknownSceneError(
            f"scene {spec!r} is unknown, valid: a number from 0 to {CORPUS_SIZE - 1} "
            "or the path of a .json file"
        )
    return _open_corpus_scene(int(spec))


def _open_corpus_scene(index: int) -> Scene:
    path = _cache_folder() / f"corpus-{index:04d}.json"
    try:
        return read_scene(path)
    except SceneError:
        pass
    from aeroscene.curation import curate_scene  # noqa: PLC0415 - heavy, not needed when cached

    scene = curate_scene(index)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_scene(scene, path)
    except OSError:
        pass  # A cache that cannot be written costs time, not the scene.
    return scene


@cache
def _cache_folder() -> Path:
    """Folder for scenes of exactly this code; another version of it has another folder."""
    from platformdirs import user_cache_dir  # noqa: PLC0415 - only where the cache is used

    root = os.environ.get("AEROSCENE_CACHE_DIR") or user_cache_dir("aeroscene")
    return Path(root) / "scenes" / _source_digest()


@cache
def _source_digest() -> str:
    digest = hashlib.sha256()
    package = Path(__file__).parent
    for path in sorted(package.rglob("*.py")):
        digest.update(path.relative_to(package).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
