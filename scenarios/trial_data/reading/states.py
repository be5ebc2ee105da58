"""Tables of states, measurements, plans, movers, contacts and events of a recording.

A recording may be torn, because its run was killed. Every table is therefore cut to the rows of
which all columns are known.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from scenarios.recording import layout
from scenarios.recording.rows import RecordedRows
from scenarios.trial_data.tables import QUATERNION, names, rotor_numbers

Columns = dict[str, Any]
"""Columns of a table by their names, of one length."""
TRANSLATION, _QUATERNIONS = "Transform3D:translation", "Transform3D:quaternion"
SCALARS = "Scalars:scalars"
_EVENTS = {
    "phase": (layout.PHASE, "StateChange:state"),
    "mode": (layout.MODE, "StateChange:state"),
    "armed": (layout.ARMED, "StateChange:state"),
    "landed_state": (layout.LANDED, "StateChange:state"),
    "failsafe": (layout.FAILSAFE, "StateChange:state"),
    "text": (layout.STATUSTEXT, "TextLog:text"),
}
_AXES, _BODY = layout.AXES, layout.BODY_AXES
_OF_QUADROTOR = 4  # rotors of a vehicle whose motors were not recorded
_Vector = tuple[str, str, tuple[str, ...], str]
"""A vector of a table: prefix of its columns, entity, parts and unit."""
_FAST: Mapping[str, tuple[_Vector, ...]] = {
    "imu": (
        ("acceleration", layout.ACCELERATION, _BODY, "mps2"),
        ("angular_rate", layout.ANGULAR_RATE, _BODY, "radps"),
    ),
}
_VECTORS = (
    ("position", "m", _AXES, layout.STATES),
    ("velocity", "mps", _AXES, layout.STATES),
    ("angular_rate", "radps", _BODY, layout.STATES[1:]),
)
"""Vectors of the state: unit, axes, and the kinds of values that the recording has of each axis."""


def spread(prefix: str, parts: tuple[str, ...], unit: str, values: np.ndarray) -> Columns:
    """Return the columns of a vector, from values (n, len(parts))."""
    return dict(zip(names(prefix, parts, unit), values.T.astype(float), strict=True))


def states(rows: RecordedRows) -> Columns:
    """Return the states at every tick of the loop, up to the last one that is wholly known."""
    columns: Columns = {}
    times: list[np.ndarray] = []
    for what, unit, axes, whose in _VECTORS:
        for axis in axes:
            time_us, values = rows.vectors(layout.state(what, axis), SCALARS, len(whose))
            times.append(time_us)
            for column, each in zip(values.T, whose, strict=True):
                columns[f"{what}_{each}_{axis}_{unit}"] = column
    time_us, wind_mps = rows.vectors(layout.WIND, SCALARS)
    # A recording that was torn may lack the last rows of some of them.
    time_us = min((*times, time_us), key=len)
    columns |= spread("wind", _AXES, "mps", wind_mps)
    columns = {name: values[: len(time_us)] for name, values in columns.items()}
    for each, entity in (("true", layout.VEHICLE), ("estimate", layout.ESTIMATE)):
        columns |= spread(f"attitude_{each}", QUATERNION, "", pose_at(rows, entity, time_us)[1])
    touched_us, touching = rows.vectors(layout.TOUCHING, SCALARS, 1)
    columns["is_touching"] = _at(touched_us, touching, time_us)[:, 0] > 0
    return {"time_us": time_us, **columns}


def _at(
    known_us: Int[np.ndarray, " n"],
    values: Float[np.ndarray, "n k"],
    time_us: Int[np.ndarray, " m"],
    most_us: int = 0,
) -> Float[np.ndarray, "m k"]:
    """Return the last values at some times; NaN if the last row is more than `most_us` old."""
    found = np.full((len(time_us), values.shape[1]), np.nan)
    if len(known_us):
        # The last row at or before each time.
        row = np.searchsorted(known_us, time_us, side="right") - 1
        is_there = (row >= 0) & (time_us - known_us[row] <= most_us)
        found[is_there] = values[row[is_there]]
    return found


def pose_at(
    rows: RecordedRows, entity: str, time_us: Int[np.ndarray, " m"], *, most_us: int = 0
) -> tuple[Float[np.ndarray, "m 3"], Float[np.ndarray, "m 4"]]:
    """Return position and attitude wxyz of an entity at some times; NaN if unknown.

    Args:
        rows: The recording.
        entity: The entity.
        time_us: The times.
        most_us: Greatest age of a pose that still counts.
    """
    known_us, position_m = rows.vectors(entity, TRANSLATION)
    # rerun keeps quaternions as xyzw.
    quat_wxyz = rows.vectors(entity, _QUATERNIONS, 4)[1][:, [3, 0, 1, 2]]
    both = _at(known_us, np.column_stack([position_m, quat_wxyz]), time_us, most_us)
    return both[:, :3], both[:, 3:]


def measured(rows: RecordedRows, table: str) -> Columns:
    """Return the vectors of the table imu or motors, which are kept at every control tick."""
    found: Columns = {}
    for prefix, entity, parts, unit in _FAST[table] if table in _FAST else _motors(rows):
        time_us, values = rows.vectors(entity, SCALARS, len(parts))
        found |= {"time_us": time_us, **spread(prefix, parts, unit, values)}
    # Torn recordings may have more rows of one vector than of another.
    n = min(len(column) for column in found.values())
    return {name: column[:n] for name, column in found.items()}


def n_rotors(rows: RecordedRows) -> int:
    """Return the number of rotors of the vehicle, 4 if they were not recorded."""
    return rows.width(layout.MOTOR_SPEED, SCALARS) or _OF_QUADROTOR


def _motors(rows: RecordedRows) -> tuple[_Vector, ...]:
    parts = rotor_numbers(n_rotors(rows))
    return (
        ("command", layout.MOTOR_COMMAND, parts, "radps"),
        ("speed", layout.MOTOR_SPEED, parts, "radps"),
    )


def plans(rows: RecordedRows) -> Columns:
    """Return the points of all plans; a plan without a duration has no times."""
    durations_s = dict(rows.rows(layout.PLANNED, "duration_s"))
    parts: list[np.ndarray] = []
    points: list[np.ndarray] = [np.zeros((0, 3))]
    for plan, (since_us, strips) in enumerate(rows.rows(layout.PLANNED, "LineStrips3D:strips")):
        points.append(np.array(strips[0], dtype=float))
        # Points of a plan are evenly spaced in time.
        lasts_us = 1e6 * durations_s.get(since_us, [0.0])[0]
        time_us = since_us + np.linspace(0.0, lasts_us, len(points[-1]))
        same = np.ones_like(time_us)
        parts.append(np.column_stack([plan * same, since_us * same, np.rint(time_us)]))
    numbers = np.concatenate([np.zeros((0, 3)), *parts]).astype(np.int64)
    columns = dict(zip(("plan", "since_us", "time_us"), numbers.T, strict=True))
    return {**columns, **spread("position", _AXES, "m", np.concatenate(points))}


def movers(rows: RecordedRows) -> Columns:
    """Return the poses of all movers besides the vehicle."""
    whose: list[str] = []
    times, positions, quats = [np.zeros(0, int)], [np.zeros((0, 3))], [np.zeros((0, 4))]
    for entity in rows.entities:
        if entity.startswith(f"{layout.TRAFFIC}/"):
            time_us, position_m = rows.vectors(entity, TRANSLATION)
            times.append(time_us)
            positions.append(position_m)
            quats.append(rows.vectors(entity, _QUATERNIONS, 4)[1][:, [3, 0, 1, 2]])
            whose += [entity.rpartition("/")[2]] * len(time_us)
    return {
        "time_us": np.concatenate(times),
        "mover": whose,
        **spread("position", _AXES, "m", np.concatenate(positions)),
        **spread("attitude", QUATERNION, "", np.concatenate(quats)),
    }


def contacts(listed: Sequence[Mapping[str, Any]]) -> Columns:
    """Return the contacts as the verdict lists them."""
    places_m = np.array([each["position_enu_m"] for each in listed], dtype=float).reshape(-1, 3)
    return {
        "since_us": [round(1e6 * each["time_s"]) for each in listed],
        "until_us": [round(1e6 * each["until_s"]) for each in listed],
        "what": [each["what"] for each in listed],
        **spread("position", _AXES, "m", places_m),
    }


def events(rows: RecordedRows) -> Columns:
    """Return changes of states, and texts, in order of time."""
    found = [
        (time_us, what, value[0])
        for what, (entity, component) in _EVENTS.items()
        for time_us, value in rows.rows(entity, component)
    ]
    found.sort(key=lambda event: event[0])
    return {
        "time_us": [event[0] for event in found],
        "what": [event[1] for event in found],
        "value": [event[2] for event in found],
    }
