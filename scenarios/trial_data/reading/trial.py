"""A recorded trial as arrays, read from its recording alone.

Every export format starts from this one form, so that each of them needs to know neither rerun nor
the layout of recordings.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from scenarios.recording import layout
from scenarios.recording.rows import RecordedRows
from scenarios.recording.summary import facts_of, readable
from scenarios.trial_data.reading.error import TrialDataError
from scenarios.trial_data.reading.frames import Mount, Picture, read_frames, read_mounts
from scenarios.trial_data.reading.sensors import gauges, labels, optical_flow, scans
from scenarios.trial_data.reading.states import (
    Columns,
    contacts,
    events,
    measured,
    movers,
    n_rotors,
    plans,
    states,
)
from scenarios.trial_data.tables import (
    GAUGES,
    TABLES,
    Column,
    arrow_schema,
    motor_columns,
    names,
    rotor_numbers,
)

_WANTED = (
    layout.STATE,
    layout.WIND,
    layout.IMU,
    "motors",
    "autopilot",
    layout.TOUCHING,
    layout.VEHICLE,
    layout.ESTIMATE,
    layout.PLANNED,
    layout.TRAFFIC,
    layout.PHASE,
    layout.OPTICAL_FLOW,
    *(entity for entity, _ in GAUGES.values()),
)


@dataclass(frozen=True, kw_only=True)
class RecordedTrial:
    """Everything that a recording holds of a trial, except the scene."""

    name: str
    tables: Mapping[str, pa.Table]
    """Tables by the names and with the columns of `tables.TABLES`; empty if nothing is known."""
    pictures: tuple[Picture, ...]
    """Images of the table of frames, in its order; colours before depth."""
    mounts: Mapping[str, Mount]
    """Cameras by their names."""
    scans: tuple[Picture, ...] = ()
    """Points of the lidar's scans, as NumPy files."""
    others: frozenset[str] = frozenset()
    """Entities of the recording that no table holds."""

    def array(self, table: str, prefix: str, unit: str, parts: tuple[str, ...]) -> np.ndarray:
        """Return the columns of a vector in a table as an array (n, len(parts)).

        Args:
            table: Name of the table.
            prefix: First word of the columns' names.
            unit: Last word of the columns' names; empty for none.
            parts: Words between them, for example the axes.
        """
        columns = self.tables[table].select(names(prefix, parts, unit))
        return np.column_stack([column.to_numpy() for column in columns.columns])

    @property
    def rotors(self) -> tuple[str, ...]:
        """Numbers of the vehicle's rotors, as they stand in the names of columns."""
        speeds = [name for name in self.tables["motors"].column_names if name.startswith("speed_")]
        return rotor_numbers(len(speeds))

    def require(self, *tables: str, what: str) -> None:
        """Refuse a recording without some tables.

        Args:
            tables: Names of the tables.
            what: Purpose of the tables, for the message.

        Raises:
            TrialDataError: If one of them is empty.
        """
        for table in tables:
            if not len(self.tables[table]):
                raise TrialDataError(
                    f"recording {self.name!r} holds no {table}, which {what} needs; "
                    "valid: one of level state, interaction or full"
                )

    def require_end(self) -> None:
        """Refuse a recording whose run has not ended, or was killed.

        Raises:
            TrialDataError: If it has no verdict.
        """
        if self.tables["trials"]["code"][0].as_py() is None:
            raise TrialDataError(
                f"recording {self.name!r} has no end; valid: one of a flight that is over"
            )


def read_trial(path: Path) -> RecordedTrial:
    """Read a recording.

    Raises:
        UnreadableRecordingError: If the file is missing or no recording.
        TrialDataError: If it is a recording of something else.
    """
    # Only the wanted entities are kept in memory.
    with readable(path) as source:
        rows = RecordedRows(source, _WANTED)
    run = rows.properties.get(layout.RUN_PROPERTY)
    if run is None:
        raise TrialDataError(
            f"recording {str(path)!r} holds no flight; valid: one of aeroscene fly, campaign or "
            "sitl --record"
        )
    # Missing if the run was killed.
    verdict = rows.properties.get(layout.VERDICT_PROPERTY, {})
    figures = facts_of(verdict, "figures", path)
    try:
        return _trial_of(path, rows, run, verdict, figures)
    # A recording of another program may have any contents under our names.
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise TrialDataError(
            f"recording {str(path)!r} holds other data than a flight's ({error}); valid: one of "
            "aeroscene fly, campaign or sitl --record"
        ) from None


def _trial_of(
    path: Path,
    rows: RecordedRows,
    run: Mapping[str, Any],
    verdict: Mapping[str, Any],
    figures: Mapping[str, Any],
) -> RecordedTrial:
    mounts = read_mounts(rows)
    frames, pictures = read_frames(rows, mounts)
    scanned, clouds = scans(rows)
    columns: dict[str, Columns] = {
        "trials": _trial(run, verdict),
        "states": states(rows),
        "imu": measured(rows, "imu"),
        "motors": measured(rows, "motors"),
        "plans": plans(rows),
        "frames": frames,
        "labels": labels(rows, mounts),
        "scans": scanned,
        "optical_flow": optical_flow(rows),
        "gauges": gauges(rows),
        "movers": movers(rows),
        "contacts": contacts(figures.get("contacts", ())),
        "events": events(rows),
    }
    # A hexacopter has more columns of motors than a quadrotor.
    known = {**TABLES, "motors": motor_columns(n_rotors(rows))}
    tables = {name: _table(known[name], path.stem, found) for name, found in columns.items()}
    return RecordedTrial(
        name=path.stem,
        tables=tables,
        pictures=tuple(pictures),
        mounts=mounts,
        scans=tuple(clouds),
        others=frozenset(rows.others),
    )


def _table(known: tuple[Column, ...], trial: str, columns: Columns) -> pa.Table:
    """Return columns as a table; missing columns are null."""
    schema = arrow_schema(known)
    # All columns of a table have one length.
    n = len(next(iter(columns.values()), ()))
    arrays = [
        pa.array([trial] * n, pa.string())
        if field.name == "trial"
        else pa.array(columns[field.name], field.type)
        if field.name in columns
        else pa.nulls(n, field.type)
        for field in schema
    ]
    return pa.table(arrays, schema=schema)


def _trial(run: Mapping[str, Any], verdict: Mapping[str, Any]) -> Columns:
    asked = {name: [run.get(name)] for name in ("scene", "vehicle", "seed", "config", "limits")}
    given = {name: [verdict.get(name)] for name in ("success", "code", "reason")}
    return {**asked, **given, "verdict": [verdict.get("figures")]}
