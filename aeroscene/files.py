"""Files that are written whole or not at all, and the folder of what took long to compute."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO


@contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """A temporary neighbour to write to; it takes the file's place when nothing went wrong.

    Raises:
        OSError: If it cannot be written; what was there before is untouched.
    """
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    temporary = Path(name)
    try:
        with os.fdopen(descriptor, "wb") as file:
            yield file
        temporary.chmod(0o644)
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def cache_folder(name: str) -> Path | None:
    """A folder in the user's cache, or in `AEROSCENE_CACHE_DIR`; it may not be there yet.

    Args:
        name: What is kept there.

    Returns:
        The folder, None where `AEROSCENE_CACHE=off` says that no file is read or written.
    """
    from platformdirs import user_cache_dir  # noqa: PLC0415 - only where the cache is used

    if os.environ.get("AEROSCENE_CACHE", "").lower() == "off":
        return None
    return Path(os.environ.get("AEROSCENE_CACHE_DIR") or user_cache_dir("aeroscene")) / name
