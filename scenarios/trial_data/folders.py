"""Folders that are written whole or not at all."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from scenarios.trial_data.reading import TrialDataError


@contextmanager
def building(out: Path) -> Iterator[Path]:
    """Yield a temporary neighbour to fill, which takes the wanted name if nothing goes wrong.

    Args:
        out: Wanted folder.

    Raises:
        TrialDataError: If something of that name is there.
        OSError: If it cannot be written; nothing is left.
    """
    if out.exists():
        raise TrialDataError(f"out {str(out)!r} is there already; valid: a name that is free")
    out.parent.mkdir(parents=True, exist_ok=True)
    # In the same folder, because a rename is atomic only within a file system.
    parent = Path(tempfile.mkdtemp(dir=out.parent, prefix=f".{out.name}."))
    try:
        folder = parent / out.name
        folder.mkdir()
        yield folder
        folder.rename(out)
    finally:
        shutil.rmtree(parent, ignore_errors=True)
