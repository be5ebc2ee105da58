"""Judge recorded flights a second time, by the recordings alone, and compare the verdicts.

    python tools/judge_recordings.py runs/ours/recordings

Nothing of `scenarios/trials` is used: where the vehicle was, how far its hull was from each solid
that the recording draws, whether its soles ended in the area's polygon, upright, at rest, with
standing rotors. Movers are not looked at. The exit status is 1 where a verdict is contradicted.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro
from judging.judge import judge_recording
from judging.recording import read_recording
from rich.progress import track

from scenarios.cli.terminal import terminal


@dataclass(frozen=True, kw_only=True)
class JudgeCfg:
    """Judge recorded flights a second time."""

    paths: Annotated[tyro.conf.Positional[tuple[Path, ...]], tyro.conf.arg(metavar="PATH")]
    """Recordings, and folders of recordings."""
    json: bool = False
    """Print one JSON object: recordings, with all that was found."""


def judge(path: Path) -> dict[str, Any]:
    """Compare the verdict that a recording has with a second one.

    Args:
        path: Recording.

    Returns:
        Both verdicts on the flight, and the findings that the second follows from. The field
        `agreement` is "agree", "DISAGREE", or "too close" if the second judge cannot tell.

    Raises:
        ValueError: If the flight has no area.
    """
    flight = read_recording(path)
    opinion = judge_recording(flight)
    told, found = flight.verdict["success"], opinion.success
    agreement = "too close" if found is None else "agree" if found == told else "DISAGREE"
    return {
        "recording": str(path),
        "verdict": flight.verdict["code"],
        "success": told,
        "second_success": found,
        "agreement": agreement,
        "objections": opinion.objections,
        "least_distance_m": opinion.least_distance_m,
        "nearest": opinion.nearest,
        "findings": [asdict(finding) for finding in opinion.findings],
    }


def main(cfg: JudgeCfg) -> int:
    """Judge all recordings of the command line.

    Returns:
        Exit status: 1 if a verdict is contradicted.
    """
    paths = [
        each
        for path in cfg.paths
        for each in (sorted(path.glob("*.rrd")) if path.is_dir() else [path])
    ]
    console = terminal(stderr=cfg.json)
    rows = [judge(path) for path in track(paths, "judging", console=terminal(stderr=True))]
    if cfg.json:
        print(json.dumps({"recordings": rows}, indent=2))
    for row in rows:
        if row["agreement"] != "agree":
            console.print(
                f"{row['recording']}: {row['agreement']}; {row['verdict']}, "
                f"objections {row['objections']}",
                soft_wrap=True,
            )
    n = {word: sum(row["agreement"] == word for row in rows) for word in ("agree", "too close")}
    wrong = [row for row in rows if row["agreement"] == "DISAGREE"]
    false_successes = sum(row["success"] for row in wrong)
    console.print(
        f"{len(rows)} verdicts: {n['agree']} confirmed, {n['too close']} too close to tell, "
        f"{false_successes} false successes, {len(wrong) - false_successes} false failures",
        soft_wrap=True,
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(tyro.cli(JudgeCfg)))
