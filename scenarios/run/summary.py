"""The JSON file beside a recording: configuration, limits and verdict of a run."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aeroscene.files import replacing
from scenarios.run.cfg import SitlCfg
from scenarios.trials.limits import LIMITS
from scenarios.trials.result import TrialResult, decisions

if TYPE_CHECKING:
    from scenarios.pilot import Pilot


def write_summary(
    recording: Path,
    cfg: SitlCfg,
    result: TrialResult,
    pilot: Pilot | None,
    mates: Sequence[TrialResult] = (),
) -> str | None:
    """Write the configuration and the end of a run, whole or not at all.

    Args:
        recording: File of the recording, whose name the summary takes.
        cfg: Configuration of the run.
        result: Verdict and figures.
        pilot: Our own pilot, in a demo: its decisions are included.
        mates: Verdict and figures of other vehicles in the same world.

    Returns:
        A line that says why there is no summary; None if there is one.
    """
    summary: dict[str, Any] = {
        "config": cfg.to_plain(),
        "limits": LIMITS.to_plain(),
        "result": result.to_plain(),
    }
    if mates:
        summary["mates"] = [mate.to_plain() for mate in mates]
    if pilot is not None:
        summary |= decisions(pilot)
    # Beside the recording, under its name.
    path = recording.with_suffix(".json")
    try:
        with replacing(path) as file:
            file.write(json.dumps(summary, indent=2).encode() + b"\n")
    except OSError as error:
        return f"summary {path} is not written: {error.strerror or error}"
    return None
