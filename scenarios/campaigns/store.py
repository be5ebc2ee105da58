"""Results of a campaign in its folder: tables in Parquet, and a journal of the newest rows.

A Parquet file cannot grow, and a journal of a million rows would be slow to read. So both are used.
A row is appended to the journal the moment its trial ends, so that a process that is killed loses
no finished trial. From time to time the journal becomes a table, `trials/NNNNN.parquet`, whole or
not at all. A row that is in a table as well as in the journal, because the process was killed
between the two, counts once.
"""

from __future__ import annotations

import fcntl
import json
import logging
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import BinaryIO

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from aeroscene.files import open_regular, replacing
from aeroscene.files.bounds import count_values
from scenarios.campaigns.flyer import Row
from scenarios.campaigns.table_file import TableFileError, read_table_file

_LOG = logging.getLogger(__name__)
# Folder of the tables, the journal, and the number of rows at which it becomes a table.
TABLES = "trials"
JOURNAL = "trials.jsonl"
ROWS_A_TABLE = 5000
TRACKS = ("planned_enu_m", "flown_enu_m")
"""Columns with paths: lists of points, ENU, m."""
_TEXT, _WHOLE, _REAL, _FLAG = pa.string(), pa.int64(), pa.float64(), pa.bool_()
SCHEMA = pa.schema(
    [
        *((name, _TEXT) for name in ("trial_id", "family", "scene", "vehicle")),
        ("trial", _WHOLE),
        ("success", _FLAG),
        ("code", _TEXT),
        ("fate", _TEXT),
        ("reason", _TEXT),
        ("navigated", _FLAG),
        *((name, _REAL) for name in ("grade", "progress")),
        *((name, _TEXT) for name in ("goal", "text")),
        *((name, _REAL) for name in ("navigation_error_m", "oracle_error_m", "path_m", "spl")),
        ("seed", _WHOLE),
        ("start", pa.list_(_REAL, 3)),
        ("start_yaw_rad", _REAL),
        ("area", _WHOLE),
        ("landed_area", _WHOLE),
        ("goal_areas", pa.list_(_WHOLE)),
        ("difficulty", _TEXT),
        *((name, _REAL) for name in ("way_m", "least_navigation_s", "corridor_m", "clutter")),
        ("openings", _WHOLE),
        *((name, _REAL) for name in ("time_limit_s", "wind_mps", "wind_from_deg", "gust_mps")),
        *((name, _TEXT) for name in ("turbulence", "traffic", "gnss", "depth_camera", "map")),
        *((name, _TEXT) for name in ("aiding", "failures", "light", "season")),
        ("navigation_limit_s", _REAL),
        *((name, _REAL) for name in ("sim_seconds", "wall_seconds", "cpu_seconds")),
        *((name, _REAL) for name in ("trial_cpu_seconds", "real_time_factor")),
        ("contacts_before_touchdown", _WHOLE),
        *((name, _REAL) for name in ("touchdown_error_m", "touchdown_speed_mps", "slide_m")),
        ("soles_inside", _FLAG),
        *((name, _REAL) for name in ("tilt_at_rest_deg", "stopped_after_s")),
        ("rotor_spin_ups", _WHOLE),
        *((name, _REAL) for name in ("navigation_s", "flight_s", "energy_j", "jerk_rms_mps3")),
        ("replans", _WHOLE),
        *((name, _REAL) for name in ("least_clearance_m", "nearest_mover_m")),
        *((name, _REAL) for name in ("position_rmse_m", "attitude_rmse_deg")),
        ("contacts", _TEXT),
        *((name, _TEXT) for name in ("state_hash", "recording", "version")),
        *((name, pa.list_(pa.list_(pa.float32(), 3))) for name in TRACKS),
    ]
)
"""Columns of a table; `contacts` is JSON."""
# Bounds against files of others, which may be made to exhaust memory.
_MOST_ROW_BYTES = 8 << 20
_MOST_ROW_VALUES = 200_000
_MOST_ROWS = 20_000
"""Most rows of a journal, which becomes a table after `ROWS_A_TABLE`."""
_MOST_VALUES = 6_000_000
"""Most values of a whole journal: 5,000 rows with their tracks have half of it."""
# Control and format characters, with which a text could change what a terminal shows.
_OBEYED = r"[\p{Cc}\p{Cf}\p{Zl}\p{Zp}]"
COLUMNS = tuple(name for name in SCHEMA.names if name not in TRACKS)
"""All columns except the tracks, which take more room than all others together."""


class StoreError(ValueError):
    """A folder holds no results, or damaged ones; one line says which file."""


class Store:
    """Results in a folder that one process at a time adds to.

    Attributes:
        done: Ids of the trials that are there.
    """

    def __init__(self, folder: Path, journal: BinaryIO) -> None:
        """Read the present results; see `open_store`."""
        self._folder = folder
        self._journal = journal
        in_tables = _ids_in_sound_tables(folder)
        self._new = [row for row in _journalled(folder) if row["trial_id"] not in in_tables]
        self.done: set[str] = in_tables | {row["trial_id"] for row in self._new}
        # A row that a killed process left unfinished ends here. Nothing is rewritten, because a
        # process killed during that would lose rows.
        if not _ends_with_a_line(journal):
            journal.write(b"\n")
            journal.flush()

    def add(self, row: Row) -> None:
        """Keep a row from now on, even if this process is killed.

        Raises:
            OSError: If it cannot be written.
        """
        self._journal.write(json.dumps(row).encode() + b"\n")
        # To the system, not to the disk: this survives a killed process, not a power cut.
        self._journal.flush()
        self._new.append(row)
        self.done.add(row["trial_id"])
        if len(self._new) >= ROWS_A_TABLE:
            self.fold()

    def fold(self) -> None:
        """Turn the journal into a table."""
        if self._new:
            folder = self._folder / TABLES
            number = max((int(path.stem) for path in _table_paths(self._folder)), default=-1) + 1
            with replacing(folder / f"{number:05d}.parquet") as file:
                pq.write_table(_table_of(self._new), file)
        self._new.clear()
        # Only now: every row of it is in a table.
        self._journal.truncate(0)


