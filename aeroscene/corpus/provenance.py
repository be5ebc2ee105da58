"""Digest of the sources that decide what is in a scene.

A dataset records it for each scene, so that a build makes a scene again exactly if code that shapes
it has changed. A digest of sources errs on the safe side: a changed comment makes scenes anew, a
changed algorithm is never missed.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from functools import cache
from pathlib import Path

_NO_PART_OF_A_SCENE = (
    "areas/start.py",
    "corpus/dataset.py",
    "corpus/provenance.py",
    "corpus/scene_files.py",
    "corpus/shipped.py",
    "processes.py",
    "sources.py",
    "feasibility",
    "layouts",
    "learning",
    "metrics",
    "validation",
)
"""Files that read, measure or judge scenes. A missing entry here only makes scenes anew for
nothing.
"""


@cache
def curation_digest() -> str:
    """Digest of the sources of this very package."""
    return sources_digest(Path(__file__).parents[1])


def sources_digest(package: Path, without: Sequence[str] = _NO_PART_OF_A_SCENE) -> str:
    """Sixteen hexadecimal digits that change with every source, except those that are left out.

    Args:
        package: Folder of the package.
        without: Files and folders in it; by default all that curation does not need.
    """
    digest = hashlib.sha256()
    # Sorted, because folders list their files in no order that two machines share.
    for path in sorted(package.rglob("*.py")):
        name = path.relative_to(package)
        if not any(name.is_relative_to(part) for part in without):
            # The name too, so that a file that was moved changes the digest.
            digest.update(name.as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
