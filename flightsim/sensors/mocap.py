"""Motion capture: pose of the vehicle in the world from cameras in the room.

It has white noise and a delay, but no drift: the cameras see the vehicle from fixed places. Use it
to fly indoors with a known position, or to take the estimator's drift out of an experiment.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autonomy.estimation.motion_capture import fuse_mocap
from autonomy.jit import fields, kernel
from autonomy.rotation import yaw_from_quat
from flightsim.sensors.failure import is_stuck, said
from flightsim.sensors.sensor import Sensor, SensorStart, has_arrived, is_due, noise


@dataclass(frozen=True, kw_only=True, slots=True)
class MocapCfg:
    """Errors of a motion capture system, Vicon or OptiTrack grade.

    0.15 mm at rest, less than 2 mm in motion: Merriaux et al. 2017, "A study of Vicon system
    positioning performance", abstract.
    """

    rate_hz: int = 125
    delay_s: float = 0.008
    """Time from the exposure to the pose; longer ones are cut to one frame."""
    position_noise_m: float = 1e-3
    """White noise of each axis."""
    yaw_noise_rad: float = 3e-3
    """White noise of heading, as from markers 0.2 m apart with errors of half a millimetre."""


def _configure(r: np.void, cfg: MocapCfg, start: SensorStart) -> None:
    r["delay_ticks"] = min(round(cfg.delay_s * start.tick_hz), r["period_ticks"])


@kernel
def sample_mocap(
    r: np.record, tick: int, position_enu_m: np.ndarray, quat_wxyz: np.ndarray, normals: np.ndarray
) -> None:
    """Measure at a true pose; the reading is valid for use after `delay_ticks`.

    Args:
        r: Record of the sensor, which takes the sample.
        tick: Number of the control tick.
        position_enu_m: True position.
        quat_wxyz: True attitude, FLU to ENU.
        normals: Standard normal numbers; the first four are used.
    """
    for i in range(3):
        measured = position_enu_m[i] + r.position_noise_m * normals[i]
        r.position_enu_m[i] = said(r, 0, tick, i, measured, normals)
    yaw = yaw_from_quat(quat_wxyz) + r.yaw_noise_rad * normals[3]
    r.yaw_rad = said(r, 0, tick, 3, yaw, normals)
    r.tick = tick


@kernel
def sense_mocap(
    r: np.record, f: np.record, tick: int, qpos: np.ndarray, normals: np.ndarray
) -> None:
    """Fuse the pose that arrives at this tick, then take the next one.

    Args:
        r: Record of the sensor.
        f: Record of the filter.
        tick: Number of the control tick.
        qpos: True pose of the vehicle, (7,).
        normals: Standard normal numbers of the sensor.
    """
    # Fuse before sampling: the next sample overwrites the one that arrives at this tick.
    has_come = has_arrived(r, tick) and not is_stuck(r, 0, r.position_enu_m[0])
    if has_come and f.is_aligned == 1:
        fuse_mocap(f, r.position_enu_m, r.yaw_rad, r.delay_ticks)
    if is_due(r, tick):
        sample_mocap(r, tick, qpos[0:3], qpos[3:7], noise(r, tick, normals))


MOCAP = Sensor(
    name="mocap",
    setting="mocap",
    fields=(
        ("position_enu_m", "f8", 3),
        *fields("yaw_rad", "position_noise_m", "yaw_noise_rad"),
        ("delay_ticks", "i8"),
    ),
    n_normals=4,
    stream=8,
    configure=_configure,
    wrong=(2.0, 2.0, 1.0, 0.5),
    garbage=(20.0, 20.0, 20.0, 2.0),
)
