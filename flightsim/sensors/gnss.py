"""Satellite navigation receiver: late, at a low rate, with an error that wanders.

A filter that sees only white noise becomes far too confident in its position, so the errors that
dominate a real receiver are modelled one by one:

- The position error is a first-order Gauss-Markov process plus white noise; velocity has white
  noise.
- A fix is delivered `delay_s` after the time for which it is valid.
- In a room, or with fewer than four satellites in view (`flightsim.plant.sky`), there is no fix.
  Back under the sky the first one comes after `reacquire_s`, and its additional error decays.
- All errors of position and velocity grow with the dilution of precision.
- With few satellites a receiver with corrections cannot resolve the ambiguities of the carrier
  phase. Its solution is then a "float" solution of decimetres.
- Solids that hide satellites nearby reflect others. This multipath wanders over seconds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autonomy.estimation.alignment import collect_fix
from autonomy.estimation.fusion import fuse_gnss
from autonomy.jit import fields, kernel
from flightsim.environment.constellation import (
    BEIDOU,
    GALILEO,
    GPS,
    LEAST_SATELLITES,
    Constellation,
)
from flightsim.environment.rooms import is_in_room
from flightsim.sensors.drift import advance_drift, density_of, drift_terms
from flightsim.sensors.failure import is_stuck, said
from flightsim.sensors.gnss_reading import read_gnss
from flightsim.sensors.sensor import Sensor, SensorStart, is_due, noise

_MULTIPATH_S = 5.0
"""Correlation time of multipath for a receiver that flies past walls."""
N_GNSS_PAST = 64
"""Number of past IMU ticks that the receiver remembers, which limits `delay_s`."""


@dataclass(frozen=True, kw_only=True, slots=True)
class GnssCfg:
    """Errors of a receiver; each pair is horizontal (per axis) and vertical."""

    rate_hz: int
    delay_s: float = 0.12
    fix_type: int
    """3 is a 3D fix, 6 is RTK fixed, as in MAVLink's GPS_FIX_TYPE."""
    drift_sigma_m: tuple[float, float]
    """Stationary standard deviation of the wandering position error."""
    drift_correlation_s: float = 60.0
    position_noise_m: tuple[float, float]
    velocity_noise_mps: tuple[float, float]
    reported_accuracy_m: tuple[float, float]
    """Accuracy that the receiver claims with a good sky: eph and epv."""
    reacquire_s: float = 1.0
    """Time from leaving a room to the first fix; hot start and reacquisition of a u-blox F9 or M10
    take 1 to 2 s by their data sheets."""
    reacquired_sigma_m: float = 1.5
    """Additional white error of the first fix."""
    constellations: tuple[Constellation, ...] = (GPS, GALILEO)
    """Satellite systems that the receiver listens to."""
    least_fixed: int = 0
    """Below this number of satellites the solution is "float": corrections bring decimetres, not
    centimetres."""
    float_sigma_m: float = 0.0
    """White error of each axis of a float solution."""
    most_step_m: float = 0.03
    """Largest step by which one fix should move an estimate that odometry carries, each axis."""
    multipath_sigma_m: float = 0.0
    """Standard deviation of multipath if nearby solids hide half of the sky."""
    settle_s: float = 1.5
    """Time in which the error of a new fix falls to 1/e. It is below 1 cm after 8 s; the data sheet
    of the F9 promises an RTK fix in less than 10 s."""


RTK = GnssCfg(
    rate_hz=10,
    fix_type=6,
    drift_sigma_m=(0.03, 0.05),
    position_noise_m=(0.01, 0.02),
    velocity_noise_mps=(0.05, 0.08),
    reported_accuracy_m=(0.05, 0.08),
    constellations=(GPS, GALILEO, BEIDOU),
    # u-blox F9 integration manual: float is decimetres; ambiguities want some redundancy.
    least_fixed=8,
    float_sigma_m=0.3,
    # A quarter of the 19 cm of the L1 carrier at most; half of that, as reflections are weaker.
    multipath_sigma_m=0.024,
)
"""Receiver with corrections, of decimetre grade because its antenna swings below a frame."""

