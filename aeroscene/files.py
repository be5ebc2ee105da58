"""Files that are read within bounds, files written whole or not at all, and the user's cache."""

from __future__ import annotations

import errno
import gzip
import io
import os
import stat
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

MAX_BYTES = 512 * 1024 * 1024
"""Most that a file may hold, unpacked; more is no scene and no layout but an accident."""
_PIECE_BYTES = 64 * 1024
_GZIP_MAGIC = b"\x1f\x8b"


class UnpackError(ValueError):
    """A file that is no file, too large, or damaged gzip; the message says which."""


def read_bounded(path: Path) -> bytes:
    """The content of a file, unpacked where it is gzip, whatever its name.

    Raises:
        OSError: If it cannot be read; pipes and devices, which may never end, count as such.
        UnpackError: If it holds more than `MAX_BYTES`, or its gzip is damaged or cut short.
    """
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(status.st_mode):
        raise OSError(errno.EINVAL, "no regular file", str(path))
    too_large = UnpackError(f"holds more than {MAX_BYTES >> 20} MiB, valid: at most that")
    if status.st_size > MAX_BYTES:
        raise too_large
    data = path.read_bytes()
    if not data.startswith(_GZIP_MAGIC):
        return data
    try:
        # Unpacked twice, and the first time only counted: what is too large takes no memory.
        if sum(map(len, _pieces(data))) > MAX_BYTES:
            raise too_large
        unpacked = io.BytesIO()
        unpacked.writelines(_pieces(data))
        return unpacked.getvalue()
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise UnpackError(
            f"gzip is damaged or cut short ({error}), valid: a whole gzip file"
        ) from None


def _pieces(packed: bytes) -> Iterator[bytes]:
    """What gzip holds, piece by piece, up to the first piece beyond `MAX_BYTES`."""
    n_bytes = 0
    with gzip.GzipFile(fileobj=io.BytesIO(packed)) as file:
        while n_bytes <= MAX_BYTES and (piece := file.read(_PIECE_BYTES)):
            n_bytes += len(piece)
            yield piece


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
        The folder. None if `AEROSCENE_CACHE=off` says that no file is read or written, or if the
        user has no home folder.
    """
    from platformdirs import user_cache_dir  # noqa: PLC0415 - only where the cache is used

    if os.environ.get("AEROSCENE_CACHE", "").lower() == "off":
        return None
    if named := os.environ.get("AEROSCENE_CACHE_DIR"):
        return Path(named).absolute() / name
    try:
        root = Path(user_cache_dir("aeroscene"))
    except RuntimeError:
        return None
    return root / name if root.is_absolute() else None
