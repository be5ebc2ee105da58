"""The file that rerun writes for us: checked, waited for, and given up if the disk is full.

rerun writes in a thread of its own. That thread ends with the first fault, and now and then a
message is left in its queue. Every later flush without a time limit then waits for ever, also the
one that the interpreter makes at its end. This module therefore checks the path beforehand, flushes
with a time limit, and abandons a stream whose writer has failed.
"""

from __future__ import annotations

import atexit
import ctypes
import errno
from pathlib import Path
from shutil import disk_usage

import rerun as rr

# A process that is killed while it writes a chunk leaves a file that needs mending. Small chunks
# make that rare. One camera image is about this large.
CHUNK_BYTES = 64 * 1024
_CLOSING_TIMEOUT_S = 30.0
_LEAST_BYTES = 1 << 20
"""Room for the scene, which is written first; the open field takes 0.6 MB."""
_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


class RecordingError(OSError):
    """The recording cannot be written to the given path or port."""


def require_room(path: Path) -> None:
    """Refuse a path that no recording can be written to, because rerun would only log the fault.

    Args:
        path: File of the recording. Its folder is made, and a file that is there is emptied.

    Raises:
        RecordingError: If it cannot be written, or there is no room for a scene.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # Writing is the only sure test, because free space says nothing of a quota.
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
    """Wait until everything is in the file.

    Args:
        stream: Recording.
        path: Its file; None for a recording that only live viewers watch.

    Returns:
        None if everything was written, else the reason.
    """
    try:
        stream.flush(timeout_sec=_CLOSING_TIMEOUT_S)
    except (RuntimeError, TimeoutError) as error:
        return _reason(error, path)
    return None


def close_output(stream: rr.RecordingStream, fault: str | None) -> None:
    """Close the file, or abandon the stream if its writer has failed.

    Args:
        stream: Recording; it must not be used afterwards.
        fault: Result of `write_out`.
    """
    if fault is None:
        stream.disconnect()
    else:
        _abandon(stream)


def _reason(error: Exception, path: Path | None) -> str:
    """Return why rerun could not write."""
    # rerun names a full disk in its log alone, and its error is a mere timeout.
    is_full = path is not None and disk_usage(path.parent).free < CHUNK_BYTES
    return "no space left on device" if is_full else str(error)


def _abandon(stream: rr.RecordingStream) -> None:
    """Never touch a stream again, nor let the interpreter do so, because both would flush it."""
    # One reference too many keeps the destructors from running, and so from flushing.
    for each in (stream, stream.inner):
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(each))
    atexit.unregister(rr.rerun_shutdown)
