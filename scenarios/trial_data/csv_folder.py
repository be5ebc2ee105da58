"""A trial as a folder of CSV files, its images beside them, and a schema."""

from __future__ import annotations

from pathlib import Path

from pyarrow import csv

from scenarios.trial_data.folders import building
from scenarios.trial_data.reading import RecordedTrial
from scenarios.trial_data.tables import SCHEMA_FILE, TABLES, schema_json

IMAGES, SCANS = "images", "scans"
_README = """\
One file a table; units are in the names of the columns, schema.json has types, frames and meanings.
Times are simulated microseconds. Images of the table of frames are in images/, points of the table
of scans in scans/.
"""


def write_csv(trial: RecordedTrial, out: Path) -> Path:
    """Write all tables and images of a trial.

    Args:
        trial: The trial.
        out: Folder to create.

    Returns:
        The folder.

    Raises:
        OSError: If it cannot be written; nothing is left.
        TrialDataError: If something is there already.
    """
    with building(out) as folder:
        for name, table in trial.tables.items():
            csv.write_csv(table, folder / f"{name}.csv")
        # Types, units and frames, which a CSV file cannot hold.
        (folder / SCHEMA_FILE).write_bytes(schema_json(TABLES))
        (folder / "README.txt").write_text(_README, encoding="utf-8")
        for name, files in ((IMAGES, trial.pictures), (SCANS, trial.scans)):
            (folder / name).mkdir()
            for file in files:
                (folder / name / file.file).write_bytes(file.data)
    return out
