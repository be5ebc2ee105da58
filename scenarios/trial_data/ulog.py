"""A trial as a ULog file: the estimate, the truth and the measurements as PX4's topics.

PlotJuggler, Flight Review's tools and pyulog then read a simulated flight like a real one. Frames
are PX4's, NED and FRD, so this module converts from ENU and FLU.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from aeroscene.files import replacing
from flightsim.autopilot.events import Severity
from flightsim.frames import euler_rpy_rad, swap_quat_enu_flu_ned_frd
from flightsim.mavlink.logs import ulog
from flightsim.mavlink.logs.ulog import Topic
from scenarios.recording.layout import AXES, BODY_AXES
from scenarios.trial_data.reading import RecordedTrial
from scenarios.trial_data.tables import QUATERNION

_POSITION_FIELDS = tuple(f"float {name}" for name in ("x", "y", "z", "vx", "vy", "vz", "heading"))
_IMU = Topic("sensor_combined", "float[3] gyro_rad", "float[3] accelerometer_m_s2")
_SETPOINT = Topic("trajectory_setpoint", "float[3] position", "float[3] velocity")
_WIND = Topic("wind", "float windspeed_north", "float windspeed_east")
_CONTACT = Topic("vehicle_contact", "bool is_touching")


_FLOW = Topic(
    "sensor_optical_flow",
    *("uint32_t integration_timespan_us", "float[2] pixel_flow", "float[3] delta_angle"),
    *("float distance_m", "uint8_t quality"),
)
_GAUGES = (
    (
        Topic("battery_status", "float voltage_v", "float current_a", "float remaining"),
        ("battery_voltage_v", "battery_current_a", "battery_remaining_percent"),
    ),
    (
        Topic("estimator_status", "float pos_horiz_accuracy", "float pos_vert_accuracy"),
        ("sigma_horizontal_m", "sigma_vertical_m"),
    ),
    (Topic("airspeed", "float indicated_airspeed_m_s"), ("airspeed_mps",)),
    (Topic("distance_sensor", "float current_distance"), ("range_m",)),
)
"""Topics of the table of gauges, with the columns that each one has."""
ULOG_TABLES = frozenset({"trials", "states", "imu", "motors", "optical_flow", "gauges", "events"})
"""Tables that a ULog holds."""


class _Samples(NamedTuple):
    """Rows of a topic."""

    topic: Topic
    time_us: Int[np.ndarray, " n"]
    values: Float[np.ndarray, "n k"]


def write_ulog(trial: RecordedTrial, out: Path) -> Path:
    """Write a trial's states, measurements, commands and texts; a ULog holds `ULOG_TABLES`.

    Args:
        trial: The trial.
        out: File, which is replaced.

    Returns:
        The file.

    Raises:
        TrialDataError: If the recording holds no states.
        OSError: If it cannot be written; nothing is left, and an earlier file is untouched.
    """
    trial.require("states", "imu", "motors", what="ULog")
    samples = list(_samples(trial))
    about = trial.tables["trials"].to_pylist()[0]
    info = {
        "sys_name": "PX4",
        "ver_hw": "AEROSCENE_SITL",
        **{f"aeroscene_{name}": str(about[name]) for name in ("scene", "vehicle", "code")},
    }
    # Readers expect messages in order of time, and topics come one after the other.
    messages = sorted(_messages(samples, trial), key=lambda message: message[0])
    out.parent.mkdir(parents=True, exist_ok=True)
    with replacing(out) as file:
        file.write(ulog.start(messages[0][0], [each.topic for each in samples], info, {}))
        file.writelines(data for _, data in messages)
    return out


def _messages(samples: Sequence[_Samples], trial: RecordedTrial) -> Iterator[tuple[int, bytes]]:
    """Yield time and bytes of every message."""
    for number, (topic, time_us, values) in enumerate(samples):
        for time, row in zip(time_us.tolist(), values.tolist(), strict=True):
            yield time, topic.pack(number, time, *row)
    for event in trial.tables["events"].to_pylist():
        line = event["value"] if event["what"] == "text" else f"{event['what']}: {event['value']}"
        yield event["time_us"], ulog.text(event["time_us"], int(Severity.INFO), line)


def _samples(trial: RecordedTrial) -> Iterator[_Samples]:
    for whose, suffix in (("estimate", ""), ("true", "_groundtruth")):
        yield from _motion(trial, whose, suffix)
    time_us = trial.tables["states"]["time_us"].to_numpy()
    setpoint = np.column_stack(
        [_ned(trial, "position_reference"), _ned(trial, "velocity_reference")]
    )
    yield _known(_SETPOINT, time_us, setpoint)
    yield _Samples(_WIND, time_us, _ned(trial, "wind")[:, :2])
    yield _Samples(_CONTACT, time_us, trial.tables["states"]["is_touching"].to_numpy()[:, None])
    imu = np.column_stack(
        [
            _frd(trial.array("imu", "angular_rate", "radps", BODY_AXES)),
            _frd(trial.array("imu", "acceleration", "mps2", BODY_AXES)),
        ]
    )
    yield _Samples(_IMU, trial.tables["imu"]["time_us"].to_numpy(), imu)
    time_us = trial.tables["motors"]["time_us"].to_numpy()
    numbers = f"float[{len(trial.rotors)}]"
    for topic, prefix in (
        (Topic("actuator_outputs", f"{numbers} output"), "command"),
        (Topic("rotor_speed", f"{numbers} radps"), "speed"),
    ):
        yield _Samples(topic, time_us, trial.array("motors", prefix, "radps", trial.rotors))
    yield from _sensors(trial)


def _sensors(trial: RecordedTrial) -> Iterator[_Samples]:
    """Yield optical flow and gauges, as far as the vehicle has the sensors."""
    flow = trial.tables["optical_flow"]
    if len(flow):
        parts = [flow[name].to_numpy().astype(object) for name in flow.column_names[2:]]
        yield _Samples(_FLOW, flow["time_us"].to_numpy(), np.column_stack(parts))
    gauges = trial.tables["gauges"]
    for topic, columns in _GAUGES:
        values = np.column_stack([gauges[name].to_numpy() for name in columns])
        # PX4 has a share where the table has percent.
        if columns[-1] == "battery_remaining_percent":
            values[:, -1] /= 100.0
        samples = _known(topic, gauges["time_us"].to_numpy(), values)
        if len(samples.time_us):
            yield samples


def _motion(trial: RecordedTrial, whose: str, suffix: str) -> Iterator[_Samples]:
    """Yield position, attitude and rates, from when they are known."""
    time_us = trial.tables["states"]["time_us"].to_numpy()
    quats = trial.array("states", f"attitude_{whose}", "", QUATERNION)
    ned = np.array([swap_quat_enu_flu_ned_frd(tuple(quat)) for quat in quats.tolist()])
    heading_rad = np.array([euler_rpy_rad(tuple(quat))[2] for quat in ned.tolist()])
    position = np.column_stack(
        [_ned(trial, f"position_{whose}"), _ned(trial, f"velocity_{whose}"), heading_rad]
    )
    rates = _frd(trial.array("states", f"angular_rate_{whose}", "radps", BODY_AXES))
    position_topic = Topic(f"vehicle_local_position{suffix}", *_POSITION_FIELDS)
    yield _known(position_topic, time_us, position)
    yield _known(Topic(f"vehicle_attitude{suffix}", "float[4] q"), time_us, ned)
    yield _known(Topic(f"vehicle_angular_velocity{suffix}", "float[3] xyz"), time_us, rates)


def _known(topic: Topic, time_us: np.ndarray, values: np.ndarray) -> _Samples:
    is_known = np.isfinite(values).all(axis=1)
    return _Samples(topic, time_us[is_known], values[is_known])


def _ned(trial: RecordedTrial, prefix: str) -> Float[np.ndarray, "n 3"]:
    unit = "m" if prefix.startswith("position") else "mps"
    # ENU to NED: swap the first two, negate the third.
    return trial.array("states", prefix, unit, AXES)[:, [1, 0, 2]] * (1.0, 1.0, -1.0)


def _frd(values_flu: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    return values_flu * (1.0, -1.0, -1.0)
