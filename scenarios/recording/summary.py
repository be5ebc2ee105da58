"""Summary of a recording, read through rerun's own reader, also if its run was killed.

A recording may come from anybody, and from a run that ended anyhow. Reading therefore mends a torn
file in a copy, bounds the size of embedded JSON, and makes control characters visible before a text
reaches a terminal.
"""

from __future__ import annotations

import json
import subprocess
import tempfile
import warnings
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rerun.chunk import Chunk, RrdReader

from aeroscene.files.bounds import excess
from aeroscene.files.visible import visible
from scenarios.recording import layout
from scenarios.recording.program import quiet_environment, rerun_program

_MENDING_TIMEOUT_S = 300.0
PROPERTIES = "/__properties/"
"""Prefix of the name of a property in an entity's path."""


class UnreadableRecordingError(ValueError):
    """A file is missing or no recording; the message names it."""


@dataclass(frozen=True, kw_only=True)
class RecordingSummary:
    """Summary of a recording's content."""

    recording: str
    """Path of the file."""
    is_complete: bool
    """False if the run ended without closing the file, which holds everything up to then."""
    size_bytes: int
    scene: str | None
    vehicle: str | None
    seed: int | None
    config: dict[str, Any] | None
    """The resolved configuration of the run."""
    limits: dict[str, float] | None
    """Thresholds by which the run was judged."""
    verdict: dict[str, Any] | None
    """Figures of the run; None if it never got one."""
    sim_seconds: float
    """Latest simulated time in the recording."""
    entities: dict[str, int]
    """Number of rows of each entity that changes in time."""
    static_entities: int
    """Number of entities that never change: scene, models, legends."""

    def to_json(self) -> dict[str, Any]:
        """Return the summary as plain data."""
        return asdict(self)


@contextmanager
def readable(path: Path) -> Iterator[Path]:
    """Yield a file that rerun can read: the recording itself, or a mended copy of a torn one.

    A run that was killed in the middle of a write leaves a file whose last piece is cut off.
    rerun's reader refuses such a file as a whole. rerun's own tool keeps everything before the cut.

    Args:
        path: File of a recording; it is never changed.

    Yields:
        The path to read, which is valid inside the context only.

    Raises:
        UnreadableRecordingError: If there is no recording in the file.
    """
    if not path.is_file():
        raise UnreadableRecordingError(
            f"recording {str(path)!r} does not exist; valid: an .rrd file"
        )
    if _is_readable(path):
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="aeroscene-") as folder:
        copy = Path(folder) / path.name
        _mend(path, copy)
        yield copy


def summarise(path: Path) -> RecordingSummary:
    """Read a whole recording, and return its summary.

    Args:
        path: File of a recording, also of a run that still goes on.

    Raises:
        UnreadableRecordingError: If it is missing or no recording.
    """
    rows: Counter[str] = Counter()
    static: set[str] = set()
    end_ns = 0
    run: dict[str, Any] = {}
    verdict: dict[str, Any] = {}
    with readable(path) as source:
        for chunk in chunks(source):
            if chunk.entity_path == PROPERTIES + layout.RUN_PROPERTY:
                run = first_row(chunk)
            elif chunk.entity_path == PROPERTIES + layout.VERDICT_PROPERTY:
                verdict = first_row(chunk)
            elif chunk.is_static:
                static.add(chunk.entity_path)
            elif layout.TIMELINE in chunk.timeline_names:
                rows[chunk.entity_path] += chunk.num_rows
                end_ns = max(end_ns, _latest_ns(chunk))
        # A mended copy has a footer, but the recording itself had none.
        is_complete = source == path and _has_footer(path)
    return RecordingSummary(
        recording=str(path),
        is_complete=is_complete,
        size_bytes=path.stat().st_size,
        scene=_tame(run.get("scene")),
        vehicle=_tame(run.get("vehicle")),
        seed=run.get("seed"),
        config=_tame(facts_of(run, "config", path)) if "config" in run else None,
        limits=_tame(facts_of(run, "limits", path)) if "limits" in run else None,
        verdict=_tame(facts_of(verdict, "figures", path)) if verdict else None,
        sim_seconds=round(end_ns * 1e-9, 6),
        entities={visible(name): count for name, count in sorted(rows.items())},
        static_entities=len(static),
    )


def facts_of(run: Mapping[str, Any], name: str, path: Path) -> dict[str, Any]:
    """Return the facts that a property of a recording holds as JSON.

    Args:
        run: Values of the property, by name.
        name: Name of the value, such as "config".
        path: File of the recording, for the error.

    Returns:
        The facts; empty if the value is missing.

    Raises:
        UnreadableRecordingError: If they are damaged.
    """
    text = run.get(name, "{}")
    # `excess` refuses depths and sizes that would exhaust the parser.
    try:
        found = None if excess(str(text).encode()) else json.loads(text)
    except (TypeError, ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise UnreadableRecordingError(
            f"recording {str(path)!r} holds a damaged {name}; valid: one that was written whole"
        )
    return found


def _tame(value: Any) -> Any:
    """Return facts whose names and texts have no control characters that a terminal obeys."""
    if isinstance(value, dict):
        return {visible(name): _tame(each) for name, each in value.items()}
    if isinstance(value, list):
        return [_tame(each) for each in value]
    return visible(value) if isinstance(value, str) else value


def chunks(path: Path) -> Iterator[Chunk]:
    """Yield a recording chunk by chunk, which bounds the memory.

    Args:
        path: A file that rerun can read; see `readable`.
    """
    reader, _ = _open(path)
    yield from reader.stream()


def _open(path: Path) -> tuple[RrdReader, bool]:
    """Return a reader, and whether the file was closed properly, which it only warns about."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        reader = RrdReader(path)
    return reader, not any("footer" in str(warning.message) for warning in caught)


def _has_footer(path: Path) -> bool:
    return _open(path)[1]


def _is_readable(path: Path) -> bool:
    try:
        next(iter(chunks(path)), None)
    except (RuntimeError, ValueError):
        return False
    return True


def _mend(path: Path, copy: Path) -> None:
    # `optimize` rewrites the file, and leaves out a last chunk that is cut off.
    result = subprocess.run(  # noqa: S603 - arguments are ours
        [str(rerun_program()), "rrd", "optimize", str(path), "-o", str(copy)],
        capture_output=True,
        check=False,
        timeout=_MENDING_TIMEOUT_S,
        env=quiet_environment(),
    )
    if result.returncode != 0 or not copy.is_file() or not _is_readable(copy):
        raise UnreadableRecordingError(
            f"recording {str(path)!r} is no rerun recording; valid: an .rrd file"
        )


def _latest_ns(chunk: Chunk) -> int:
    times = chunk.to_record_batch().column(layout.TIMELINE).cast("int64").to_numpy()
    return int(times.max()) if len(times) else 0


def first_row(chunk: Chunk) -> dict[str, Any]:
    """Return the components of a property by name.

    rerun keeps each value in a list of one element, which is unpacked here.

    Args:
        chunk: Chunk of the property's entity.

    Returns:
        Values by component; a component with an empty list is absent.
    """
    columns = chunk.to_record_batch().to_pydict()
    first = {name: values[0] for name, values in columns.items()}
    return {name: value[0] for name, value in first.items() if isinstance(value, list) and value}
