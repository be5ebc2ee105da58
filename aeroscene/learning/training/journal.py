"""`log.jsonl`: what a training did, a line each few seconds; it outlives every stop."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from aeroscene.files import replacing

LOG = "log.jsonl"


def append_line(folder: Path, record: Mapping[str, Any]) -> None:
    """Add a record to the log.

    Raises:
        OSError: If it cannot be written.
    """
    with (folder / LOG).open("a", encoding="utf-8") as file:
        file.write(json.dumps(record) + "\n")


def read_log(folder: Path) -> Iterator[dict[str, Any]]:
    """The records of a training's log; a last line that was cut short is left out."""
    try:
        lines = (folder / LOG).read_text(encoding="utf-8").splitlines()
    except OSError:
        return
    for line in lines:
        try:
            record = json.loads(line)
        except json.JSONDecodeError:
            continue
        if isinstance(record, dict):
            yield record


def forget_after(folder: Path, stage: str, step: int) -> None:
    """Take lines of a stage beyond a step out: the training goes on from that step.

    Raises:
        OSError: If the log cannot be written.
    """
    kept = [
        record
        for record in read_log(folder)
        if record.get("stage") != stage or record.get("step", 0) <= step
    ]
    text = "".join(json.dumps(record) + "\n" for record in kept)
    with replacing(folder / LOG) as file:
        file.write(text.encode())
