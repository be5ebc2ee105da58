"""The fast part of a recording: one second of state logs at a time, as columns.

A `log` call costs 30 to 60 us and a row of a column about 1 us, so everything that changes with
every control tick waits in an array and goes out once a simulated second.
"""

from __future__ import annotations

import numpy as np
import rerun as rr
from jaxtyping import Float, Int

from scenarios.recording import layout
from scenarios.recording.series import ESTIMATE_FIELD, SERIES, ScalarSeries

SLOW_STEP = 5
"""Control ticks from one kept sample to the next, of quantities that are not fast: 50 Hz."""
PATH_STEP = 50
"""Control ticks in one piece of the executed trajectory, 0.2 s."""


_SCALARS = rr.Scalars.descriptor_scalars()


def sim_time(time_us: Int[np.ndarray, " n"]) -> rr.TimeColumn:
    """The time column of rows at these times."""
    return rr.TimeColumn(layout.TIMELINE, duration=time_us.astype("timedelta64[us]"))


def set_sim_time(stream: rr.RecordingStream, time_us: int) -> None:
    """Set the simulated time of the rows that are logged next."""
    stream.set_time(layout.TIMELINE, duration=np.timedelta64(time_us, "us"))


def send_history(stream: rr.RecordingStream, history: np.ndarray) -> None:
    """Write a stretch of `Plant.history` rows, oldest first."""
    slow = history[SLOW_STEP - 1 :: SLOW_STEP]
    fast_time, slow_time = sim_time(history["time_us"]), sim_time(slow["time_us"])
    for series in SERIES:
        rows, time = (history, fast_time) if series.is_fast else (slow, slow_time)
        if len(rows):
            send_scalars(stream, series.entity, time, _known(rows, series))
    position_m, quat = history["position_true_enu_m"], history["quat_true_wxyz"]
    send_pose(stream, layout.VEHICLE, fast_time, position_m, quat)
    _send_errors(stream, slow)


def _known(rows: np.ndarray, series: ScalarSeries) -> Float[np.ndarray, "n k"]:
    """Values of a series; NaN, which plots leave out, as long as they mean nothing."""
    column = slice(None) if series.column is None else slice(series.column, series.column + 1)
    parts = []
    for field, by in zip(series.fields, series.known_by, strict=True):
        values = rows[field][:, column]
        if by is not None:
            values = np.where(np.any(rows[by], axis=1, keepdims=True), values, np.nan)
        parts.append(values)
    return np.hstack(parts)


def _send_errors(stream: rr.RecordingStream, rows: np.ndarray) -> None:
    """Estimate and errors, from the estimator's alignment on."""
    from scenarios.run.scoring import rotation_angle_rad  # noqa: PLC0415 - loads the simulator

    rows = rows[rows[ESTIMATE_FIELD].any(axis=1)]
    if not len(rows):
        return
    time = sim_time(rows["time_us"])
    position_m, quat = rows[ESTIMATE_FIELD], rows["quat_est_wxyz"]
    send_pose(stream, layout.ESTIMATE, time, position_m, quat)
    error_m = position_m - rows["position_true_enu_m"]
    distance_m = np.linalg.norm(error_m, axis=1, keepdims=True)
    send_scalars(stream, layout.POSITION_ERROR, time, np.hstack([error_m, distance_m]))
    angle_deg = np.degrees(rotation_angle_rad(quat, rows["quat_true_wxyz"]))
    send_scalars(stream, layout.ATTITUDE_ERROR, time, angle_deg[:, None])


def send_scalars(
    stream: rr.RecordingStream, entity: str, time: rr.TimeColumn, values: Float[np.ndarray, "n k"]
) -> None:
    """Write rows of an entity with one or more series; cheaper than `Scalars.columns`."""
    offsets = np.arange(0, values.size + 1, values.shape[1], dtype=np.int32)
    batch = rr.components.ScalarBatch(np.ascontiguousarray(values).reshape(-1))
    column = rr.ComponentColumn(_SCALARS, batch, offsets=offsets)
    stream.send_columns(entity, [time], [column])


def send_pose(
    stream: rr.RecordingStream,
    entity: str,
    time: rr.TimeColumn,
    position_enu_m: Float[np.ndarray, "n 3"],
    quat_wxyz: Float[np.ndarray, "n 4"],
) -> None:
    """Write rows of an entity's pose in the world."""
    stream.send_columns(
        entity,
        [time],
        rr.Transform3D.columns(
            translation=position_enu_m.astype(np.float32),
            quaternion=np.roll(quat_wxyz, -1, axis=1).astype(np.float32),
        ),
    )


class ExecutedPath:
    """The flown trajectory as short pieces, which a view shows together up to its time cursor."""

    def __init__(self) -> None:
        self._last_enu_m: np.ndarray | None = None

    def send(self, stream: rr.RecordingStream, history: np.ndarray) -> None:
        """Write the pieces of a stretch of history, joined to those before."""
        position_m = history["position_true_enu_m"][SLOW_STEP - 1 :: SLOW_STEP].astype(np.float32)
        time_us = history["time_us"][SLOW_STEP - 1 :: SLOW_STEP]
        step = PATH_STEP // SLOW_STEP
        pieces: list[np.ndarray] = []
        ends_us: list[int] = []
        for start in range(0, len(position_m), step):
            piece = position_m[start : start + step]
            if self._last_enu_m is not None:
                piece = np.vstack([self._last_enu_m, piece])
            self._last_enu_m = piece[-1]
            pieces.append(piece)
            ends_us.append(int(time_us[min(start + step, len(time_us)) - 1]))
        if pieces:
            stream.send_columns(
                layout.EXECUTED,
                [sim_time(np.array(ends_us))],
                rr.LineStrips3D.columns(strips=pieces),
            )
