"""The file that rerun writes for us: opened, waited for, and given up where the disk is full.

rerun's writer ends with the first fault, and now and then a message is left in its queue. Every
later flush without a time limit then waits for ever.
"""

from __future__ import annotations

import atexit
import ctypes
import errno
from pathlib import Path
from shutil import disk_usage

import rerun as rr

# A process that is killed while it writes a chunk leaves a file that needs mending: small chunks
# make that rare. One camera image is about this large.
CHUNK_BYTES = 64 * 1024
_CLOSING_TIMEOUT_S = 30.0
_LEAST_BYTES = 1 << 20
"""Room for what is written first; the open field takes 0.6 MB."""
_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


class RecordingError(OSError):
    """The recording cannot be written to the given path or port."""


def require_room(path: Path) -> None:
    """Refuse a path that no recording can be written to, before rerun fails behind the scenes.

    Raises:
        RecordingError: If it cannot be written, or there is no room for a scene.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("wb") as file:
            file.write(bytes(_LEAST_BYTES))
            file.flush()
            file.truncate(0)
    except OSError as error:
        if error.errno in _FULL:
            path.unlink(missing_ok=True)
        raise RecordingError(
            f"recording {str(path)!r} cannot be written ({error.strerror}); "
            f"valid: a file in a folder you may write to, with {_LEAST_BYTES >> 20} MiB of room"
        ) from None


def write_out(stream: rr.RecordingStream, path: Path | None) -> str | None:
    """Wait until all is in the file; returns why it is not, None if it is."""
    try:
        stream.flush(timeout_sec=_CLOSING_TIMEOUT_S)
    except (RuntimeError, TimeoutError) as error:
        return _reason(error, path)
    return None


def close_output(stream: rr.RecordingStream, fault: str | None) -> None:
    """Close the file, unless its writer has ended by a fault."""
    if fault is None:
        stream.disconnect()
    else:
        _abandon(stream)


def _reason(error: Exception, path: Path | None) -> str:
    """Why rerun could not write, which it says in its log alone where a disk has filled up."""
    is_full = path is not None and disk_usage(path.parent).free < CHUNK_BYTES
    return "no space left on device" if is_full else str(error)


def _abandon(stream: rr.RecordingStream) -> None:
    """Never touch a stream again, nor let the interpreter do so: both would flush it."""
    for each in (stream, stream.inner):
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(each))
    atexit.unregister(rr.rerun_shutdown)