@contextmanager
def open_store(folder: Path) -> Iterator[Store]:
    """Open the results in a folder to add to them; the folder is created if needed.

    Raises:
        StoreError: If another process adds to them at present.
        OSError: If the folder cannot be written to.
    """
    (folder / TABLES).mkdir(parents=True, exist_ok=True)
    with (folder / JOURNAL).open("a+b") as journal:
        try:
            fcntl.flock(journal, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise StoreError(
                f"out {str(folder)!r}: another campaign is running there; "
                "valid: wait for its end, or another folder"
            ) from None
        # Left by a process that was killed while it wrote a table.
        for unfinished in (folder / TABLES).glob(".*.parquet.*"):
            unfinished.unlink(missing_ok=True)
        store = Store(folder, journal)
        try:
            yield store
        finally:
            store.fold()


def read_results(
    folder: Path,
    columns: Sequence[str] = COLUMNS,
    *,
    where: pc.Expression | None = None,
) -> pa.Table:
    """Return the rows in a folder, even while a campaign adds to it.

    Args:
        folder: Folder of a campaign.
        columns: Names of the columns of `SCHEMA` to read.
        where: Condition that rows have to meet.

    Raises:
        StoreError: If there are none, or a table is damaged.
    """
    if not (folder / JOURNAL).is_file():
        raise StoreError(f"{str(folder)!r} holds no campaign; valid: a folder of one")
    # The journal first: a row that moves into a table meanwhile is then seen twice, not lost.
    journalled = _table_of(_journalled(folder))
    wanted = list(dict.fromkeys(["trial_id", *columns]))
    parts = [_read_table(path, wanted, where) for path in _table_paths(folder)]
    is_journalled = pc.field("trial_id").isin(journalled["trial_id"].combine_chunks())
    twice = pa.chunked_array([part.filter(is_journalled)["trial_id"] for part in parts], _TEXT)
    new = journalled.filter(~pc.field("trial_id").isin(twice.combine_chunks()))
    if where is not None:
        new = new.filter(where)
    return _visible(pa.concat_tables([*parts, new.select(wanted)]).select(list(columns)))


def _visible(table: pa.Table) -> pa.Table:
    """Return the table with control characters in its texts replaced; a folder may be anybody's."""
    for number, field in enumerate(table.schema):
        if field.type == _TEXT:
            tame = pc.replace_substring_regex(  # pyrefly: ignore[missing-attribute]
                table[field.name], pattern=_OBEYED, replacement="\N{REPLACEMENT CHARACTER}"
            )
            table = table.set_column(number, field, tame)
    return table


def _ends_with_a_line(journal: BinaryIO) -> bool:
    size = journal.seek(0, os.SEEK_END)
    if not size:
        return True
    journal.seek(size - 1)
    return journal.read(1) == b"\n"


def _table_paths(folder: Path) -> list[Path]:
    return sorted((folder / TABLES).glob("[0-9]*.parquet"))


def _read_table(path: Path, names: Sequence[str], where: pc.Expression | None = None) -> pa.Table:
    """Return some columns of a table; null if it is older than the column.

    Raises:
        StoreError: If it is damaged.
    """
    try:
        return read_table_file(path, list(dict.fromkeys(["trial_id", *names])), SCHEMA, where)
    except TableFileError as error:
        raise StoreError(f"table {str(path)!r} is damaged: {error}; valid: remove it") from None


def _ids_in_sound_tables(folder: Path) -> set[str]:
    """Return the ids of the trials in all tables; damaged ones are renamed with a warning."""
    ids: set[str] = set()
    for path in _table_paths(folder):
        try:
            ids.update(_read_table(path, ["trial_id"])["trial_id"].to_pylist())
        except StoreError:
            path.rename(path.with_suffix(".damaged"))
            _LOG.warning("%s is damaged and set aside: its trials are flown again", path)
    return ids


def _journalled(folder: Path) -> list[Row]:
    """Return the whole rows of the journal: the last one of a killed process may be cut short."""
    rows: dict[str, Row] = {}
    n_values = 0
    with open_regular(folder / JOURNAL) as journal:
        for line in iter(partial(journal.readline, _MOST_ROW_BYTES), b""):
            here = count_values(line)
            n_values += here
            if here > _MOST_ROW_VALUES or n_values > _MOST_VALUES or len(rows) > _MOST_ROWS:
                raise StoreError(
                    f"file {str(folder / JOURNAL)!r} holds more than {_MOST_ROWS} rows or "
                    f"{_MOST_VALUES} values; valid: what `aeroscene campaign` has written"
                )
            try:
                row = json.loads(line)
                # The first row of a trial counts.
                rows.setdefault(str(row["trial_id"]), row)
            except (ValueError, KeyError, TypeError, RecursionError):
                continue
    return list(rows.values())


def _table_of(rows: list[Row]) -> pa.Table:
    """Return rows as a table.

    Raises:
        StoreError: If a value is of another kind than its column.
    """
    flat = [row | {"contacts": json.dumps(row.get("contacts", []))} for row in rows]
    try:
        return pa.Table.from_pylist(flat, schema=SCHEMA)
    except (pa.ArrowException, TypeError, ValueError, OverflowError) as error:
        reason = str(error).split("\n", 1)[0]
        raise StoreError(
            f"{JOURNAL} holds a row of another kind: {reason}; valid: what `aeroscene campaign` "
            "has written"
        ) from None
