"""Hostile folders of campaigns that somebody has shared.

A campaign names the pilot and the stack that fly it, so that whoever flies a trial again would run
a stranger's code. `judging` sees that by a file called "owned".
"""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from fuzzing.files.case import HERE, Case, changed
from scenarios.tasks.recipe import Recipe

_MANIFEST: dict[str, Any] = {
    "version": "0.1.0",
    "suite": {"recipe": asdict(Recipe()), "pilot": "demo", "program": None, "autopilot": None},
}
_ROW: dict[str, Any] = {
    "trial_id": "7/iris/0",
    "scene": "7",
    "vehicle": "iris",
    "trial": 0,
    "success": False,
    "code": "contact",
    "reason": "touched",
    "start": [0.0, 0.0, 0.0],
}
# A program that leaves a file, by whose name the judge sees that it ran.
_TOUCH = "sh -c 'touch {here}/owned'"
_CODE: tuple[tuple[str, dict[str, Any]], ...] = (
    ("program", {"pilot": "mavlink", "program": _TOUCH}),
    ("module", {"pilot": "owned:Pilot"}),
    ("module-of-python", {"pilot": "os:system"}),
    ("autopilot", {"autopilot": "px4", "autopilot_binary": "{here}/c/run"}),
)
_VALUES: tuple[tuple[str, str, Any], ...] = (
    ("pilot-list", "suite.pilot", ["demo"]),
    ("pilot-control", "suite.pilot", "\x1b[2J"),
    ("recipe-null", "suite.recipe", None),
    ("recipe-draws", "suite.recipe.draws", 10**9),
    ("recipe-unknown", "suite.recipe", {"\x1b[2J": 1}),
    ("suite-list", "suite", []),
    ("version-number", "version", 7),
)
_ROWS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("row-control", {"reason": "\x1b[2J\x1b]0;x\x07", "code": "\x1b[31mred"}),
    ("row-markup", {"reason": "[/bold] [red]", "code": "[/]"}),
    ("row-of-lists", {"scene": [1, 2], "trial": "x"}),
    ("row-id-list", {"trial_id": [1]}),
    ("row-id-path", {"trial_id": "../../../etc/passwd"}),
    ("row-scene-file", {"scene": "/etc/passwd", "flown_enu_m": [[0, 0, 0], [1, 1, 1]]}),
    ("row-scene-generated", {"scene": "gen:7", "flown_enu_m": [[0, 0, 0], [1, 1, 1]]}),
    ("row-nan", {"way_m": float("nan"), "touchdown_error_m": float("inf"), "energy_j": 1e300}),
    ("row-trial-huge", {"trial": 10**30}),
    ("row-html", {"reason": "<script>alert(1)</script>", "vehicle": "</td>"}),
)


def campaign_cases() -> Iterator[Case]:
    """Folders that name code, damaged manifests, journals and tables."""
    fly = ("fly", "--out", f"{HERE}/c", "--trial", "0", "--scene", "7")
    for name, suite in _CODE:
        manifest = {**_MANIFEST, "suite": {**_MANIFEST["suite"], **suite}}
        files = {
            "c/campaign.json": json.dumps(manifest).encode(),
            # Exits at once, so that an import shows by a fault of its own, too.
            "c/owned.py": b"raise SystemExit",
            "c/run": b"#!/bin/sh\ntouch {here}/owned\n",
        }
        yield Case(kind="campaign", name=f"names-a-{name}", files=files, command=fly)
    for name, way, value in _VALUES:
        files = {"c/campaign.json": changed(_MANIFEST, way, value)}
        yield Case(kind="campaign", name=name, files=files, command=fly)
    for name, content in (
        ("manifest-empty", b""),
        ("manifest-nested", b"[" * 200_000),
        ("manifest-large", b'{"a":"' + b"x" * (8 << 20) + b'"}'),
    ):
        yield _report(name, {"c/campaign.json": content, "c/trials.jsonl": b""})
        yield Case(
            kind="campaign", name=f"fly-{name}", files={"c/campaign.json": content}, command=fly
        )
    for name, more in _ROWS:
        line = json.dumps(_ROW | more).encode() + b"\n"
        yield _report(name, {"c/trials.jsonl": line})
    for name, content in _journals():
        yield _report(name, {"c/trials.jsonl": content})
    for name, content in _tables():
        yield _report(name, {"c/trials.jsonl": b"", "c/trials/00000.parquet": content})
    yield Case(
        kind="campaign",
        name="leaderboard-nested",
        files={**_folder(), "b.json": b"[" * 100_000},
        command=("report", f"{HERE}/c", "--leaderboard", f"{HERE}/b.json"),
    )
    yield Case(
        kind="campaign",
        name="compare-foreign",
        files={**_folder(), "d/trials.jsonl": b"", "d/trials/00000.parquet": _foreign()},
        command=("compare", f"{HERE}/c", f"{HERE}/d"),
    )


