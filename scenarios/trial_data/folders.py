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
    """A temporary neighbour to fill, which takes its name when nothing went wrong.

    Raises:
        TrialDataError: If something of that name is there.
        OSError: If it cannot be written; nothing is left.
    """
    if out.exists():
        raise TrialDataError(f"out {str(out)!r} is there already; valid: a name that is free")
    out.parent.mkdir(parents=True, exist_ok=True)
    parent = Path(tempfile.mkdtemp(dir=out.parent, prefix=f".{out.name}."))
    try:
        folder = parent / out.name
        folder.mkdir()
        yield folder
        folder.rename(out)
    finally:
        shutil.rmtree(parent, ignore_errors=True)
