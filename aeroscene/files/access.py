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

_PIECE_BYTES = 64 * 1024
_GZIP_MAGIC = b"\x1f\x8b"


class UnpackError(ValueError):
    """A file that is no file, too large, or damaged gzip; the message says which."""


def read_bounded(path: Path, most_bytes: int) -> bytes:
    """The content of a file, unpacked where it is gzip, whatever its name.

    Args:
        path: The file.
        most_bytes: Most that it may hold, unpacked.

    Raises:
        OSError: If it cannot be read; pipes and devices, which may never end, count as such.
        UnpackError: If it holds more than that, or its gzip is damaged or cut short.
    """
    content = io.BytesIO()
    content.writelines(pieces(path, most_bytes))
    return content.getvalue()


def pieces(path: Path, most_bytes: int) -> Iterator[bytes]:
    """The content of a file piece by piece; arguments and errors are those of `read_bounded`."""
    with open_regular(path) as packed:
        is_gzip = packed.peek(len(_GZIP_MAGIC)).startswith(_GZIP_MAGIC)
        file = gzip.GzipFile(fileobj=packed) if is_gzip else packed
        n_bytes = 0
        try:
            while piece := file.read(_PIECE_BYTES):
                n_bytes += len(piece)
                if n_bytes > most_bytes:
                    raise UnpackError(f"holds more than {_size(most_bytes)}; valid: at most that")
                yield piece
        except (EOFError, zlib.error, gzip.BadGzipFile) as error:
            raise UnpackError(
                f"gzip is damaged or cut short ({error}); valid: a whole gzip file"
            ) from None


def open_regular(path: Path) -> io.BufferedReader:
    """Open a file to read that ends: no folder, pipe or device.

    Raises:
        OSError: If it is another kind of file, or cannot be read.
    """
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(status.st_mode):
        raise OSError(errno.EINVAL, "no regular file", str(path))
    return path.open("rb")


def _size(n_bytes: int) -> str:
    return f"{n_bytes >> 20} MiB" if n_bytes >> 20 else f"{n_bytes >> 10} KiB"


@contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """A temporary neighbour to write to; it takes the file's place when nothing went wrong.

    Raises:
        OSError: If it cannot be written; what was there before is untouched.
    """
    try:
        descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        error.filename = str(path)  # Not the neighbour, of which nobody knows.
        raise
    temporary = Path(name)
    try:
        with os.fdopen(descriptor, "wb") as file:
            yield file
        temporary.chmod(0o644)
        temporary.replace(path)
    except BaseException as error:
        temporary.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.errno and error.filename is None:
            error.filename = str(path)  # A write to a full disk does not name it.
        raise


def cache_folder(name: str) -> Path | None:
    """A folder in the user's cache, or in `AEROSCENE_CACHE_DIR`; it may not be there yet.

    Args:
        name: What is kept there.

    Returns:
        The folder. None if `AEROSCENE_CACHE=off` says that no file is read or written, or if the
        user has no home folder.
    """
    from platformdirs import user_cache_dir

    if os.environ.get("AEROSCENE_CACHE", "").lower() == "off":
        return None
    if named := os.environ.get("AEROSCENE_CACHE_DIR"):
        return Path(named).absolute() / name
    try:
        root = Path(user_cache_dir("aeroscene"))
    except RuntimeError:
        return None
    return root / name if root.is_absolute() else None
