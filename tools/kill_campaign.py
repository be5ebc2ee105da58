"""Kills a campaign again and again, and compares what it leaves with one that was left alone.

    python tools/kill_campaign.py --kills 20 FOLDER -- --scenes 0:4 --trials 10 --pilot straight

What stands behind `--` are options of `aeroscene campaign`. FOLDER/whole is flown in one go, and
FOLDER/killed is ended by `kill -9` at random moments and gone on with. Exit status 0 if both have
the same trials and every column that is not a time is equal, to the bit of each flight's history.
"""

import argparse
import json
import random
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from scenarios.campaigns.store import read_results

# Columns in which no two runs agree.
TIMES = {"wall_seconds", "cpu_seconds", "trial_cpu_seconds", "real_time_factor"}


def command(folder: Path, options: list[str]) -> list[str]:
    """Command line of a campaign in a folder; the same one begins it and goes on with it."""
    return [sys.executable, "-m", "aeroscene", "campaign", "--out", str(folder), *options]


def rows_of(folder: Path) -> dict[str, dict[str, Any]]:
    """Rows of a campaign by trial, without times.

    Args:
        folder: Folder of the campaign.

    Raises:
        ValueError: If a trial is there twice.
    """
    rows = read_results(folder).to_pylist()
    by_trial = {row["trial_id"]: {k: v for k, v in row.items() if k not in TIMES} for row in rows}
    if len(by_trial) != len(rows):
        raise ValueError(f"{folder} holds {len(rows)} rows of {len(by_trial)} trials")
    return by_trial


def n_rows_of(folder: Path) -> int:
    """Number of rows of a campaign that may not have begun."""
    return len(rows_of(folder)) if (folder / "trials.jsonl").is_file() else 0


def main() -> int:
    """Fly a campaign whole, kill its twin and go on with it, and compare both.

    Returns:
        Exit status: 1 if a trial differs or is missing.

    Raises:
        SystemExit: If a kill lost rows that were there before.
    """
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--longest", type=float, default=5.0, help="s to a kill, from the start or a row"
    )
    parser.add_argument("options", nargs=argparse.REMAINDER, help="-- and those of a campaign")
    cfg = parser.parse_args()
    options = [word for word in cfg.options if word != "--"]
    whole, killed = cfg.folder / "whole", cfg.folder / "killed"
    subprocess.run(command(whole, options), check=True, stdout=subprocess.DEVNULL)  # noqa: S603
    draw, n_killed, before = random.Random(cfg.seed), 0, 0
    while n_killed < cfg.kills:
        campaign = subprocess.Popen(command(killed, options), stdout=subprocess.DEVNULL)  # noqa: S603
        # Half of the kills hit processes that start, half hit trials and the rows that they leave.
        is_early = draw.random() < 0.5
        while not is_early and campaign.poll() is None and n_rows_of(killed) <= before:
            time.sleep(0.05)
        time.sleep(draw.uniform(0.0, cfg.longest))
        # It has ended by itself before the kill.
        if campaign.poll() is not None:
            break
        # SIGKILL, so that nothing in the process can clean up.
        campaign.kill()
        campaign.wait()
        n_killed += 1
        n_rows = n_rows_of(killed)
        if n_rows < before:
            raise SystemExit(f"kill {n_killed} lost {before - n_rows} rows")
        before = n_rows
        sys.stderr.write(f"kill {n_killed}: {n_rows} rows\n")
    subprocess.run(command(killed, options), check=True, stdout=subprocess.DEVNULL)  # noqa: S603
    ours, theirs = rows_of(killed), rows_of(whole)
    names = ours.keys() | theirs.keys()
    differ = sorted(name for name in names if ours.get(name) != theirs.get(name))
    print(json.dumps({"kills": n_killed, "trials": len(theirs), "differ": differ}))
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
