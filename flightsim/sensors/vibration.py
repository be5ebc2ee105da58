"""Vibration from the rotors, as an IMU that averages over its interval sees it.

    symbol   name                                       unit
    w, a     speed and angle of a rotor                 rad/s, rad
    U        imbalance                                  kg m
    e        ripple of thrust at the blades' passage
    T        thrust, kf w^2                             N

    force of a rotor  U w^2 (cos a, sin a) in its plane, e T sin 2a along its axis, at its hub
    mean of cos a     (sin a_1 - sin a_0) / (a_1 - a_0) over an interval of steady speed

Once and twice the rotor speed lie near and above half of the IMU's rate. White noise cannot stand
in for them. The mean over an interval weakens them by sin(x) / x, and the rest shows at an alias:
for an Iris in hover, 128 Hz appears at 122 Hz, and 256 Hz at 6 Hz of 250 Hz. The integrals below
have closed forms, so no faster simulation is needed.

The vehicle is rigid. It vibrates about its mean motion, which the physics engine computes without
vibration.

Sources: ISO 21940-11, balance quality: 1.2 g mm in 30 g of rotor and bell at 800 rad/s is G 32,
where a car's wheels have G 40. The accelerations, some 0.7 m/s^2 RMS in hover, lie within the 3
m/s^2 that ArduPilot's manual ("Measuring vibration") asks for.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import fields, kernel
from autonomy.model.quadrotor import MAX_ROTORS
from flightsim.vehicles.airframe import Airframe

_RIPPLE = 0.05
"""Amplitude e of the thrust ripple as a share of the thrust."""
_N_BLADES = 2
_LEAST_TURN_RAD = 0.05
"""Rotors that turn less than this in an interval are taken as still. It also keeps the divisions by
the turn well conditioned."""

VIBRATION_DTYPE = np.dtype(
    [
        ("is_on", "i8"),
        *fields("dt_s", "mass_kg"),
        ("n_rotors", "i8"),
        *fields("angle_rad", "sine", "cosine", "imbalance_kgm", "ripple_n", shape=(MAX_ROTORS,)),
        ("hub_flu_m", "f8", (MAX_ROTORS, 3)),
        *fields("inertia_flu_kgm2", "accel_flu_mps2", "gyro_flu_radps", shape=(3,)),
    ],
    align=True,
)


def new_vibration(
    airframe: Airframe, rng: np.random.Generator, *, dt_s: float, is_on: bool
) -> np.ndarray:
    """Return rotors with random imbalances and angles, (1,) of `VIBRATION_DTYPE`.

    Args:
        airframe: The vehicle.
        rng: Random stream; two normal numbers a rotor.
        dt_s: Interval of the IMU.
        is_on: False for a vehicle without vibration; the draws are made all the same.
    """
    records = np.zeros(1, VIBRATION_DTYPE)
    v = records[0]
    quadrotor = airframe.quadrotor
    n = len(quadrotor.rotors)
    # Length and angle of a normal 2-vector: the imbalance is Rayleigh, its direction uniform.
    parts = rng.standard_normal((n, 2))
    v["is_on"], v["dt_s"], v["mass_kg"], v["n_rotors"] = is_on, dt_s, quadrotor.mass_kg, n
    v["imbalance_kgm"][:n] = airframe.rotor_imbalance_kgm * np.hypot(*parts.T) / math.sqrt(2.0)
    v["angle_rad"][:n] = np.arctan2(*parts.T)
    v["sine"], v["cosine"] = np.sin(v["angle_rad"]), np.cos(v["angle_rad"])
    v["ripple_n"][:n] = [_RIPPLE * rotor.thrust_constant for rotor in quadrotor.rotors]
    v["hub_flu_m"][:n] = [rotor.position_flu_m for rotor in quadrotor.rotors]
    v["inertia_flu_kgm2"] = quadrotor.inertia_flu_kgm2
    return records


@kernel
def shake(v: np.record, rotor_speed_radps: np.ndarray) -> None:
    """Write the mean acceleration and angular rate of the vibration in the interval that ends now.

    Args:
        v: Rotors, of `VIBRATION_DTYPE`; their angles and the sums change.
        rotor_speed_radps: Speed of each rotor, taken as steady in the interval.
    """
    accel, gyro = v.accel_flu_mps2, v.gyro_flu_radps
    accel[:] = 0.0
    gyro[:] = 0.0
    if v.is_on == 0:
        return
    for i in range(v.n_rotors):
        turn = rotor_speed_radps[i] * v.dt_s
        if abs(turn) >= _LEAST_TURN_RAD:
            _add_rotor(v, i, rotor_speed_radps[i], turn)


@kernel
def _add_rotor(v: np.record, i: int, speed: float, turn: float) -> None:
    """Turn one rotor by an interval and add its mean force and torque, over mass and inertia."""
    s, c = v.sine[i], v.cosine[i]
    v.angle_rad[i] = (v.angle_rad[i] + turn) % (2.0 * math.pi)
    v.sine[i], v.cosine[i] = math.sin(v.angle_rad[i]), math.cos(v.angle_rad[i])
    s1, c1 = v.sine[i], v.cosine[i]
    mean_cos, mean_sin = (s1 - s) / turn, (c - c1) / turn
    # The integrals of cos 2a and sin 2a are sin a cos a and sin^2 a.
    mean_cos2, mean_sin2 = (s1 * c1 - s * c) / turn, (s1 * s1 - s * s) / turn
    radial, axial = v.imbalance_kgm[i] * speed * speed, v.ripple_n[i] * speed * speed
    hub, J = v.hub_flu_m[i], v.inertia_flu_kgm2
    v.accel_flu_mps2[0] += radial / v.mass_kg * mean_cos
    v.accel_flu_mps2[1] += radial / v.mass_kg * mean_sin
    v.accel_flu_mps2[2] += axial / v.mass_kg * mean_sin2
    # The angular rate is the integral of the torque, hub x force, over J. Integrating cos a over
    # time gives sin a / w, hence one power of the speed less.
    once, twice = radial / speed, axial / (_N_BLADES * speed)
    v.gyro_flu_radps[0] += (-hub[1] * twice * mean_cos2 + hub[2] * once * mean_cos) / J[0]
    v.gyro_flu_radps[1] += (hub[2] * once * mean_sin + hub[0] * twice * mean_cos2) / J[1]
    v.gyro_flu_radps[2] += (-hub[0] * once * mean_cos - hub[1] * once * mean_sin) / J[2]
