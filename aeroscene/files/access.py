"""Access to files: reading within bounds, writing whole or not at all, and the user's cache."""

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
    """A file that is no regular file, too large, or damaged gzip; the message says which."""


def read_bounded(path: Path, most_bytes: int) -> bytes:
    """Read the content of a file, unpacked if it is gzip, whatever its name.

    Args:
        path: File.
        most_bytes: Greatest size of the content, unpacked.

    Raises:
        OSError: If it cannot be read; pipes and devices, which may never end, count as such.
        UnpackError: If it holds more than that, or its gzip is damaged or cut short.
    """
    content = io.BytesIO()
    content.writelines(pieces(path, most_bytes))
    return content.getvalue()


def pieces(path: Path, most_bytes: int) -> Iterator[bytes]:
    """Read a file piece by piece; arguments and errors are those of `read_bounded`."""
    with open_regular(path) as packed:
        is_gzip = packed.peek(len(_GZIP_MAGIC)).startswith(_GZIP_MAGIC)
        file = gzip.GzipFile(fileobj=packed) if is_gzip else packed
        n_bytes = 0
        try:
            while piece := file.read(_PIECE_BYTES):
                n_bytes += len(piece)
                # Counted while unpacking: a small gzip file may unpack to terabytes.
                if n_bytes > most_bytes:
                    raise UnpackError(f"holds more than {_size(most_bytes)}; valid: at most that")
                yield piece
        except (EOFError, zlib.error, gzip.BadGzipFile) as error:
            raise UnpackError(
                f"gzip is damaged or cut short ({error}); valid: a whole gzip file"
            ) from None


def open_regular(path: Path) -> io.BufferedReader:
    """Open a file that ends, for reading: no folder, pipe or device.

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
    """Open a temporary neighbour for writing; it replaces the file if nothing goes wrong.

    A reader of the file, or a crash, therefore never sees a half-written one.

    Args:
        path: File to be replaced or created.

    Raises:
        OSError: If it cannot be written; the former file stays as it was.
    """
    try:
        descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        error.filename = str(path)  # not the neighbour, whose name the caller does not know
        raise
    temporary = Path(name)
    try:
        with os.fdopen(descriptor, "wb") as file:
            yield file
        # Temporary files are private to their owner; results should be readable like any other
        # file.
        temporary.chmod(0o644)
        # Renaming within one folder is atomic on POSIX systems.
        temporary.replace(path)
    except BaseException as error:
        temporary.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.errno and error.filename is None:
            error.filename = str(path)  # a write to a full disk does not name it
        raise


def cache_folder(name: str) -> Path | None:
    """Folder in the user's cache, or in `AEROSCENE_CACHE_DIR`; it may not exist yet.

    Args:
        name: Name of the folder, by its content.

    Returns:
        The folder. None if `AEROSCENE_CACHE=off` forbids to read or write files, or if the user has
        no home folder.
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
