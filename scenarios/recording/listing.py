"""Recordings of a folder, told apart without opening them."""

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
    """The file."""
    size_bytes: int
    scene: str | None = None
    vehicle: str | None = None
    seed: int | None = None
    sim_seconds: float | None = None
    success: bool | None = None
    code: str | None = None
    reason: str | None = None

    def to_json(self) -> dict[str, Any]:
        """The recording as plain data."""
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
    """All `.rrd` files of a folder and of the folders in it, by name.

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
