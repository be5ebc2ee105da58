"""Which code trained a model."""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.metadata import version
from pathlib import Path

_SOURCES = ("diffusion", "model", "paper", "program", "tokens", "training", "writer")


@cache
def code_version() -> str:
    """The package's version and a digest of the sources that decide what a training gives."""
    package = Path(__file__).parents[1]
    digest = hashlib.sha256()
    for folder in _SOURCES:
        for path in sorted((package / folder).rglob("*.py")):
            digest.update(path.relative_to(package).as_posix().encode())
            digest.update(path.read_bytes())
    return f"{version('aeroscene')}+{digest.hexdigest()[:12]}"