STANDARD = GnssCfg(
    rate_hz=5,
    fix_type=3,
    # u-blox M10 data sheet: 1.5 m CEP, which is 1.3 m along each axis. PX4's gazebo-classic
    # receiver wanders by 2.2 m and 4.4 m, and 0.2 m from one fix to the next.
    drift_sigma_m=(1.3, 2.2),
    # PX4: 2e-4 and 4e-4 m/sqrt(Hz), 0.2 and 0.4 m/s
    position_noise_m=(2e-4 * math.sqrt(5.0), 4e-4 * math.sqrt(5.0)),
    velocity_noise_mps=(0.2, 0.4),
    reported_accuracy_m=(1.3, 2.2),
    # At 5 Hz this is 2.5 cm/s, as much as odometry drifts at 1 m/s. A place that odometry or a map
    # knows well then stays known for seconds, while the receiver wanders by a metre in a minute.
    most_step_m=0.005,
    # Code multipath between buildings is some metres (Kaplan and Hegarty 2017, section 9.5).
    multipath_sigma_m=3.0,
)
"""Receiver without corrections, of metre grade."""

GRADES = {"rtk": RTK, "standard": STANDARD}


def _configure(r: np.void, cfg: GnssCfg, start: SensorStart) -> None:
    """Fill the record of a receiver that has tracked satellites for a long time."""
    horizontal, vertical = cfg.drift_sigma_m
    stationary = np.array([horizontal, horizontal, vertical])
    # The process starts in its stationary distribution, as if the receiver had long been on.
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
    # The vehicle starts with a fix, unless the first tick finds it in a room.
    r["under_sky_ticks"] = r["reacquire_ticks"]
    dt_s = 1.0 / cfg.rate_hz
    r["multipath_decay"] = math.exp(-dt_s / _MULTIPATH_S)
    # Samples of a process with correlation time T share their error for about 2 T: so many samples
    # count as one independent sample.
    r["multipath_samples"] = 2.0 * _MULTIPATH_S * cfg.rate_hz
    r["dilution"] = 1.0


@kernel
def follow_gnss(
    r: np.record, tick: int, position_enu_m: np.ndarray, velocity_enu_mps: np.ndarray
) -> None:
    """Store the true state of an IMU tick, from which a later fix is made; called at every tick.

    Args:
        r: Record of the receiver.
        tick: Number of the control tick, which is the IMU's.
        position_enu_m: True position.
        velocity_enu_mps: True velocity.
    """
    r.under_sky_ticks += 1
    slot = tick % N_GNSS_PAST
    for i in range(3):
        r.past_position_enu_m[slot, i] = position_enu_m[i]
        r.past_velocity_enu_mps[slot, i] = velocity_enu_mps[i]


@kernel
def hears_satellites(
    r: np.record, sky: np.record, rooms: np.ndarray, position_enu_m: np.ndarray
) -> bool:
    """Return true if the receiver has a fix at a true position.

    Losing the sky restarts the wait of `reacquire_s` and the extra error of the first fix.

    Args:
        r: Record of the receiver; changed while it has no sky.
        sky: Satellites in view (`flightsim.plant.sky`).
        rooms: Rooms of the scene, a row each (`ROOM_COLUMNS`).
        position_enu_m: True position, shape (3,).
    """
    if is_in_room(rooms, position_enu_m) or sky.n_heard < LEAST_SATELLITES:
        r.under_sky_ticks = 0
        r.settling_sigma_m = r.reacquired_sigma_m
    return r.under_sky_ticks >= r.reacquire_ticks


@kernel
def suffer_sky(r: np.record, sky: np.record, normals: np.ndarray) -> None:
    """Compute dilution, float state and multipath of the next fix from the satellites in view.

    Args:
        r: Record of the receiver.
        sky: Record of the satellites in view.
        normals: Standard normal numbers; those from 9 to 11 are used.
    """
    r.n_heard = sky.n_heard
    r.is_float = 1 if sky.n_heard < r.least_fixed else 0
    r.dilution[0], r.dilution[1], r.dilution[2] = sky.horizontal, sky.horizontal, sky.vertical
    decay = r.multipath_decay
    # `multipath_sigma_m` is stated for half of the sky hidden, hence the factor two.
    sigma = 2.0 * r.multipath_sigma_m * sky.near_share * sky.has_multipath
    for i in range(3):
        # A process of unit variance, scaled afterwards: the share of hidden sky changes in flight.
        step = math.sqrt(1.0 - decay * decay) * normals[9 + i]
        r.multipath[i] = decay * r.multipath[i] + step
        r.multipath_enu_m[i] = sigma * r.dilution[i] * r.multipath[i]
        r.multipath_now_sigma_m[i] = sigma * r.dilution[i]


