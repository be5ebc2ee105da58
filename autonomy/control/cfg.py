"""Gains and limits of the controller."""

from __future__ import annotations

import math
from dataclasses import dataclass

from autonomy.model.quadrotor import GRAVITY_MPS2, QuadrotorParams


@dataclass(frozen=True, kw_only=True, slots=True)
class ControllerCfg:
    """Gains as natural frequency and damping, limits in SI units."""

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
    """Defaults with the fastest attitude loops that the vehicle allows.

    Roll and pitch: the same torque per radian gives 10 rad/s on the Iris; lighter vehicles are
    limited to 16 rad/s, where the lag of their rotors begins to matter. Yaw: limited by its torque
    in hover. The position loop stays well below the attitude loop.
    """
    bandwidth = 1.7 / math.sqrt(max(quadrotor.inertia_flu_kgm2[:2]))
    authority = _yaw_authority_radps2(quadrotor)
    bandwidth = min(max(bandwidth, 7.0), 16.0)
    return ControllerCfg(
        position_bandwidth_radps=min(4.0, 0.4 * bandwidth),
        attitude_bandwidth_radps=bandwidth,
        yaw_bandwidth_radps=min(5.0, math.sqrt(authority / 0.3)),
        max_yaw_acceleration_radps2=min(5.0, 0.5 * authority),
    )


def _yaw_authority_radps2(quadrotor: QuadrotorParams) -> float:
    """Yaw acceleration in hover with every rotor changed up to the nearer of its limits."""
    weight_share_n = 0.25 * quadrotor.mass_kg * GRAVITY_MPS2
    torque_nm = 0.0
    for rotor in quadrotor.rotors:
        room_n = rotor.thrust_constant * rotor.max_speed_radps**2 - weight_share_n
        torque_nm += rotor.torque_per_thrust_m * max(min(room_n, weight_share_n), 0.0)
    return max(torque_nm / quadrotor.inertia_flu_kgm2[2], 0.1)
