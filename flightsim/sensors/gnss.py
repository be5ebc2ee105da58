"""Satellite navigation receiver: late, at a low rate, with an error that wanders.

The position error is a first-order Gauss-Markov process plus white noise; velocity has white
noise. A fix is delivered `delay_s` after the time for which it is valid. In a room there is no
fix; back under the sky the first one comes after `reacquire_s`, and its extra error decays.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autonomy.jit import kernel
from flightsim.environment.rooms import is_in_room
from flightsim.sensors.drift import advance_drift, density_of, drift_terms

N_GNSS_PAST = 64
"""IMU ticks that the receiver remembers; the longest delay."""

GNSS_NORMALS = 9


@dataclass(frozen=True, kw_only=True, slots=True)
class GnssCfg:
    """Errors of a receiver; pairs are horizontal (each axis) and vertical."""

    rate_hz: int
    delay_s: float = 0.12
    fix_type: int
    """3 is a 3D fix, 6 is RTK fixed, as in MAVLink's GPS_FIX_TYPE."""
    n_satellites: int
    drift_sigma_m: tuple[float, float]
    """Stationary standard deviation of the wandering position error."""
    drift_correlation_s: float = 60.0
    position_noise_m: tuple[float, float]
    velocity_noise_mps: tuple[float, float]
    reported_accuracy_m: tuple[float, float]
    """What the receiver says of itself: eph and epv."""
    reacquire_s: float = 1.0
    """Under the sky again until the first fix; hot start and reacquisition of a u-blox F9 or M10
    take 1 to 2 s by their data sheets."""
    reacquired_sigma_m: float = 1.5
    """Extra white error of the first fix."""
    settle_s: float = 1.5
    """In which the extra error falls to 1/e: below 1 cm after 8 s, where the F9's data sheet has
    RTK fixed in less than 10 s."""


RTK = GnssCfg(
    rate_hz=10,
    fix_type=6,
    n_satellites=18,
    drift_sigma_m=(0.03, 0.05),
    position_noise_m=(0.01, 0.02),
    velocity_noise_mps=(0.05, 0.08),
    reported_accuracy_m=(0.05, 0.08),
)
"""A receiver with corrections whose antenna swings below a frame: decimetre grade."""

STANDARD = GnssCfg(
    rate_hz=5,
    fix_type=3,
    n_satellites=10,
    # u-blox M10 data sheet: 1.5 m CEP, which is 1.3 m along each axis. PX4's gazebo-classic
    # receiver wanders by 2.2 m and 4.4 m, and 0.2 m from one fix to the next.
    drift_sigma_m=(1.3, 2.2),
    # PX4: 2e-4 and 4e-4 m/sqrt(Hz), 0.2 and 0.4 m/s
    position_noise_m=(2e-4 * math.sqrt(5.0), 4e-4 * math.sqrt(5.0)),
    velocity_noise_mps=(0.2, 0.4),
    reported_accuracy_m=(1.3, 2.2),
)
"""A receiver without corrections: metre grade."""

GRADES = {"rtk": RTK, "standard": STANDARD}

GNSS_DTYPE = np.dtype(
    [
        ("position_enu_m", "f8", 3),
        ("velocity_enu_mps", "f8", 3),
        ("tick", "i8"),  # of validity of the last fix, -1 before the first
        ("drift_enu_m", "f8", 3),
        ("decay", "f8"),
        ("drift_sigma_m", "f8", 3),
        ("position_sigma_m", "f8", 3),
        ("velocity_sigma_mps", "f8", 3),
        ("present_sigma_m", "f8", 3),  # white error of the last fix
        ("reacquire_ticks", "i8"),
        ("reacquired_sigma_m", "f8"),
        ("settle_decay", "f8"),  # from one fix to the next
        ("settling_sigma_m", "f8"),  # extra error just now
        ("under_sky_ticks", "i8"),  # since the last room
        ("delay_ticks", "i8"),
        ("period_ticks", "i8"),
        ("is_enabled", "i8"),
        ("past_position_enu_m", "f8", (N_GNSS_PAST, 3)),
        ("past_velocity_enu_mps", "f8", (N_GNSS_PAST, 3)),
    ],
    align=True,
)


def new_gnss(cfg: GnssCfg, rng: np.random.Generator, *, tick_hz: int) -> np.ndarray:
    """A receiver that has tracked for long, in an array of shape (1,)."""
    records = np.zeros(1, GNSS_DTYPE)
    r = records[0]
    horizontal, vertical = cfg.drift_sigma_m
    stationary = np.array([horizontal, horizontal, vertical])
    r["drift_enu_m"] = stationary * rng.standard_normal(3)
    for i in range(3):
        density = density_of(stationary[i], cfg.drift_correlation_s)
        r["decay"], r["drift_sigma_m"][i] = drift_terms(
            density, cfg.drift_correlation_s, 1.0 / cfg.rate_hz
        )
    for name, pair in (
        ("position_sigma_m", cfg.position_noise_m),
        ("velocity_sigma_mps", cfg.velocity_noise_mps),
    ):
        r[name] = (pair[0], pair[0], pair[1])
    r["delay_ticks"] = round(cfg.delay_s * tick_hz)
    r["period_ticks"] = tick_hz // cfg.rate_hz
    r["reacquire_ticks"] = round(cfg.reacquire_s * tick_hz)
    r["reacquired_sigma_m"] = cfg.reacquired_sigma_m
    r["settle_decay"] = math.exp(-1.0 / (cfg.settle_s * cfg.rate_hz))
    r["under_sky_ticks"] = r["reacquire_ticks"]
    r["is_enabled"] = 1
    r["tick"] = -1
    return records


@kernel
def follow_gnss(
    r: np.record, tick: int, position_enu_m: np.ndarray, velocity_enu_mps: np.ndarray
) -> None:
    """Let the receiver see the true state of an IMU tick."""
    r.under_sky_ticks += 1
    slot = tick % N_GNSS_PAST
    for i in range(3):
        r.past_position_enu_m[slot, i] = position_enu_m[i]
        r.past_velocity_enu_mps[slot, i] = velocity_enu_mps[i]


@kernel
def hears_satellites(r: np.record, rooms: np.ndarray, position_enu_m: np.ndarray) -> bool:
    """Whether there is a fix at a true position, outside of all `rooms` (`ROOM_COLUMNS`)."""
    if is_in_room(rooms, position_enu_m):
        r.under_sky_ticks = 0
        r.settling_sigma_m = r.reacquired_sigma_m
    return r.under_sky_ticks >= r.reacquire_ticks


@kernel
def sample_gnss(r: np.record, tick: int, normals: np.ndarray) -> None:
    """Deliver at `tick` the fix that is valid for `delay_ticks` before it."""
    r.tick = tick - r.delay_ticks
    r.settling_sigma_m *= r.settle_decay
    slot = r.tick % N_GNSS_PAST
    advance_drift(r.drift_enu_m, r.decay, r.drift_sigma_m, normals, 0)
    for i in range(3):
        r.present_sigma_m[i] = math.hypot(r.position_sigma_m[i], r.settling_sigma_m)
        noise = r.present_sigma_m[i] * normals[3 + i]
        r.position_enu_m[i] = r.past_position_enu_m[slot, i] + r.drift_enu_m[i] + noise
        noise = r.velocity_sigma_mps[i] * normals[6 + i]
        r.velocity_enu_mps[i] = r.past_velocity_enu_mps[slot, i] + noise
