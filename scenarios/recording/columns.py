"""The fast part of a recording: one second of state logs at a time, as columns.

A `log` call costs 30 to 60 us and a row of a column about 1 us, so everything that changes with
every control tick waits in an array and goes out once a simulated second.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import rerun as rr
from jaxtyping import Bool, Float, Int

from scenarios.recording import layout
from scenarios.recording.entity_stream import EntityStream
from scenarios.recording.series import (
    ESTIMATE_FIELD,
    REFERENCE_FIELD,
    SERIES,
    ScalarSeries,
)

SLOW_STEP = 5
"""Control ticks from one kept sample to the next, of quantities that are not fast: 50 Hz."""
PATH_STEP = 50
"""Control ticks in one piece of the executed trajectory, 0.2 s."""


_SCALARS = rr.Scalars.descriptor_scalars()
_STRIPS = rr.LineStrips3D.descriptor_strips()
_TRANSLATION = rr.Transform3D.descriptor_translation()
_QUATERNION = rr.Transform3D.descriptor_quaternion()


def sim_time(time_us: Int[np.ndarray, " n"]) -> rr.TimeColumn:
    """Return the time column of rows at these simulated times, in us."""
    return rr.TimeColumn(layout.TIMELINE, duration=time_us.astype("timedelta64[us]"))


def set_sim_time(stream: EntityStream, time_us: int) -> None:
    """Set the simulated time of the rows that are logged next.

    Args:
        stream: Stream whose rows are meant.
        time_us: Simulated time since the start.
    """
    stream.set_time(layout.TIMELINE, duration=np.timedelta64(time_us, "us"))


def send_history(stream: EntityStream, history: np.ndarray) -> None:
    """Write series, true pose, estimated pose and errors of a stretch of history.

    Args:
        stream: Stream of the vehicle.
        history: Rows of `Plant.history`, one for each control tick, oldest first.
    """
    # The last of the control ticks within each tick of the loop.
    slow = history[SLOW_STEP - 1 :: SLOW_STEP]
    fast_time, slow_time = sim_time(history["time_us"]), sim_time(slow["time_us"])
    is_known = {field: np.any(slow[field], axis=1) for field in (REFERENCE_FIELD, ESTIMATE_FIELD)}
    for series in SERIES:
        rows, time = (history, fast_time) if series.is_fast else (slow, slow_time)
        if len(rows):
            send_scalars(stream, series.entity, time, _values(rows, series, is_known))
    position_m, quat = history["position_true_enu_m"], history["quat_true_wxyz"]
    send_pose(stream, layout.VEHICLE, fast_time, position_m, quat)
    _send_errors(stream, slow, is_known[ESTIMATE_FIELD])


def _values(
    rows: np.ndarray, series: ScalarSeries, is_known: Mapping[str, Bool[np.ndarray, " n"]]
) -> Float[np.ndarray, "n k"]:
    """Return the values of a series, with NaN, which plots leave out, while they mean nothing."""
    if series.column is None:
        (field,) = series.fields
        return rows[field].reshape(len(rows), -1)
    values = np.column_stack([rows[field][:, series.column] for field in series.fields])
    for k, by in enumerate(series.known_by):
        if by is not None:
            values[~is_known[by], k] = np.nan
    return values


def _send_errors(
    stream: EntityStream, rows: np.ndarray, is_aligned: Bool[np.ndarray, " n"]
) -> None:
    """Write estimate and errors, from the estimator's alignment on."""
    from scenarios.trials.measures.estimation import rotation_angle_rad

    if not is_aligned.any():
        return
    time = sim_time(rows["time_us"][is_aligned])
    position_m, quat = rows[ESTIMATE_FIELD][is_aligned], rows["quat_est_wxyz"][is_aligned]
    send_pose(stream, layout.ESTIMATE, time, position_m, quat)
    error_m = position_m - rows["position_true_enu_m"][is_aligned]
    distance_m = np.linalg.norm(error_m, axis=1)
    send_scalars(stream, layout.POSITION_ERROR, time, np.column_stack([error_m, distance_m]))
    angle_rad = rotation_angle_rad(quat, rows["quat_true_wxyz"][is_aligned])
    send_scalars(stream, layout.ATTITUDE_ERROR, time, np.degrees(angle_rad)[:, None])


def send_scalars(
    stream: EntityStream, entity: str, time: rr.TimeColumn, values: Float[np.ndarray, "n k"]
) -> None:
    """Write rows of an entity with one or more series; cheaper than `Scalars.columns`.

    Args:
        stream: Stream of the vehicle.
        entity: Path of the entity.
        time: Times of the rows.
        values: One row a time, one column a series; NaN leaves a gap in the plot.
    """
    # rerun flattens the instances of all rows; row i has those from offset i to offset i + 1.
    offsets = np.arange(0, values.size + 1, values.shape[1], dtype=np.int32)
    batch = rr.components.ScalarBatch(np.ascontiguousarray(values).reshape(-1))
    column = rr.ComponentColumn(_SCALARS, batch, offsets=offsets)
    stream.send_columns(entity, [time], [column])


def send_pose(
    stream: EntityStream,
    entity: str,
    time: rr.TimeColumn,
    position_enu_m: Float[np.ndarray, "n 3"],
    quat_wxyz: Float[np.ndarray, "n 4"],
) -> None:
    """Write rows of an entity's pose in the world; cheaper than `Transform3D.columns`.

    Args:
        stream: Stream of the vehicle.
        entity: Path of the entity.
        time: Times of the rows.
        position_enu_m: Positions of the body's origin.
        quat_wxyz: Attitudes, body to ENU.
    """
    translation = rr.components.Translation3DBatch(position_enu_m.astype(np.float32))
    # rerun's quaternions have the scalar part last.
    quat_xyzw = quat_wxyz[:, [1, 2, 3, 0]].astype(np.float32)
    columns = [
        rr.ComponentColumn(_TRANSLATION, translation),
        rr.ComponentColumn(_QUATERNION, rr.components.RotationQuatBatch(quat_xyzw)),
    ]
    stream.send_columns(entity, [time], columns)


class ExecutedPath:
    """The flown trajectory as short pieces, which a view shows together up to its time cursor."""

    def __init__(self) -> None:
        self._last_enu_m: np.ndarray | None = None

    def send(self, stream: EntityStream, history: np.ndarray) -> None:
        """Write the pieces of a stretch of history, joined to those before.

        Args:
            stream: Stream of the vehicle.
            history: Rows of `Plant.history`, oldest first, that continue those of the last call.
        """
        position_m = history["position_true_enu_m"][SLOW_STEP - 1 :: SLOW_STEP].astype(np.float32)
        time_us = history["time_us"][SLOW_STEP - 1 :: SLOW_STEP]
        n, step = len(time_us), PATH_STEP // SLOW_STEP
        if n == 0:
            return
        # Each piece begins where the one before ended, otherwise the line would have gaps.
        before_m = position_m[0] if self._last_enu_m is None else self._last_enu_m
        self._last_enu_m = position_m[-1]
        points_m = np.vstack([before_m, position_m])
        # A short last piece repeats its end, because all pieces must have one length.
        of_pieces = np.minimum(np.arange(0, n, step)[:, None] + np.arange(step + 1), n)
        strips = rr.components.LineStrip3DBatch(points_m[of_pieces])
        time = sim_time(time_us[of_pieces[:, -1] - 1])
        stream.send_columns(layout.EXECUTED, [time], [rr.ComponentColumn(_STRIPS, strips)])
