"""Quantities of a run that are plotted: fields they come from, names and colours.

`SERIES` is a table, so that one loop in `columns` writes all of them. To plot a further field of
`Plant.history`, add a row here and its entity in `layout`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import rerun as rr

from autonomy.model.quadrotor import MAX_ROTORS
from scenarios.recording import layout
from scenarios.recording.entity_stream import EntityStream

ESTIMATE_FIELD, REFERENCE_FIELD = "position_est_enu_m", "reference_position_enu_m"
"""Fields that are all zero until the estimator is aligned, and until there is a set point."""


@dataclass(frozen=True, slots=True)
class ScalarSeries:
    """A plotted quantity: an entity, the history fields it comes from, and its legend."""

    entity: str
    fields: tuple[str, ...]
    legend: tuple[str, ...]
    colours: tuple[tuple[int, int, int], ...]
    is_fast: bool = False
    """True keeps every control tick (250 Hz), False every tick of the loop (50 Hz)."""
    column: int | None = None
    """Column of each field that is plotted; None for all of them."""
    known_by: tuple[str | None, ...] = (None,)
    """For each field, another field that is all zero as long as the first one means nothing."""


_RED, _GREEN, _BLUE = (230, 80, 80), (90, 200, 90), (90, 140, 255)
_ORANGE, _VIOLET, _TEAL, _YELLOW = (255, 150, 50), (190, 120, 255), (60, 200, 190), (240, 210, 70)
_GREY = (140, 146, 154)

_AXES = (_RED, _GREEN, _BLUE)
_ROTORS = (
    *(_ORANGE, _VIOLET, _TEAL, _YELLOW, _RED, _GREEN, _BLUE, _GREY),
    *((150, 90, 30), (230, 140, 210), (120, 160, 60), (90, 110, 160)),
)
"""Colours of the rotors, as many as a vehicle can have."""


def _axes(prefix: str, suffix: str, axes: Sequence[str] = layout.AXES) -> tuple[str, ...]:
    return tuple(f"{prefix} {axis}{suffix}" for axis in axes)


def _rotors(prefix: str) -> tuple[str, ...]:
    return tuple(f"{prefix} {i + 1}" for i in range(MAX_ROTORS))


_BODY = layout.BODY_AXES
_ACCELERATIONS, _RATES = _axes("acceleration", " m/s²", _BODY), _axes("rate", " rad/s", _BODY)

SERIES: tuple[ScalarSeries, ...] = (
    *(
        ScalarSeries(
            layout.state(what, axis),
            (f"reference_{what}_enu_{u}", f"{what}_est_enu_{u}", f"{what}_true_enu_{u}"),
            layout.STATES,
            (_GREY, _ORANGE, _BLUE),
            column=k,
            known_by=(REFERENCE_FIELD, ESTIMATE_FIELD, None),
        )
        for what, u in (("position", "m"), ("velocity", "mps"))
        for k, axis in enumerate(layout.AXES)
    ),
    *(
        ScalarSeries(
            layout.state("angular_rate", axis),
            ("angular_rate_est_flu_radps", "angular_rate_true_flu_radps"),
            layout.STATES[1:],
            (_ORANGE, _BLUE),
            column=k,
            known_by=(ESTIMATE_FIELD, None),
        )
        for k, axis in enumerate(_BODY)
    ),
    ScalarSeries(layout.WIND, ("wind_enu_mps",), _axes("air", " m/s"), _AXES),
    ScalarSeries(layout.ACCELERATION, ("accel_flu_mps2",), _ACCELERATIONS, _AXES, is_fast=True),
    ScalarSeries(layout.ANGULAR_RATE, ("gyro_flu_radps",), _RATES, _AXES, is_fast=True),
    ScalarSeries(
        layout.MOTOR_COMMAND, ("rotor_command_radps",), _rotors("command"), _ROTORS, is_fast=True
    ),
    ScalarSeries(
        layout.MOTOR_SPEED, ("rotor_speed_radps",), _rotors("speed"), _ROTORS, is_fast=True
    ),
    ScalarSeries(layout.TOUCHING, ("is_touching",), ("touching",), (_RED,), is_fast=True),
)

DERIVED: tuple[ScalarSeries, ...] = (
    ScalarSeries(
        layout.POSITION_ERROR, (), (*_axes("position", " m"), "distance m"), (*_AXES, _GREY)
    ),
    ScalarSeries(layout.ATTITUDE_ERROR, (), ("attitude deg",), (_ORANGE,)),
)
"""Series that are computed from several fields; `columns` computes them."""


def log_legends(stream: EntityStream, n_rotors: int) -> None:
    """Write names and colours of all series of a vehicle.

    Args:
        stream: Stream of the vehicle.
        n_rotors: Number of its rotors; history has columns for `MAX_ROTORS`.
    """
    for series in (*SERIES, *DERIVED):
        # The tuple itself marks the series with a column for each rotor.
        n = n_rotors if series.colours is _ROTORS else len(series.legend)
        lines = rr.SeriesLines(names=series.legend[:n], colors=series.colours[:n], widths=1.2)
        stream.log(series.entity, lines, static=True)
