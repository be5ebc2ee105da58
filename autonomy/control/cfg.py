"""Gains and limits of the controller, and how they follow from a vehicle's parameters.

Airframes come from files, so no gains can be tuned by hand for each. Their bandwidth follows
instead from three physical limits: inertia, the lag of the rotors and the torque that they have
left in hover.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autonomy.model.dynamics import thrust_torque_matrix
from autonomy.model.quadrotor import GRAVITY_MPS2, QuadrotorParams

_STIFFNESS = 1.7
"""Square root of the torque for a radian, (N m)^(1/2): 10 rad/s of an Iris."""
_LEAST_BANDWIDTH_RADPS = 7.0  # floor of the inertia's rule in `controller_cfg_for`
_LEAD = 0.5
"""Lag of a driven rotor over its own."""
_LAG_SHARE = 0.2  # attitude bandwidth over that of a driven rotor
_SATURATING_RAD = 0.4  # attitude error at which rotors in hover may saturate


@dataclass(frozen=True, kw_only=True, slots=True)
class ControllerCfg:
    """Gains as natural frequency and damping, limits in SI units.

    A gain that is stated as a frequency holds for any mass and inertia, so that one set of numbers
    suits vehicles of different size. `controller_cfg_for` adapts the numbers to a vehicle.
    """

    position_bandwidth_radps: float = 4.0
    """wx: kx = m wx^2."""
    position_damping: float = 0.9
    """zeta: kv = 2 m zeta wx."""
    integral_gain: float = 3.0
    """Acceleration gained per second and metre of position error, 1/s^3."""
    max_integral_mps2: float = 1.0
    max_disturbance_mps2: float = 12.0
    """Horizontal acceleration, from wind for example, that is compensated: on the Iris as much as
    its thrust holds. A quarter of it downwards, an eighth upwards."""
    attitude_bandwidth_radps: float = 10.0
    """wR of roll and pitch: kR = J wR^2, kW = 2 J zeta wR."""
    attitude_damping: float = 0.9
    yaw_bandwidth_radps: float = 5.0
    rate_bandwidth_radps: float = 18.0
    """Bandwidth of the body rates at the `RATE` level, 1/s; yaw gets half."""
    max_tilt_rad: float = math.radians(60.0)
    max_feedback_mps2: float = 6.0
    """Acceleration that position and velocity errors may demand, horizontally and vertically."""
    max_thrust_fraction: float = 0.95
    """Share of the collective that trajectories may use; the rest is for torques."""
    idle_speed_fraction: float = 0.12
    """Least speed of armed rotors, as a fraction of the maximum."""
    rotor_response_s: float = 0.0125
    """Slower rotors are driven to this lag by their commands, so that speeds fall as fast as they
    rise. 0.006 tracks 2 % closer and moves the rotors three times as much."""

    approach_gain_radps: float = 1.0
    """Reference speed per metre of distance to a bare position setpoint."""
    velocity_response_radps: float = 3.0
    """Rate at which the reference follows a velocity setpoint."""
    max_acceleration_mps2: float = 3.0
    """Horizontal limit of the reference towards bare position and velocity setpoints."""
    max_acceleration_vertical_mps2: float = 3.0
    max_jerk_mps3: float = 25.0
    max_speed_mps: float = 12.0
    """Horizontal limit of the reference towards bare position and velocity setpoints."""
    max_vertical_speed_mps: float = 5.0
    max_climb_mps: float = 3.0
    """Vertical limit towards a bare position setpoint, as the next one."""
    max_descent_mps: float = 1.5
    leash_m: float = 1.0
    """Lag of the vehicle at which the reference waits, half of it vertically."""
    max_yaw_rate_radps: float = 1.6
    max_yaw_acceleration_radps2: float = 5.0
    yaw_gain_radps: float = 2.0


def controller_cfg_for(quadrotor: QuadrotorParams) -> ControllerCfg:
    """Derive the gains from a vehicle's inertia, the lag of its rotors and their torque.

    Roll and pitch are as fast as the slowest of these allows:

    - inertia: the same torque for an error of a radian, whatever the vehicle, down to 7 rad/s;
    - lag: rotors are driven at most twice as fast as they are by themselves, and the attitude is a
      fifth of that, so that they cost it 20 degrees of phase;
    - torque: an error of 0.4 rad takes no more than the rotors can add in hover.

    Yaw is limited by its torque in hover. The position loop stays well below the attitude loop,
    because it takes the attitude for given.
    """
    response_s = _LEAD * max(
        max(rotor.time_constant_up_s, rotor.time_constant_down_s) for rotor in quadrotor.rotors
    )
    bandwidth = min(
        max(_STIFFNESS / math.sqrt(max(quadrotor.inertia_flu_kgm2[:2])), _LEAST_BANDWIDTH_RADPS),
        _LAG_SHARE / response_s,
        math.sqrt(_tilt_authority_radps2(quadrotor) / _SATURATING_RAD),
    )
    authority = _yaw_authority_radps2(quadrotor)
    return ControllerCfg(
        position_bandwidth_radps=min(4.0, 0.4 * bandwidth),
        attitude_bandwidth_radps=bandwidth,
        yaw_bandwidth_radps=min(5.0, math.sqrt(authority / 0.3)),
        max_yaw_acceleration_radps2=min(5.0, 0.5 * authority),
        rotor_response_s=response_s,
    )


def _tilt_authority_radps2(quadrotor: QuadrotorParams) -> float:
    """Lesser angular acceleration of roll and pitch by what rotors have left above hover."""
    room_n = np.array(_rooms_n(quadrotor))
    levers_m = np.abs(thrust_torque_matrix(quadrotor)[1:3])
    return float(min(levers_m @ room_n / quadrotor.inertia_flu_kgm2[:2]))


def _yaw_authority_radps2(quadrotor: QuadrotorParams) -> float:
    """Yaw acceleration in hover with every rotor changed up to the nearer of its limits."""
    weight_share_n = _weight_share_n(quadrotor)
    torque_nm = 0.0
    for rotor, room_n in zip(quadrotor.rotors, _rooms_n(quadrotor), strict=True):
        # A rotor can lose no more than its share of the weight, and gain no more than its room
        # above it.
        torque_nm += rotor.torque_per_thrust_m * min(room_n, weight_share_n)
    return max(torque_nm / quadrotor.inertia_flu_kgm2[2], 0.1)


def _rooms_n(quadrotor: QuadrotorParams) -> list[float]:
    """Thrust that each rotor can add to its share of the weight, N; zero if it cannot hover."""
    weight_share_n = _weight_share_n(quadrotor)
    return [
        max(rotor.thrust_constant * rotor.max_speed_radps**2 - weight_share_n, 0.0)
        for rotor in quadrotor.rotors
    ]


def _weight_share_n(quadrotor: QuadrotorParams) -> float:
    return quadrotor.mass_kg * GRAVITY_MPS2 / len(quadrotor.rotors)