def _folder() -> dict[str, bytes]:
    return {
        "c/campaign.json": json.dumps(_MANIFEST).encode(),
        "c/trials.jsonl": json.dumps(_ROW).encode() + b"\n",
    }


def _report(name: str, files: dict[str, bytes]) -> Case:
    return Case(
        kind="campaign",
        name=name,
        files={**_folder(), **files},
        command=("report", f"{HERE}/c"),
    )


def _journals() -> Iterator[tuple[str, bytes]]:
    yield "journal-empty", b""
    yield "journal-binary", bytes(range(256)) * 1000
    yield "journal-nested", (b"[" * 50_000 + b"\n") * 20
    rows = (
        b'{"trial_id":"%d","scene":"7","vehicle":"iris","trial":%d}\n' % (i, i)
        for i in range(900_000)
    )
    yield "journal-many-rows", b"".join(rows)
    # One path of 24 MB in one row.
    yield "journal-long-row", b'{"trial_id":"1","flown_enu_m":[' + b"[0,0,0]," * 3_000_000 + b"]}\n"
    yield "journal-of-text", b'{"trial_id":"' + b"x" * (20 << 20) + b'"}\n'


def _tables() -> Iterator[tuple[str, bytes]]:
    yield "table-empty", b""
    yield "table-cut-short", _foreign()[:-40]
    yield "table-foreign", _foreign()
    yield "table-without-ids", _parquet({"trial_id": [None] * 3, "scene": ["7"] * 3})
    yield "table-of-other-kinds", _parquet({"trial_id": [1, 2], "success": ["yes", "no"]})
    yield "table-50-million-rows", _parquet({"trial_id": pa.nulls(50_000_000, pa.string())})
    one = pa.array(["x" * (1 << 20)])
    # A dictionary of one text, named 60,000 times: small in the file, 60 GB when it is unfolded.
    repeated = pa.DictionaryArray.from_arrays(np.zeros(60_000, np.int32), one)
    ids = pa.array([str(i) for i in range(60_000)])
    yield "table-60-GB-of-text", _parquet({"trial_id": ids, "reason": repeated})
    # Twenty million positions of zeros, which compress to almost nothing.
    zeros = pa.FixedSizeListArray.from_arrays(pa.array(np.zeros(60_000_000, np.float32)), 3)
    offsets = pa.array([0, 20_000_000], pa.int32())
    way = pa.ListArray.from_arrays(offsets, zeros)
    yield "table-long-way", _parquet({"trial_id": ["1"], "flown_enu_m": way})


def _foreign() -> bytes:
    return _parquet({"name": ["a", "b", "c"], "value": [1.0, 2.0, 3.0]})


def _parquet(columns: dict[str, Any]) -> bytes:
    file = io.BytesIO()
    pq.write_table(pa.table(columns), file, compression="zstd")
    return file.getvalue()
