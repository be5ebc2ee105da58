"""`aeroscene export-trial`: recorded flights in the formats of other programs."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from scenarios.campaigns.recordings import RECORDINGS
from scenarios.cli.command_line import EXIT_DONE, fail, print_json
from scenarios.cli.outputs import OutFile, OutFolder
from scenarios.cli.progress import progress_bar
from scenarios.cli.terminal import styled, terminal

if TYPE_CHECKING:
    from scenarios.trial_data.reading import RecordedTrial

_PROG = "aeroscene export-trial"


@dataclass(frozen=True, kw_only=True)
class ExportTrialCfg:
    """Write recorded flights as a ROS 2 bag, a ULog, CSV tables or a dataset for learning.

    mcap is a folder that rosbag2 and Foxglove open (pip install 'aeroscene[ros]'); ulog a file for
    PlotJuggler and PX4's tools; csv a folder of tables and images; dataset a folder of Parquet
    tables and image shards that takes many recordings, and goes on where it was stopped.
    """

    recordings: tyro.conf.Positional[
        Annotated[tuple[Path, ...], tyro.conf.arg(metavar="RRD...", help_behavior_hint="")]
    ]
    """The .rrd files; for dataset also folders of campaigns."""
    to: Literal["mcap", "ulog", "csv", "dataset"]
    """Format, see docs/trial_data.md."""
    out: Path
    """File (ulog) or folder to write."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: out, format, trials, there (already), skipped, and left_out, the parts
    of the recordings that the format cannot hold."""


def run(cfg: ExportTrialCfg) -> int:
    """Write the recordings in the format that is asked for, and print what was left out.

    Returns:
        0. Recordings that cannot be exported end the process with status 2 and one line, unless one
        of several goes into a dataset: that one is reported and skipped.
    """
    # Imported here because rerun takes time that `--help` should not spend.
    from scenarios.recording.summary import UnreadableRecordingError
    from scenarios.trial_data.reading import TrialDataError

    if not cfg.recordings:
        fail(_PROG, "no recording is named; valid: .rrd files, for dataset also folders")
    _require_place(cfg)
    try:
        facts = _add_all(cfg) if cfg.to == "dataset" else _write_one(cfg)
    except (UnreadableRecordingError, TrialDataError) as error:
        fail(_PROG, str(error))
    if cfg.json:
        print_json({"out": str(cfg.out), "format": cfg.to, **facts})
    else:
        there = f", {facts['there']} were there already" if facts["there"] else ""
        said = styled((cfg.out, "bold"), f"  {facts['trials']} trials{there}")
        terminal().print(said, soft_wrap=True)
        if facts["left_out"]:
            lacking = ", ".join(facts["left_out"])
            terminal().print(f"Left out of {cfg.to}: {lacking}", soft_wrap=True)
    return EXIT_DONE


def _write_one(cfg: ExportTrialCfg) -> dict[str, Any]:
    from scenarios.trial_data.omissions import left_out
    from scenarios.trial_data.reading import read_trial

    if len(cfg.recordings) != 1:
        fail(_PROG, f"recordings are {len(cfg.recordings)}; valid: one, or --to dataset")
    write, tables = _writer(cfg.to)
    trial = read_trial(cfg.recordings[0])
    write(trial, cfg.out)
    return {"trials": 1, "there": 0, "skipped": 0, "left_out": left_out(trial, tables)}


def _writer(to: str) -> tuple[Callable[[RecordedTrial, Path], Path], Iterable[str]]:
    """Return the function that writes a format, and the tables that the format holds.

    Only the library of that format is loaded, because the others are optional.
    """
    from scenarios.trial_data.tables import TABLES

    if to == "mcap":
        from scenarios.trial_data.rosbag import BAG_TABLES, write_bag

        return write_bag, BAG_TABLES
    if to == "ulog":
        from scenarios.trial_data.ulog import ULOG_TABLES, write_ulog

        return write_ulog, ULOG_TABLES
    from scenarios.trial_data.csv_folder import write_csv

    return write_csv, TABLES


def _require_place(cfg: ExportTrialCfg) -> None:
    """Refuse an output that cannot be written before recordings are read."""
    out = OutFile() if cfg.to == "ulog" else OutFolder()
    if fault := out.fault("out", cfg.out):
        fail(_PROG, fault)
    # A bag and a folder of tables are of one trial: files of another would mix into them.
    if cfg.to in {"mcap", "csv"} and cfg.out.exists():
        fail(_PROG, f"out {str(cfg.out)!r} is there already; valid: a name that is free")


def _add_all(cfg: ExportTrialCfg) -> dict[str, Any]:
    """Add the recordings that the dataset does not hold yet.

    A bad recording among several is reported and left out, so that one damaged file does not stop
    the export of a campaign.
    """
    from scenarios.recording.summary import UnreadableRecordingError
    from scenarios.trial_data.dataset.write import add_trial, has_trial
    from scenarios.trial_data.omissions import left_out
    from scenarios.trial_data.reading import TrialDataError, read_trial

    files = _files(cfg.recordings)
    left = [path for path in files if not has_trial(cfg.out, path.stem)]
    n_skipped = 0
    lacking: dict[str, None] = {}  # an ordered set
    with progress_bar("", len(left), "trials") as advance:
        for path in left:
            try:
                trial = read_trial(path)
                # A run that was killed has no verdict, and so no label to learn from.
                trial.require_end()
            except (UnreadableRecordingError, TrialDataError) as error:
                if len(files) == 1:
                    raise
                n_skipped += 1
                sys.stderr.write(f"{_PROG}: left out: {error}\n")
            else:
                add_trial(cfg.out, trial)
                lacking |= dict.fromkeys(left_out(trial))
            advance(1)
    n_there = len(files) - len(left)
    counts = {"trials": len(left) - n_skipped, "there": n_there, "skipped": n_skipped}
    return {**counts, "left_out": list(lacking)}


def _files(named: tuple[Path, ...]) -> list[Path]:
    """Return the recordings that are named, including those in folders of campaigns.

    A recording's name is its trial's, and the dataset's key. Two files of one name are therefore
    refused.
    """
    found: dict[str, Path] = {}
    for path in named:
        # A campaign keeps recordings in a subfolder; any other folder has them directly.
        files = sorted((path / RECORDINGS).glob("*.rrd")) or sorted(path.glob("*.rrd"))
        if path.is_dir() and not files:
            fail(_PROG, f"folder {str(path)!r} holds no recordings; valid: one of a campaign")
        for file in files or [path]:
            other = found.setdefault(file.stem, file)
            if other.resolve() != file.resolve():
                fail(_PROG, f"{str(other)!r} and {str(file)!r} have one name; valid: unlike names")
    return list(found.values())
