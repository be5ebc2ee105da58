"""Satellite navigation receiver: late, at a low rate, with an error that wanders.

The position error is a first-order Gauss-Markov process plus white noise; velocity has white
noise. A fix is delivered `delay_s` after the time for which it is valid. In a room there is no
fix; back under the sky the first one comes after `reacquire_s`, and its additional error decays.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autonomy.estimation.alignment import collect_fix
from autonomy.estimation.fusion import fuse_gnss
from autonomy.jit import fields, kernel
from autonomy.types import Vector3
from flightsim.environment.rooms import is_in_room
from flightsim.sensors.drift import advance_drift, density_of, drift_terms
from flightsim.sensors.sensor import Sensor, SensorStart, is_due, noise, numbers

N_GNSS_PAST = 64
"""IMU ticks that the receiver remembers; the longest delay."""


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
    """Accuracy that the receiver claims: eph and epv."""
    reacquire_s: float = 1.0
    """Time from leaving a room to the first fix; hot start and reacquisition of a u-blox F9 or M10
    take 1 to 2 s by their data sheets."""
    reacquired_sigma_m: float = 1.5
    """Additional white error of the first fix."""
    settle_s: float = 1.5
    """Time in which that error falls to 1/e: below 1 cm after 8 s; the F9 has RTK fixed by its data
    sheet in less than 10 s."""


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


def _configure(r: np.void, cfg: GnssCfg, start: SensorStart) -> None:
    """Switch on a receiver that has tracked satellites for long."""
    horizontal, vertical = cfg.drift_sigma_m
    stationary = np.array([horizontal, horizontal, vertical])
    r["drift_enu_m"] = stationary * start.rng.standard_normal(3)
    for i in range(3):
        density = density_of(stationary[i], cfg.drift_correlation_s)
        terms = drift_terms(density, cfg.drift_correlation_s, 1.0 / cfg.rate_hz)
        r["decay"], r["drift_step_sigma_m"][i] = terms
    (r["position_sigma_m"][:2], r["position_sigma_m"][2]) = cfg.position_noise_m
    (r["velocity_sigma_mps"][:2], r["velocity_sigma_mps"][2]) = cfg.velocity_noise_mps
    r["delay_ticks"] = round(cfg.delay_s * start.tick_hz)
    r["reacquire_ticks"] = round(cfg.reacquire_s * start.tick_hz)
    r["settle_decay"] = math.exp(-1.0 / (cfg.settle_s * cfg.rate_hz))
    r["under_sky_ticks"] = r["reacquire_ticks"]


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
    advance_drift(r.drift_enu_m, r.decay, r.drift_step_sigma_m, normals, 0)
    for i in range(3):
        r.present_sigma_m[i] = math.hypot(r.position_sigma_m[i], r.settling_sigma_m)
        noise = r.present_sigma_m[i] * normals[3 + i]
        r.position_enu_m[i] = r.past_position_enu_m[slot, i] + r.drift_enu_m[i] + noise
        noise = r.velocity_sigma_mps[i] * normals[6 + i]
        r.velocity_enu_mps[i] = r.past_velocity_enu_mps[slot, i] + noise


@kernel
def sense_gnss(
    r: np.record,
    f: np.record,
    tick: int,
    qpos: np.ndarray,
    qvel: np.ndarray,
    rooms: np.ndarray,
    normals: np.ndarray,
) -> None:
    """Follow the vehicle, and let the filter use the fix if one is due."""
    follow_gnss(r, tick, qpos[0:3], qvel[0:3])
    if not is_due(r, tick) or tick <= r.delay_ticks or not hears_satellites(r, rooms, qpos[0:3]):
        return
    sample_gnss(r, tick, noise(r, tick, normals))
    if f.is_aligned == 1:
        fuse_gnss(
            f,
            r.position_enu_m,
            r.velocity_enu_mps,
            r.delay_ticks,
            r.present_sigma_m,
            r.velocity_sigma_mps,
        )
    else:
        collect_fix(f, r.position_enu_m, r.present_sigma_m)


@dataclass(frozen=True, kw_only=True, slots=True)
class GnssReading:
    """Latest fix; `time_us` is the time for which it is valid, 0 before the first."""

    time_us: int
    position_enu_m: Vector3
    velocity_enu_mps: Vector3
    fix_type: int
    """MAVLink's GPS_FIX_TYPE; 0 or 1 before the first fix or without signal."""
    eph_m: float
    epv_m: float
    n_satellites: int


_numbers = numbers(
    *("tick", "position_enu_m", "velocity_enu_mps", "fix_type", "n_satellites"),
    *("reported_accuracy_m", "settling_sigma_m"),
    *("is_enabled", "under_sky_ticks", "reacquire_ticks"),
)


def _read(r: np.void, tick_us: int) -> GnssReading:
    tick, position, velocity, fix_type, n_satellites, accuracy, settling, *heard = _numbers(r)
    is_enabled, under_sky_ticks, reacquire_ticks = heard
    is_fixed = is_enabled == 1 and under_sky_ticks >= reacquire_ticks and tick >= 0
    return GnssReading(
        time_us=max(0, tick) * tick_us,
        position_enu_m=position,
        velocity_enu_mps=velocity,
        fix_type=fix_type if is_fixed else 1,
        eph_m=math.hypot(accuracy[0], settling) if is_fixed else math.inf,
        epv_m=math.hypot(accuracy[1], settling) if is_fixed else math.inf,
        n_satellites=n_satellites if is_fixed else 0,
    )


GNSS = Sensor(
    name="gnss",
    setting="gnss",
    grades=GRADES,
    fields=(
        *fields("position_enu_m", "velocity_enu_mps", "drift_enu_m", shape=(3,)),
        *fields("drift_step_sigma_m", "position_sigma_m", "velocity_sigma_mps", shape=(3,)),
        ("present_sigma_m", "f8", 3),  # white error of the last fix
        ("settle_decay", "f8"),  # from one fix to the next
        ("settling_sigma_m", "f8"),  # its additional error now
        ("under_sky_ticks", "i8"),  # since the last room
        *fields("decay", "reacquired_sigma_m"),
        *fields("reacquire_ticks", "delay_ticks", "fix_type", "n_satellites", kind="i8"),
        ("reported_accuracy_m", "f8", 2),
        *fields("past_position_enu_m", "past_velocity_enu_mps", shape=(N_GNSS_PAST, 3)),
    ),
    n_normals=9,
    stream=3,
    start_stream=1,
    configure=_configure,
    read=_read,
)
