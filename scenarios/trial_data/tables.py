"""Tables of a recorded trial: their columns, with type, unit and frame.

The same tables are written as CSV and as Parquet. A vector has a column for each component, so that
every program can read them. A quaternion leads from FLU to ENU, or from the optical frame to ENU.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import pyarrow as pa

from scenarios.recording import layout
from scenarios.recording.layout import AXES, BODY_AXES

SCHEMA_FILE = "schema.json"
QUATERNION = ("w", "x", "y", "z")
_UNITS = {
    "m": "m",
    "mps": "m/s",
    "mps2": "m/s^2",
    "rad": "rad",
    "radps": "rad/s",
    "us": "us",
    "px": "px",
    "v": "V",
    "a": "A",
    "percent": "%",
}
"""Unit by the last word of a column's name."""


class Column(NamedTuple):
    """A column of a table; `says` is its meaning in the schema."""

    name: str
    type: pa.DataType
    says: str

    @property
    def unit(self) -> str:
        """Unit of its values; empty if they have none."""
        return _UNITS.get(self.name.rpartition("_")[2], "")


def names(prefix: str, parts: Iterable[str], unit: str = "") -> list[str]:
    """Return the names of the columns of a vector."""
    suffix = f"_{unit}" if unit else ""
    return [f"{prefix}_{part}{suffix}" for part in parts]


def _vector(prefix: str, parts: Iterable[str], unit: str, says: str) -> list[Column]:
    return [Column(name, pa.float64(), says) for name in names(prefix, parts, unit)]


_TRIAL = Column("trial", pa.string(), "name of the recording's file, without .rrd")
_TIME = Column("time_us", pa.int64(), "simulated time")
# Estimates and references begin after the flight's first ticks.
_KNOWN = "NaN until there is one"


def rotor_numbers(n_rotors: int) -> tuple[str, ...]:
    """Return the numbers of so many rotors, as they stand in the names of columns."""
    return tuple(str(number) for number in range(1, n_rotors + 1))


def motor_columns(n_rotors: int) -> tuple[Column, ...]:
    """Return the columns of the table of motors of a vehicle with so many rotors."""
    parts = rotor_numbers(n_rotors)
    return (
        _TRIAL,
        _TIME,
        *_vector("command", parts, "radps", "commanded speed of the rotor, 250 Hz"),
        *_vector("speed", parts, "radps", "its true speed"),
    )


GAUGES: Mapping[str, tuple[str, str]] = {
    "battery_voltage_v": (layout.BATTERY_VOLTAGE, "10 Hz"),
    "battery_current_a": (layout.BATTERY_CURRENT, "drawn from the battery"),
    "battery_remaining_percent": (layout.BATTERY_REMAINING, "charge that is left"),
    "sigma_horizontal_m": (f"{layout.POSITION_SIGMA}/horizontal", "of the estimated position"),
    "sigma_vertical_m": (f"{layout.POSITION_SIGMA}/vertical", "of the estimated position"),
    "airspeed_mps": (layout.sensor("airspeed"), "indicated; NaN without the sensor"),
    "range_m": (layout.sensor("rangefinder"), "to what lies below; NaN where nothing is met"),
    "flow_radps": (layout.sensor("optical_flow"), "size of the optical flow; NaN without"),
}
"""Entity and meaning of each value that is sampled at 10 Hz, by the name of its column."""

