"""Motion capture: pose of the vehicle in the world by cameras of the room, white noise, late."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autonomy.jit import kernel
from autonomy.rotation import yaw_from_quat

MOCAP_NORMALS = 4


@dataclass(frozen=True, kw_only=True, slots=True)
class MocapCfg:
    """Errors of a motion capture system, Vicon or OptiTrack grade.

    0.15 mm at rest, less than 2 mm in motion: Merriaux et al. 2017, "A study of Vicon system
    positioning performance", abstract.
    """

    rate_hz: int = 125
    delay_s: float = 0.008
    """From the exposure to the pose; at most one frame."""
    position_noise_m: float = 1e-3
    """Each axis."""
    yaw_noise_rad: float = 3e-3
    """Markers 0.2 m apart, each wrong by half a millimetre."""


MOCAP_DTYPE = np.dtype(
    [
        ("position_enu_m", "f8", 3),
        ("yaw_rad", "f8"),
        ("tick", "i8"),  # of validity of the last pose, -1 before the first
        ("position_noise_m", "f8"),
        ("yaw_noise_rad", "f8"),
        ("delay_ticks", "i8"),
        ("period_ticks", "i8"),
        ("is_enabled", "i8"),
    ],
    align=True,
)


def new_mocap(cfg: MocapCfg, *, tick_hz: int) -> np.ndarray:
    """A system before its first pose, in an array of shape (1,)."""
    records = np.zeros(1, MOCAP_DTYPE)
    r = records[0]
    r["position_noise_m"] = cfg.position_noise_m
    r["yaw_noise_rad"] = cfg.yaw_noise_rad
    r["period_ticks"] = tick_hz // cfg.rate_hz
    r["delay_ticks"] = min(round(cfg.delay_s * tick_hz), r["period_ticks"])
    r["is_enabled"] = 1
    r["tick"] = -1
    return records


@kernel
def sample_mocap(
    r: np.record, tick: int, position_enu_m: np.ndarray, quat_wxyz: np.ndarray, normals: np.ndarray
) -> None:
    """Measure at a true pose; who reads it must wait `delay_ticks`."""
    for i in range(3):
        r.position_enu_m[i] = position_enu_m[i] + r.position_noise_m * normals[i]
    r.yaw_rad = yaw_from_quat(quat_wxyz) + r.yaw_noise_rad * normals[3]
    r.tick = tick
