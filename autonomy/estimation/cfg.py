"""Tuning of the filter: what it takes its sensors and its vehicle to be."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True, slots=True)
class DragModel:
    """How the air slows a multirotor across its rotor axes: what makes wind observable.

    Specific force along body x or y: -(sum of `rotor_mps_per_rad` w + `fuselage` |u|) u, for rotor
    speeds w and air speed u.
    """

    rotor_mps_per_rad: tuple[float, float, float, float]
    """Of each rotor, drag coefficient over mass: 1/s for each rad/s."""
    fuselage_per_m: tuple[float, float]
    """rho / 2 CdA over mass along body x and y, 1/m."""
    thrust_m: tuple[float, float, float, float]
    """Of each rotor, thrust constant over mass: m/s^2 for each (rad/s)^2."""


@dataclass(frozen=True, kw_only=True, slots=True)
class EstimatorCfg:
    """Tuning of the filter; pairs are horizontal (each axis) and vertical."""

    gyro_noise_density: float = 1.5e-3
    """rad/s/sqrt(Hz)."""
    accel_noise_density: float = 0.02
    """m/s^2/sqrt(Hz)."""
    gyro_bias_walk: float = 4e-5
    """rad/s^2/sqrt(Hz)."""
    accel_bias_walk: float = 3e-3
    """m/s^3/sqrt(Hz)."""
    baro_offset_walk: float = 0.002
    """m/s/sqrt(Hz): weather and warming up."""
    baro_sigma_m: float = 0.15
    heading_sigma_rad: float = 0.03
    """Of one sample of the magnetometer."""
    gate_sigma: float = 5.0
    """Innovations beyond this many standard deviations are refused."""
    max_gnss_rejections: int = 20
    """After so many refused fixes in a row position and velocity start again from the fix."""
    gnss_wander_sigma_m: tuple[float, float] = (0.03, 0.05)
    """Stationary standard deviation of the receiver's slow error."""
    gnss_wander_correlation_s: float = 60.0
    max_gnss_step_m: float = 0.03
    """While there is odometry, a fix moves each axis of the position by at most this."""
    vio_position_walk: tuple[float, float] = (0.025, 0.02)
    """Drift of visual-inertial odometry, m/sqrt(m flown)."""
    vio_yaw_walk: float = 2.1e-3
    """rad/sqrt(m flown)."""
    vio_position_sigma_m: float = 0.01
    vio_yaw_sigma_rad: float = 4e-3
    mocap_position_sigma_m: float = 1e-3
    mocap_yaw_sigma_rad: float = 3e-3
    wind_walk: float = 0.6
    """m/s/sqrt(s): moderate turbulence, sigma sqrt(2 / tau) with 1.5 m/s and 12 s."""
    initial_wind_sigma_mps: float = 5.0
    drag_sigma_mps2: float = 0.12
    """Of one sample of the specific force across the rotor axes."""
    drag_relative_sigma: float = 0.05
    """Of the drag force itself: how well the coefficients are known."""
    drag_interval_s: float = 0.02
    """Between two samples that are used."""
    range_sigma_m: float = 0.05
    terrain_slope: float = 0.5
    """The surface below may rise by this much a metre flown (1 sigma)."""
    align_s: float = 1.0
    """Rest before the filter starts."""
    max_align_rate_radps: float = 0.05
    """RMS angular rate, bias included, above which the vehicle does not count as resting."""
    initial_tilt_sigma_rad: float = 0.003
    """Beyond what the accelerometer's bias makes of it."""
    initial_yaw_sigma_rad: float = 0.03
    initial_velocity_sigma_mps: float = 0.01
    start_sigma_m: float = 0.03
    """Of the place that it is told to start at, where no satellites are heard; each axis."""
    initial_gyro_bias_sigma_radps: float = 0.002
    initial_accel_bias_sigma_mps2: float = 0.2
