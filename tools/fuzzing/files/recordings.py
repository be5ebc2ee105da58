"""Hostile recordings: files that no flight has made."""

from __future__ import annotations

import json
import tempfile
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import rerun as rr
from rerun.error_utils import RerunWarning

from fuzzing.files.case import HERE, Case
from scenarios.recording import layout

_COMMANDS: Mapping[str, tuple[str, ...]] = {
    "summary": ("replay", f"{HERE}/r.rrd", "--summary"),
    "pictures": ("replay", f"{HERE}/r.rrd", "--pictures", f"{HERE}/out"),
    "csv": ("export-trial", f"{HERE}/r.rrd", "--to", "csv", "--out", f"{HERE}/out"),
}
_RUN: dict[str, Any] = {
    "scene": "field",
    "vehicle": "iris",
    "seed": 1,
    "config": "{}",
    "limits": "{}",
    "airframe": "{}",
}
_RUNS: tuple[tuple[str, dict[str, Any], dict[str, Any]], ...] = (
    ("control", {"scene": "\x1b[2J", "vehicle": "\x1b]0;x\x07"}, {"figures": '{"a\x1b[2J": 1}'}),
    ("figures-nested", {}, {"figures": "[" * 100_000}),
    ("figures-control", {}, {"figures": json.dumps({"reason": "\x1b[2J", "\x1b[31m": 1})}),
    ("figures-of-others", {}, {"figures": json.dumps({"contacts": [{"a": 1}]})}),
    ("config-nested", {"config": "[" * 100_000}, {}),
    ("config-damaged", {"config": "{", "limits": "nan"}, {}),
    ("kinds", {"scene": 7, "seed": "x", "config": 1.5}, {"figures": 7}),
    ("vehicle-path", {"vehicle": "/etc/passwd.toml"}, {}),
)


def recording_cases() -> Iterator[Case]:
    """Cases of recordings: files that are none, then recordings with hostile properties."""
    flight = _recording(_RUN, {"figures": "{}"})
    for name, content in (
        ("empty", b""),
        ("zeros", bytes(200_000)),
        ("text", b"{}" * 1000),
        ("magic-alone", flight[:16]),
        ("cut-short", flight[: len(flight) // 2]),
        ("damaged", flight[:200] + bytes(100) + flight[300:]),
        # Lengths in the header become enormous.
        ("lengths", flight[:24] + b"\xff" * 64 + flight[88:]),
        ("twice", flight + flight),
    ):
        for way in ("summary", "csv"):
            yield _case(f"{name}-{way}", content, way)
    for name, run, verdict in _RUNS:
        for way in _COMMANDS:
            yield _case(f"{name}-{way}", _recording(_RUN | run, verdict), way)


def _case(name: str, content: bytes, way: str) -> Case:
    return Case(kind="recording", name=name, files={"r.rrd": content}, command=_COMMANDS[way])


def _recording(run: Mapping[str, Any], verdict: Mapping[str, Any]) -> bytes:
    stream = rr.RecordingStream(layout.APPLICATION_ID)
    with tempfile.TemporaryDirectory(prefix="aeroscene-") as folder, warnings.catch_warnings():
        # rerun says that a number is no text, which is what the recording is for.
        warnings.simplefilter("ignore", RerunWarning)
        path = Path(folder) / "r.rrd"
        stream.set_sinks(rr.FileSink(path))
        stream.send_property(layout.RUN_PROPERTY, rr.AnyValues(**run))
        if verdict:
            stream.send_property(layout.VERDICT_PROPERTY, rr.AnyValues(**verdict))
        stream.set_time(layout.TIMELINE, duration=1.0)
        # A path of an entity that leaves its folder, if a name of a file is made of it.
        stream.log(f"{layout.VEHICLE}/../\x1b[2J", rr.Scalars(1.0))
        stream.flush()
        stream.disconnect()
        return path.read_bytes()