# `trials` must be the first: a dataset writes it last, as the sign that a trial is complete.
TABLES: Mapping[str, tuple[Column, ...]] = {
    "trials": (
        _TRIAL,
        Column("scene", pa.string(), "id of the scene"),
        Column("vehicle", pa.string(), "airframe"),
        Column("seed", pa.int64(), "seed of the flight"),
        Column("success", pa.bool_(), "whether it landed within every limit; null: not judged"),
        Column("code", pa.string(), "how it ended, see docs/verdict.md"),
        Column("reason", pa.string(), "the same in words"),
        Column("config", pa.string(), "the run's configuration, JSON"),
        Column("limits", pa.string(), "limits of the verdict, JSON"),
        Column("verdict", pa.string(), "all figures of the verdict, JSON"),
    ),
    "states": (
        _TRIAL,
        _TIME,
        *_vector("position_true", AXES, "m", "centre of mass, ENU, 50 Hz"),
        *_vector("velocity_true", AXES, "mps", "ENU"),
        *_vector("attitude_true", QUATERNION, "", "FLU to ENU"),
        *_vector("angular_rate_true", BODY_AXES, "radps", "FLU"),
        *_vector("position_estimate", AXES, "m", f"ENU; {_KNOWN}"),
        *_vector("velocity_estimate", AXES, "mps", f"ENU; {_KNOWN}"),
        *_vector("attitude_estimate", QUATERNION, "", f"FLU to ENU; {_KNOWN}"),
        *_vector("angular_rate_estimate", BODY_AXES, "radps", f"FLU; {_KNOWN}"),
        *_vector("position_reference", AXES, "m", f"ENU, what the controller follows; {_KNOWN}"),
        *_vector("velocity_reference", AXES, "mps", f"ENU; {_KNOWN}"),
        *_vector("wind", AXES, "mps", "velocity of the air at the vehicle, ENU"),
        Column("is_touching", pa.bool_(), "whether the vehicle touches anything"),
    ),
    "imu": (
        _TRIAL,
        _TIME,
        *_vector("acceleration", BODY_AXES, "mps2", "specific force as measured, FLU, 250 Hz"),
        *_vector("angular_rate", BODY_AXES, "radps", "as measured, FLU"),
    ),
    # The usual number; a trial's own table has as many columns as its vehicle has rotors.
    "motors": motor_columns(4),
    "plans": (
        _TRIAL,
        Column("plan", pa.int64(), "number of the plan, from 0"),
        Column("since_us", pa.int64(), "simulated time at which it was taken up"),
        Column("time_us", pa.int64(), "simulated time at which the vehicle is to be there"),
        *_vector("position", AXES, "m", "point of the plan, ENU, 10 Hz"),
    ),
    "frames": (
        _TRIAL,
        Column("frame", pa.int64(), "number of the frame in its trial, in order of time"),
        _TIME,
        Column("camera", pa.string(), "name of the camera"),
        Column("width_px", pa.int64(), "columns"),
        Column("height_px", pa.int64(), "rows"),
        *_vector("focal", ("x", "y"), "px", "focal length"),
        *_vector("centre", ("x", "y"), "px", "principal point; whole numbers are pixel centres"),
        *_vector("position", AXES, "m", "true position of the camera, ENU"),
        *_vector("attitude", QUATERNION, "", "optical (x right, y down, z forward) to ENU"),
        Column("rgb_file", pa.string(), "JPEG; null where none was recorded"),
        Column("depth_file", pa.string(), "PNG, 16 bit: depth along the axis in mm, 0: nothing"),
        Column("classes_file", pa.string(), "PNG, 8 bit: class of each pixel, see labels"),
        Column("instances_file", pa.string(), "PNG, 16 bit: object of each pixel, see labels"),
    ),
    "labels": (
        _TRIAL,
        Column("image", pa.string(), "classes or instances"),
        Column("number", pa.int64(), "number in these images"),
        Column("name", pa.string(), "what it stands for"),
    ),
    "scans": (
        _TRIAL,
        Column("scan", pa.int64(), "number of the scan of the lidar in its trial"),
        _TIME,
        Column("points", pa.int64(), "points that were met"),
        *_vector("position", AXES, "m", "true position of the vehicle, ENU"),
        *_vector("attitude", QUATERNION, "", "FLU to ENU, true"),
        Column(
            "points_file", pa.string(), "NumPy file, float32 (points, 3): on the vehicle, FLU, m"
        ),
    ),
    "optical_flow": (
        _TRIAL,
        _TIME,
        Column("integration_us", pa.int64(), "the angles are sums over this time, up to time_us"),
        *_vector("flow", ("forward", "right"), "rad", "flow about these axes of the vehicle"),
        *_vector("gyro", ("forward", "right", "down"), "rad", "turn about these axes"),
        Column("distance_m", pa.float64(), "to what lies below; infinite beyond reach"),
        Column("quality", pa.int64(), "0: no flow was seen, 255: all of it"),
    ),
    "gauges": (
        _TRIAL,
        _TIME,
        *(Column(name, pa.float64(), says) for name, (_, says) in GAUGES.items()),
    ),
    "movers": (
        _TRIAL,
        _TIME,
        Column("mover", pa.string(), "a person, a car or another drone"),
        *_vector("position", AXES, "m", "middle of its underside, ENU, 50 Hz"),
        *_vector("attitude", QUATERNION, "", "its frame (x ahead, z up) to ENU"),
    ),
    "contacts": (
        _TRIAL,
        Column("since_us", pa.int64(), "simulated time at which the contact began"),
        Column("until_us", pa.int64(), "and ended"),
        Column("what", pa.string(), "what was touched"),
        *_vector("position", AXES, "m", "where, ENU"),
    ),
    "events": (
        _TRIAL,
        _TIME,
        Column("what", pa.string(), "phase, mode, armed, landed_state, failsafe or text"),
        Column("value", pa.string(), "the new state, or the line"),
    ),
}
"""Columns of each table; the table of motors has those of a quadrotor, or more for more rotors."""


def arrow_schema(columns: Iterable[Column]) -> pa.Schema:
    """Return the types of some columns, with unit and meaning as metadata of each field."""
    return pa.schema(
        [
            pa.field(each.name, each.type, metadata={"unit": each.unit, "description": each.says})
            for each in columns
        ]
    )


def schema_json(tables: Mapping[str, Iterable[Column]]) -> bytes:
    """Return the description of tables for people and programs, as JSON."""
    described: dict[str, Any] = {
        table: [
            {"name": c.name, "type": str(c.type), "unit": c.unit, "description": c.says}
            for c in columns
        ]
        for table, columns in tables.items()
    }
    frames = {
        "ENU": "world: x east, y north, z up, metres from the scene's origin",
        "FLU": "vehicle: x forward, y left, z up",
        "optical": "camera: x right, y down, z forward",
    }
    # Beside the tables, because CSV files cannot hold units.
    document = {"tables": described, "frames": frames, "quaternions": "w, x, y, z; unit"}
    return json.dumps(document, indent=2).encode() + b"\n"
