"""List of the recordings in a folder, without opening them.

Each recording has its verdict in a small JSON file beside it. Reading that file is far cheaper than
reading a recording of many MB.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import msgspec

from aeroscene.files import UnpackError, read_bounded
from aeroscene.files.bounds import MOST_JSON_BYTES


@dataclass(frozen=True, kw_only=True)
class Listed:
    """A recording by its file, and by the summary beside it if there is one."""

    recording: str
    """Path of the file."""
    size_bytes: int
    scene: str | None = None
    vehicle: str | None = None
    seed: int | None = None
    sim_seconds: float | None = None
    success: bool | None = None
    code: str | None = None
    reason: str | None = None

    def to_json(self) -> dict[str, Any]:
        """Return the recording as plain data."""
        return asdict(self)


class _Result(msgspec.Struct):
    scene: str
    vehicle: str
    seed: int
    sim_seconds: float
    success: bool | None
    code: str
    reason: str


class _Summary(msgspec.Struct):
    result: _Result


def recordings_in(folder: Path) -> list[Listed]:
    """Return all `.rrd` files of a folder and of the folders in it, sorted by path.

    A recording without a readable summary beside it is listed by its name and size alone.

    Args:
        folder: Folder to look through.

    Raises:
        OSError: If the folder cannot be read.
    """
    return [_listed(path) for path in sorted(folder.rglob("*.rrd")) if path.is_file()]


def _listed(path: Path) -> Listed:
    try:
        # A recording of several vehicles has the first one's verdict here.
        summary = msgspec.json.decode(
            read_bounded(path.with_suffix(".json"), MOST_JSON_BYTES), type=_Summary, strict=True
        )
    except (OSError, UnpackError, msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return Listed(recording=str(path), size_bytes=path.stat().st_size)
    return Listed(
        recording=str(path),
        size_bytes=path.stat().st_size,
        **msgspec.structs.asdict(summary.result),
    )