@kernel
def sample_gnss(r: np.record, tick: int, normals: np.ndarray) -> None:
    """Deliver the fix that is valid for `delay_ticks` before this tick.

    Args:
        r: Record of the receiver.
        tick: Number of the control tick at which the fix arrives.
        normals: Standard normal numbers; the first nine are used.
    """
    ambiguous = r.float_sigma_m * r.is_float
    r.tick = tick - r.delay_ticks
    r.settling_sigma_m *= r.settle_decay
    slot = r.tick % N_GNSS_PAST
    advance_drift(r.drift_enu_m, r.decay, r.drift_step_sigma_m, normals, 0)
    for i in range(3):
        white = math.hypot(r.position_sigma_m[i], ambiguous) * r.dilution[i]
        white = math.hypot(white, r.settling_sigma_m)
        slow = r.dilution[i] * r.drift_enu_m[i] + r.multipath_enu_m[i]
        noise = white * normals[3 + i]
        position = r.past_position_enu_m[slot, i] + slow + noise
        r.position_enu_m[i] = said(r, 0, tick, i, position, normals)
        r.present_velocity_sigma_mps[i] = r.dilution[i] * r.velocity_sigma_mps[i]
        noise = r.present_velocity_sigma_mps[i] * normals[6 + i]
        velocity = r.past_velocity_enu_mps[slot, i] + noise
        r.velocity_enu_mps[i] = said(r, 0, tick, 3 + i, velocity, normals)
        # The filter takes errors of successive fixes as independent. Errors that fixes share are
        # thus inflated by the number of samples that share them: multipath in full, drift only by
        # the part beyond the filter's own model of it.
        shared = r.multipath_samples * r.multipath_now_sigma_m[i] ** 2
        beyond = (r.dilution[i] * r.dilution[i] - 1.0) * r.drift_sigma_m[0 if i < 2 else 1] ** 2
        r.present_sigma_m[i] = math.sqrt(white * white + shared + r.multipath_samples * beyond)


@kernel
def sense_gnss(
    r: np.record,
    f: np.record,
    tick: int,
    qpos: np.ndarray,
    qvel: np.ndarray,
    sky: np.record,
    rooms: np.ndarray,
    normals: np.ndarray,
) -> None:
    """Follow the vehicle, and if a fix is due, deliver it to the filter.

    Args:
        r: Record of the receiver; changed.
        f: Record of the filter; changed by a fix.
        tick: Present tick.
        qpos: True pose: position ENU and attitude, shape (7,).
        qvel: True velocity ENU and angular rate, shape (6,).
        sky: Satellites in view.
        rooms: Rooms of the scene.
        normals: Standard normals of this second.
    """
    follow_gnss(r, tick, qpos[0:3], qvel[0:3])
    # Before `delay_ticks` have passed, the ring holds no state of that time yet.
    if not is_due(r, tick) or tick <= r.delay_ticks:
        return
    if not hears_satellites(r, sky, rooms, qpos[0:3]):
        return
    drawn = noise(r, tick, normals)
    suffer_sky(r, sky, drawn)
    sample_gnss(r, tick, drawn)
    if is_stuck(r, 0, r.position_enu_m[0]):
        return
    if f.is_aligned == 1:
        fuse_gnss(
            f,
            r.position_enu_m,
            r.velocity_enu_mps,
            r.delay_ticks,
            r.present_sigma_m,
            r.present_velocity_sigma_mps,
        )
    else:
        collect_fix(f, r.position_enu_m, r.present_sigma_m)


GNSS = Sensor(
    name="gnss",
    setting="gnss",
    grades=GRADES,
    fields=(
        *fields("position_enu_m", "velocity_enu_mps", "drift_enu_m", shape=(3,)),
        *fields("drift_step_sigma_m", "position_sigma_m", "velocity_sigma_mps", shape=(3,)),
        ("present_sigma_m", "f8", 3),  # of the last fix, as if all its errors were white
        *fields("present_velocity_sigma_mps", "dilution", "multipath", shape=(3,)),
        *fields("multipath_enu_m", "multipath_now_sigma_m", shape=(3,)),
        *fields("multipath_sigma_m", "multipath_decay", "multipath_samples", "float_sigma_m"),
        *fields("n_heard", "least_fixed", "is_float", kind="i8"),
        ("drift_sigma_m", "f8", 2),
        ("settle_decay", "f8"),  # from one fix to the next
        ("settling_sigma_m", "f8"),  # its additional error now
        ("under_sky_ticks", "i8"),  # since the last room
        *fields("decay", "reacquired_sigma_m"),
        *fields("reacquire_ticks", "delay_ticks", "fix_type", kind="i8"),
        ("reported_accuracy_m", "f8", 2),
        *fields("past_position_enu_m", "past_velocity_enu_mps", shape=(N_GNSS_PAST, 3)),
    ),
    n_normals=12,
    stream=3,
    start_stream=1,
    configure=_configure,
    wrong=(30.0, 20.0, 10.0),
    garbage=(1e3, 1e3, 1e3, 20.0, 20.0, 20.0),
    read=read_gnss,
)
