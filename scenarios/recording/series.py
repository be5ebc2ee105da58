"""Which quantities of a run are plotted, where they come from, and how they look."""

from __future__ import annotations

from dataclasses import dataclass

import rerun as rr

from scenarios.recording import layout


@dataclass(frozen=True, slots=True)
class ScalarSeries:
    """A plotted quantity: an entity, the history field it comes from, and its legend."""

    entity: str
    field: str
    legend: tuple[str, ...]
    colours: tuple[tuple[int, int, int], ...]
    is_fast: bool = False
    """Kept at every control tick, else at every tick of the loop."""


_RED, _GREEN, _BLUE = (230, 80, 80), (90, 200, 90), (90, 140, 255)
_PALE_RED, _PALE_GREEN, _PALE_BLUE = (255, 170, 160), (180, 235, 170), (175, 205, 255)
_DARK_RED, _DARK_GREEN, _DARK_BLUE = (140, 50, 50), (50, 115, 50), (50, 75, 150)
_ORANGE, _VIOLET, _TEAL, _YELLOW = (255, 150, 50), (190, 120, 255), (60, 200, 190), (240, 210, 70)

_TRUE = (_RED, _GREEN, _BLUE)
_EST = (_PALE_RED, _PALE_GREEN, _PALE_BLUE)
_REF = (_DARK_RED, _DARK_GREEN, _DARK_BLUE)
_ROTORS = (_ORANGE, _VIOLET, _TEAL, _YELLOW)


def _axes(prefix: str, suffix: str) -> tuple[str, ...]:
    return tuple(f"{prefix} {axis}{suffix}" for axis in "xyz")


def _rotors(prefix: str) -> tuple[str, ...]:
    return tuple(f"{prefix} {i + 1}" for i in range(4))


SERIES: tuple[ScalarSeries, ...] = (
    ScalarSeries(layout.POSITION_TRUE, "position_true_enu_m", _axes("true", " m"), _TRUE),
    ScalarSeries(layout.POSITION_EST, "position_est_enu_m", _axes("estimate", " m"), _EST),
    ScalarSeries(
        layout.POSITION_REF,
        "reference_position_enu_m",
        _axes("reference", " m"),
        _REF,
    ),
    ScalarSeries(layout.VELOCITY_TRUE, "velocity_true_enu_mps", _axes("true", " m/s"), _TRUE),
    ScalarSeries(layout.VELOCITY_EST, "velocity_est_enu_mps", _axes("estimate", " m/s"), _EST),
    ScalarSeries(
        layout.VELOCITY_REF,
        "reference_velocity_enu_mps",
        _axes("reference", " m/s"),
        _REF,
    ),
    ScalarSeries(layout.WIND, "wind_enu_mps", _axes("air", " m/s"), _TRUE),
    ScalarSeries(
        layout.ACCELERATION, "accel_flu_mps2", _axes("acceleration", " m/s²"), _TRUE, is_fast=True
    ),
    ScalarSeries(
        layout.ANGULAR_RATE, "gyro_flu_radps", _axes("rate", " rad/s"), _TRUE, is_fast=True
    ),
    ScalarSeries(
        layout.MOTOR_COMMAND, "rotor_command_radps", _rotors("command"), _ROTORS, is_fast=True
    ),
    ScalarSeries(layout.MOTOR_SPEED, "rotor_speed_radps", _rotors("speed"), _ROTORS, is_fast=True),
)

DERIVED: tuple[ScalarSeries, ...] = (
    ScalarSeries(
        layout.POSITION_ERROR,
        "",
        (*_axes("position", " m"), "distance m"),
        (*_TRUE, (235, 235, 235)),
    ),
    ScalarSeries(layout.ATTITUDE_ERROR, "", ("attitude deg",), (_ORANGE,)),
)
"""Series that are computed of several fields."""


def log_legends(stream: rr.RecordingStream) -> None:
    """Write names and colours of all series."""
    for series in (*SERIES, *DERIVED):
        stream.log(
            series.entity,
            rr.SeriesLines(names=series.legend, colors=series.colours, widths=1.2),
            static=True,
        )
