"""Tuning of the filter: its assumptions about sensors and vehicle.

Noise densities and walks must match the sensors; `estimator_cfg_for` derives them from a plant's.
Values that are too small make the filter overconfident, and its gates then reject good
measurements.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True, slots=True)
class DragModel:
    """Air drag of a multirotor across its rotor axes, which makes wind observable.

    Specific force along body x or y: -(sum of `rotor_mps_per_rad` w + `fuselage` |u|) u, for rotor
    speeds w and air speed u.
    """

    rotor_mps_per_rad: tuple[float, ...]
    """Drag coefficient over mass of each rotor: 1/s per rad/s."""
    fuselage_per_m: tuple[float, float]
    """rho / 2 CdA over mass along body x and y, 1/m."""
    thrust_m: tuple[float, ...]
    """Thrust constant over mass of each rotor: m/s^2 per (rad/s)^2."""


@dataclass(frozen=True, kw_only=True, slots=True)
class EstimatorCfg:
    """Tuning of the filter; pairs are horizontal (each axis) and vertical."""

    gyro_noise_density: float = 1.5e-3
    """Density of white noise, rad/s/sqrt(Hz)."""
    accel_noise_density: float = 0.02
    """Density of white noise, m/s^2/sqrt(Hz)."""
    gyro_bias_walk: float = 4e-5
    """Random walk, rad/s^2/sqrt(Hz)."""
    accel_bias_walk: float = 3e-3
    """Random walk, m/s^3/sqrt(Hz)."""
    baro_offset_walk: float = 0.002
    """Random walk by weather and warming up, m/s/sqrt(Hz)."""
    baro_sigma_m: float = 0.15
    heading_sigma_rad: float = 0.03
    """Standard deviation of the noise of one magnetometer sample."""
    heading_disturbance_rad: float = 0.0
    """Standard deviation of the heading error by steel and currents. A field whose strength differs
    from the Earth's adds to it."""
    heading_disturbance_samples: float = 0.0
    """Number of samples that share one disturbance; their mean does not lessen it."""
    gate_sigma: float = 5.0
    """Innovations beyond this many standard deviations are rejected."""
    max_gnss_rejections: int = 20
    """Consecutive rejected fixes after which position and velocity restart from the fix."""
    gnss_wander_sigma_m: tuple[float, float] = (0.03, 0.05)
    """Stationary standard deviation of the receiver's slow error."""
    gnss_wander_correlation_s: float = 60.0
    max_gnss_step_m: float = 0.03
    """Greatest change of each position axis by the position, and by the velocity, of a fix, while
    there is odometry and once the vehicle has moved."""
    vio_position_walk: tuple[float, float] = (0.025, 0.02)
    """Drift of visual-inertial odometry, m/sqrt(m flown)."""
    vio_yaw_walk: float = 2.1e-3
    """Random walk of the odometry's heading, rad/sqrt(m flown)."""
    vio_position_sigma_m: float = 0.01
    vio_yaw_sigma_rad: float = 4e-3
    mocap_position_sigma_m: float = 1e-3
    mocap_yaw_sigma_rad: float = 3e-3
    wind_walk: float = 0.6
    """Random walk, m/s/sqrt(s): moderate turbulence, sigma sqrt(2 / tau) with 1.5 m/s and 12 s."""
    initial_wind_sigma_mps: float = 5.0
    drag_sigma_mps2: float = 0.12
    """Standard deviation of one sample of the specific force across the rotor axes."""
    drag_relative_sigma: float = 0.05
    """Relative standard deviation of the drag force: how well its coefficients are known."""
    drag_interval_s: float = 0.02
    """Time between two samples that are fused."""
    range_sigma_m: float = 0.05
    terrain_slope: float = 0.5
    """Standard deviation of the rise of the surface below per metre flown."""
    align_s: float = 1.0
    """Time at rest before the filter starts."""
    max_align_rate_radps: float = 0.05
    """RMS angular rate, bias included, above which the vehicle is not at rest."""
    initial_tilt_sigma_rad: float = 0.003
    """Standard deviation besides the effect of the accelerometer's bias."""
    initial_yaw_sigma_rad: float = 0.03
    initial_velocity_sigma_mps: float = 0.01
    start_sigma_m: float = 0.03
    """Standard deviation per axis of the given start position, used without satellites."""
    initial_gyro_bias_sigma_radps: float = 0.002
    initial_accel_bias_sigma_mps2: float = 0.2
