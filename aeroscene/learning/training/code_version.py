"""The version of the code that trained a model."""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.metadata import version
from pathlib import Path

_NOT_TRAINING = ("baselines", "generation")


@cache
def code_version() -> str:
    """Return the package's version and a digest of the sources that a training depends on.

    The digest changes with every edit of these files, comments included.
    """
    package = Path(__file__).parents[1]
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        name = path.relative_to(package)
        if name.parts[0] not in _NOT_TRAINING:
            digest.update(name.as_posix().encode())
            digest.update(path.read_bytes())
    return f"{version('aeroscene')}+{digest.hexdigest()[:12]}"
