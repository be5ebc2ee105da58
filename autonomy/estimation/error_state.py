"""What the filter estimates, and the record that holds it.

The nominal state is integrated from the IMU; the Kalman filter estimates its small error. The
attitude error is a rotation vector in the world frame: R_true = exp([theta]x) R.

    index   error        unit
    0-2     position     m        ENU
    3-5     velocity     m/s      ENU
    6-8     attitude     rad      rotation vector, ENU
    9-11    gyro bias    rad/s    FLU
    12-14   accel bias   m/s^2    FLU
    15      barometer    m        height by the barometer minus ENU height

The last one lets the barometer smooth the height without deciding what height is: GNSS does.

Source: Sola 2017, "Quaternion kinematics for the error-state Kalman filter", chapter 7.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autonomy.model.quadrotor import Vector3

N_STATES = 16
POSITION, VELOCITY, ATTITUDE, GYRO_BIAS, ACCEL_BIAS, BARO_OFFSET = 0, 3, 6, 9, 12, 15
N_PAST = 64
"""IMU ticks that the filter remembers; the oldest measurement that it can fuse."""

FILTER_DTYPE = np.dtype(
    [
        # nominal state
        ("position_enu_m", "f8", 3),
        ("velocity_enu_mps", "f8", 3),
        ("quat_wxyz", "f8", 4),
        ("gyro_bias_flu_radps", "f8", 3),
        ("accel_bias_flu_mps2", "f8", 3),
        ("baro_offset_m", "f8"),
        ("angular_rate_flu_radps", "f8", 3),  # latest gyro less its bias
        ("acceleration_enu_mps2", "f8", 3),  # over the last interval
        ("covariance", "f8", (N_STATES, N_STATES)),
        # the estimates of the last ticks, for measurements that arrive late
        ("past_position_enu_m", "f8", (N_PAST, 3)),
        ("past_velocity_enu_mps", "f8", (N_PAST, 3)),
        ("tick", "i8"),
        ("dt_s", "f8"),
        # how the last innovations stood against their gates: accepted below 1
        ("ratio_gnss_position", "f8"),
        ("ratio_gnss_velocity", "f8"),
        ("ratio_baro", "f8"),
        ("ratio_heading", "f8"),
        ("gnss_rejections", "i8"),
        ("last_gnss_tick", "i8"),
        # surface below
        ("terrain_height_m", "f8"),
        ("terrain_variance_m2", "f8"),
        ("terrain_rejections", "i8"),
        # alignment at rest
        ("is_aligned", "i8"),
        ("n_imu", "i8"),
        ("n_gnss", "i8"),
        ("n_baro", "i8"),
        ("n_mag", "i8"),
        ("accel_sum", "f8", 3),
        ("gyro_sum", "f8", 3),
        ("gyro_square_sum", "f8"),
        ("mag_sum", "f8", 3),
        ("gnss_sum", "f8", 3),
        ("baro_sum", "f8"),
        # configuration, see EstimatorCfg
        ("gravity_mps2", "f8"),
        ("gyro_variance_rate", "f8"),
        ("accel_variance_rate", "f8"),
        ("gyro_bias_variance_rate", "f8"),
        ("accel_bias_variance_rate", "f8"),
        ("baro_offset_variance_rate", "f8"),
        ("baro_variance_m2", "f8"),
        ("heading_variance_rad2", "f8"),
        ("gate_sigma", "f8"),
        ("max_gnss_rejections", "i8"),
        ("range_variance_m2", "f8"),
        ("terrain_slope", "f8"),
        ("field_enu_ut", "f8", 3),
        ("aligned_sigma", "f8", N_STATES),
        ("n_align", "i8"),
        ("max_align_rate_radps", "f8"),
        # scratch
        ("measurement_row", "f8", N_STATES),
        ("gain", "f8", N_STATES),
        ("work_quat", "f8", 4),
        ("work_R", "f8", (3, 3)),
    ],
    align=True,
)


@dataclass(frozen=True, kw_only=True, slots=True)
class EstimatorCfg:
    """Tuning of the filter. Densities stand above those of the sensors: they cover modelling."""

    gyro_noise_density: float = 1.5e-3
    """rad/s/sqrt(Hz)."""
    accel_noise_density: float = 0.02
    """m/s^2/sqrt(Hz)."""
    gyro_bias_walk: float = 4e-5
    """rad/s^2/sqrt(Hz)."""
    accel_bias_walk: float = 3e-3
    """m/s^3/sqrt(Hz)."""
    baro_offset_walk: float = 0.01
    """m/s/sqrt(Hz)."""
    baro_sigma_m: float = 0.15
    heading_sigma_rad: float = 0.03
    gate_sigma: float = 5.0
    """Innovations beyond this many standard deviations are refused."""
    max_gnss_rejections: int = 20
    """After so many refused fixes in a row position and velocity start again from the fix."""
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
    initial_velocity_sigma_mps: float = 0.05
    initial_position_sigma_m: float = 0.5
    initial_gyro_bias_sigma_radps: float = 0.002
    initial_accel_bias_sigma_mps2: float = 0.2
    initial_baro_sigma_m: float = 0.5


def new_filter(
    cfg: EstimatorCfg, *, dt_s: float, field_enu_ut: Vector3, gravity_mps2: float
) -> np.ndarray:
    """A filter before its alignment, as one record in an array of shape (1,).

    Args:
        cfg: Tuning.
        dt_s: Time between two IMU samples.
        field_enu_ut: Earth's magnetic field at the place of flight, by a geomagnetic model.
        gravity_mps2: Standard gravity at the place of flight.
    """
    filters = np.zeros(1, FILTER_DTYPE)
    f = filters[0]
    f["quat_wxyz"][0] = 1.0
    f["dt_s"] = dt_s
    f["gravity_mps2"] = gravity_mps2
    f["gyro_variance_rate"] = cfg.gyro_noise_density**2
    f["accel_variance_rate"] = cfg.accel_noise_density**2
    f["gyro_bias_variance_rate"] = cfg.gyro_bias_walk**2
    f["accel_bias_variance_rate"] = cfg.accel_bias_walk**2
    f["baro_offset_variance_rate"] = cfg.baro_offset_walk**2
    f["baro_variance_m2"] = cfg.baro_sigma_m**2
    f["heading_variance_rad2"] = cfg.heading_sigma_rad**2
    f["gate_sigma"] = cfg.gate_sigma
    f["max_gnss_rejections"] = cfg.max_gnss_rejections
    f["range_variance_m2"] = cfg.range_sigma_m**2
    f["terrain_slope"] = cfg.terrain_slope
    f["terrain_height_m"] = np.nan
    f["field_enu_ut"] = field_enu_ut
    f["n_align"] = round(cfg.align_s / dt_s)
    f["max_align_rate_radps"] = cfg.max_align_rate_radps
    f["aligned_sigma"] = np.concatenate(
        [
            np.full(3, cfg.initial_position_sigma_m),
            np.full(3, cfg.initial_velocity_sigma_mps),
            np.full(2, cfg.initial_tilt_sigma_rad),
            [cfg.initial_yaw_sigma_rad],
            np.full(3, cfg.initial_gyro_bias_sigma_radps),
            np.full(3, cfg.initial_accel_bias_sigma_mps2),
            [cfg.initial_baro_sigma_m],
        ]
    )
    return filters
