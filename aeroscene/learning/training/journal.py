"""`log.jsonl`: the log of a training, a line every few seconds; it survives every stop.

One JSON object a line: a line that a crash has cut short costs that line alone.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from aeroscene.files import replacing

LOG = "log.jsonl"


def append_line(folder: Path, record: Mapping[str, Any]) -> None:
    """Append a record to the log.

    Raises:
        OSError: If it cannot be written.
    """
    # Opened for each line, so that every line is on disk when a crash comes.
    with (folder / LOG).open("a", encoding="utf-8") as file:
        file.write(json.dumps(record) + "\n")


def read_log(folder: Path) -> Iterator[dict[str, Any]]:
    """Yield the records of a training's log; a line that was cut short is left out.

    A folder without a log has no records.
    """
    try:
        lines = (folder / LOG).read_text(encoding="utf-8").splitlines()
    except OSError:
        return
    for line in lines:
        try:
            record = json.loads(line)
        # A crash may have cut the last line.
        except json.JSONDecodeError:
            continue
        if isinstance(record, dict):
            yield record


def forget_after(folder: Path, stage: str, step: int) -> None:
    """Remove lines of a stage beyond a step, because the training continues from that step.

    Raises:
        OSError: If the log cannot be written.
    """
    kept = [
        record
        for record in read_log(folder)
        if record.get("stage") != stage or record.get("step", 0) <= step
    ]
    text = "".join(json.dumps(record) + "\n" for record in kept)
    # Whole or not at all: a stop here must not lose the log.
    with replacing(folder / LOG) as file:
        file.write(text.encode())


def least_held_out_at(folder: Path) -> float | None:
    """Return the share of a training at which its held-out loss was least; None without any.

    If there are several parts, the part with the greatest share counts: 1 means that one still
    improved.
    """
    last: dict[str, int] = {}
    least: dict[str, int] = {}
    for record in read_log(folder):
        if record.get("held_out") is not None:
            last[record["stage"]] = record["step"]
            if record["is_best"]:
                least[record["stage"]] = record["step"]
    return max((least[stage] / last[stage] for stage in least), default=None)


def held_out_losses(folder: Path) -> dict[str, list[tuple[float, float]]]:
    """Return CPU seconds since the stage began, and held-out loss, of each measurement, by stage.

    Measurements have no time of their own; they take that of the step before them.
    """
    looks: dict[str, list[tuple[float, float]]] = {}
    now_s: dict[str, float] = {}
    for record in read_log(folder):
        stage = record.get("stage", "")
        if record.get("seconds") is not None:
            now_s[stage] = record["seconds"]
        elif record.get("held_out") is not None:
            looks.setdefault(stage, []).append((now_s.get(stage, 0.0), record["held_out"]))
    return looks
