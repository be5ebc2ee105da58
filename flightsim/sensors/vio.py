"""Visual-inertial odometry: pose in a frame that begins at the start and drifts with distance.

    m <- m + Rz(-a) (dp - s_p sqrt(|dp|) n),   a <- a + s_a sqrt(|dp|) n

Here dp is the true step between two frames, m the position and a the heading of the frame. Position
and heading each take a random walk over the distance flown, not over time: real odometry barely
drifts in hover. The error grows with the square root of the distance and, because nothing
constrains the heading, with its 3/2nd power on long flights.

The default grade is that of a good filter on the EuRoC flights (Geneva et al. 2020, "OpenVINS: a
research platform for visual-inertial estimation"). On flights of 36 to 130 m, aligned to the truth
in position and heading, the model errs by 0.14 m RMS. OpenVINS with one camera has 0.18 m on the
mean of the eleven flights (github.com/symao/open_vins, ov_msckf_result.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from autonomy.estimation.odometry import fuse_vio
from autonomy.jit import fields, kernel
from autonomy.rotation import yaw_from_quat
from autonomy.types import Vector3
from flightsim.sensors.failure import is_stuck, said
from flightsim.sensors.sensor import Sensor, SensorStart, has_arrived, is_due, noise, numbers


@dataclass(frozen=True, kw_only=True, slots=True)
class VioCfg:
    """Errors of visual-inertial odometry; each pair is horizontal (per axis) and vertical."""

    rate_hz: int = 25
    delay_s: float = 0.04
    """Time from the exposure to the pose; longer ones are cut to one frame."""
    position_walk: tuple[float, float] = (0.025, 0.02)
    """Random walk in m/sqrt(m flown)."""
    yaw_walk: float = 2.1e-3
    """Random walk in rad/sqrt(m flown): 0.12 degrees."""
    position_noise_m: float = 0.01
    """White noise of each axis."""
    yaw_noise_rad: float = 4e-3
    """White noise of the heading."""


class VioReading(NamedTuple):
    """Latest pose; `time_us` is the time of its exposure, 0 before the first."""

    time_us: int
    arrives_us: int
    """Time at which the pose is available to the filter."""
    position_vio_m: Vector3
    """Displacement since the start, along level axes of the vehicle's heading there: forward, left,
    up."""
    yaw_vio_rad: float
    """Change of heading since the start, counterclockwise."""


_numbers = numbers("tick", "delay_ticks", "position_vio_m", "yaw_vio_rad")


def _read(r: np.void, tick_us: int) -> VioReading:
    tick, delay_ticks, position_vio_m, yaw_vio_rad = _numbers(r)
    tick = max(0, tick)
    return VioReading(tick * tick_us, (tick + delay_ticks) * tick_us, position_vio_m, yaw_vio_rad)


def _configure(r: np.void, cfg: VioCfg, start: SensorStart) -> None:
    r["last_position_enu_m"] = start.position_enu_m
    r["frame_yaw_rad"] = yaw_from_quat(np.array(start.quat_wxyz))
    r["walk_enu"][:2], r["walk_enu"][2] = cfg.position_walk
    r["delay_ticks"] = min(round(cfg.delay_s * start.tick_hz), r["period_ticks"])


@kernel
def sample_vio(
    r: np.record, tick: int, position_enu_m: np.ndarray, quat_wxyz: np.ndarray, normals: np.ndarray
) -> None:
    """Measure at a true pose; the reading is valid for use after `delay_ticks`.

    Args:
        r: Record of the sensor, whose drift goes on from its last sample.
        tick: Number of the control tick.
        position_enu_m: True position.
        quat_wxyz: True attitude, FLU to ENU.
        normals: Standard normal numbers of the sensor.
    """
    last, now, m = r.last_position_enu_m, position_enu_m, r.odometer_m
    dx, dy, dz = now[0] - last[0], now[1] - last[1], now[2] - last[2]
    # Fourth root of the squared distance: the walk is in m/sqrt(m flown).
    root = math.sqrt(math.sqrt(dx * dx + dy * dy + dz * dz))
    dx -= r.walk_enu[0] * root * normals[0]
    dy -= r.walk_enu[1] * root * normals[1]
    dz -= r.walk_enu[2] * root * normals[2]
    c, s = math.cos(r.frame_yaw_rad), math.sin(r.frame_yaw_rad)
    m[0] += c * dx + s * dy
    m[1] += c * dy - s * dx
    m[2] += dz
    r.frame_yaw_rad += r.yaw_walk * root * normals[3]
    for i in range(3):
        last[i] = now[i]
        measured = m[i] + r.position_noise_m * normals[4 + i]
        r.position_vio_m[i] = said(r, 0, tick, i, measured, normals)
    yaw = yaw_from_quat(quat_wxyz) - r.frame_yaw_rad
    r.yaw_vio_rad = said(r, 0, tick, 3, yaw + r.yaw_noise_rad * normals[7], normals)
    r.tick = tick


@kernel
def sense_vio(r: np.record, f: np.record, tick: int, qpos: np.ndarray, normals: np.ndarray) -> None:
    """Fuse the pose that arrives at this tick, then take the next one.

    Args:
        r: Record of the sensor.
        f: Record of the filter.
        tick: Number of the control tick.
        qpos: True pose of the vehicle, (7,).
        normals: Standard normal numbers of the sensor.
    """
    # Fuse before sampling: the next sample overwrites the one that arrives at this tick.
    has_come = has_arrived(r, tick) and not is_stuck(r, 0, r.position_vio_m[0])
    if has_come and f.is_aligned == 1:
        fuse_vio(f, r.position_vio_m, r.yaw_vio_rad, r.delay_ticks)
    if is_due(r, tick):
        sample_vio(r, tick, qpos[0:3], qpos[3:7], noise(r, tick, normals))


VIO = Sensor(
    name="vio",
    setting="vio",
    fields=(
        ("odometer_m", "f8", 3),  # position without its white noise
        *fields("position_vio_m", "last_position_enu_m", "walk_enu", shape=(3,)),
        *fields("yaw_vio_rad", "frame_yaw_rad", "yaw_walk", "position_noise_m", "yaw_noise_rad"),
        ("delay_ticks", "i8"),
    ),
    n_normals=8,
    stream=7,
    configure=_configure,
    read=_read,
    wrong=(5.0, 5.0, 2.0, 0.5),
    garbage=(50.0, 50.0, 50.0, 2.0),
)
