"""State of the filter, and the record that holds it.

The nominal state is integrated from the IMU; the Kalman filter estimates its small error. An error
stays near zero, so that linear equations suffice, and an attitude error of three numbers has no
constraint as a quaternion has. The attitude error is a rotation vector in the world frame: R_true =
exp([theta]x) R.

    index   error         unit
    0-2     position      m        ENU
    3-5     velocity      m/s      ENU
    6-8     attitude      rad      rotation vector, ENU
    9-11    gyro bias     rad/s    FLU
    12-14   accel bias    m/s^2    FLU
    15      barometer     m        height by the barometer minus ENU height
    16-18   GNSS wander   m        ENU, the slow error of the receiver
    19-21   VIO origin    m        ENU, where the odometry's frame has its origin
    22      VIO heading   rad      of the odometry's frame
    23-24   wind          m/s      east and north

The barometer smooths the height but does not define it: GNSS does. The wander keeps GNSS honest,
because its slow error does not average out. The VIO frame makes odometry a relative measurement:
its drift goes into its frame, and losing or regaining GNSS resets nothing.

Source: Sola 2017, "Quaternion kinematics for the error-state Kalman filter", chapter 7.
"""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from autonomy.estimation.cfg import DragModel, EstimatorCfg
from autonomy.model.quadrotor import MAX_ROTORS
from autonomy.types import Vector3

N_STATES = 25
POSITION, VELOCITY, ATTITUDE, GYRO_BIAS, ACCEL_BIAS, BARO_OFFSET = 0, 3, 6, 9, 12, 15
GNSS_WANDER, VIO_ORIGIN, VIO_YAW, WIND = 16, 19, 22, 23
N_PAST = 64
"""Number of remembered IMU ticks, and so the limit of a measurement's age."""

MEASUREMENTS = (
    "GNSS position",
    "GNSS velocity",
    "barometer",
    "heading",
    "VIO position",
    "VIO heading",
    "mocap position",
    "mocap heading",
    "drag",
    "velocity",
)
"""Kinds of measurement, by their row in `innovation_square_sum`. The order is fixed: modules keep
their row as a number."""

FILTER_DTYPE = np.dtype(
    [
        # Nominal state.
        ("position_enu_m", "f8", 3),
        ("velocity_enu_mps", "f8", 3),
        ("quat_wxyz", "f8", 4),
        ("gyro_bias_flu_radps", "f8", 3),
        ("accel_bias_flu_mps2", "f8", 3),
        ("baro_offset_m", "f8"),
        ("gnss_wander_enu_m", "f8", 3),
        ("vio_origin_enu_m", "f8", 3),
        ("vio_yaw_rad", "f8"),
        ("wind_enu_mps", "f8", 2),
        ("angular_rate_flu_radps", "f8", 3),  # latest gyro less its bias
        ("acceleration_enu_mps2", "f8", 3),  # over the last interval
        ("covariance", "f8", (N_STATES, N_STATES)),
        # Estimates of the last ticks (`autonomy.estimation.past`).
        ("past_position_enu_m", "f8", (N_PAST, 3)),
        ("past_velocity_enu_mps", "f8", (N_PAST, 3)),
        ("past_yaw_rad", "f8", N_PAST),
        ("moved_enu_m", "f8", 3),
        ("moved_velocity_enu_mps", "f8", 3),
        ("moved_moment_enu_m", "f8", 3),
        ("moved_yaw_rad", "f8"),
        ("tick", "i8"),
        ("dt_s", "f8"),
        # Last innovations relative to their gates: accepted below 1.
        ("ratio_gnss_position", "f8"),
        ("ratio_gnss_velocity", "f8"),
        ("ratio_baro", "f8"),
        ("ratio_heading", "f8"),
        ("gnss_rejections", "i8"),
        ("rejected_enu_m", "f8", 3),  # last fix that was rejected
        ("last_gnss_tick", "i8"),
        ("has_moved", "i8"),  # since the alignment
        ("last_wander_tick", "i8"),
        ("last_position_tick", "i8"),  # of whatever says where the vehicle is
        # Squared innovations over their variances, summed by kind of measurement: NIS.
        ("innovation_square_sum", "f8", len(MEASUREMENTS)),
        ("n_innovations", "i8", len(MEASUREMENTS)),
        # Surface below.
        ("terrain_height_m", "f8"),
        ("terrain_variance_m2", "f8"),  # against the estimated height
        ("terrain_rejections", "i8"),
        # Odometry.
        ("has_vio", "i8"),  # its frame has been placed
        ("vio_rejections", "i8"),
        ("last_vio_tick", "i8"),
        # Alignment at rest.
        ("is_aligned", "i8"),
        ("has_start", "i8"),  # 1 if a start position was given
        ("start_enu_m", "f8", 3),
        ("n_imu", "i8"),
        ("n_gnss", "i8"),
        ("n_baro", "i8"),
        ("n_mag", "i8"),
        ("accel_sum", "f8", 3),
        ("gyro_sum", "f8", 3),
        ("gyro_square_sum", "f8"),
        ("mag_sum", "f8", 3),
        ("gnss_sum", "f8", 3),
        ("gnss_sigma_m", "f8", 3),  # white part of the last fix that was collected
        ("baro_sum", "f8"),
        # Configuration, see EstimatorCfg.
        ("gravity_mps2", "f8"),
        ("gyro_variance_rate", "f8"),
        ("accel_variance_rate", "f8"),
        ("gyro_bias_variance_rate", "f8"),
        ("accel_bias_variance_rate", "f8"),
        ("baro_offset_variance_rate", "f8"),
        ("baro_variance_m2", "f8"),
        ("heading_variance_rad2", "f8"),
        ("heading_disturbance_rad", "f8"),
        ("heading_disturbance_samples", "f8"),
        ("field_excess", "f8"),  # low-passed, over the horizontal field
        ("gate_sigma", "f8"),
        ("max_gnss_rejections", "i8"),
        ("wander_variance_m2", "f8", 3),
        ("wander_correlation_s", "f8"),
        ("max_gnss_step_m", "f8"),
        ("vio_walk_m2pm", "f8", 3),
        ("vio_yaw_walk_rad2pm", "f8"),
        ("vio_variance_m2", "f8"),
        ("vio_yaw_variance_rad2", "f8"),
        ("mocap_variance_m2", "f8"),
        ("mocap_yaw_variance_rad2", "f8"),
        ("wind_variance_rate", "f8"),
        ("drag_variance", "f8"),
        ("drag_relative_sigma", "f8"),
        ("drag_ticks", "i8"),  # between two uses, 0 without a model of drag
        ("drag_rotor_mps_per_rad", "f8", MAX_ROTORS),
        ("drag_fuselage_per_m", "f8", 2),
        ("thrust_m", "f8", MAX_ROTORS),
        ("drag_accel_sum", "f8", 2),  # specific force along x and y since the last use
        ("n_drag_accel", "i8"),
        ("range_variance_m2", "f8"),
        ("terrain_slope", "f8"),
        ("field_enu_ut", "f8", 3),
        ("aligned_sigma", "f8", N_STATES),
        ("start_sigma_m", "f8"),
        ("n_align", "i8"),
        ("max_align_rate_radps", "f8"),
        # Scratch.
        ("measurement_row", "f8", N_STATES),
        ("gain", "f8", N_STATES),
        ("work_quat", "f8", 4),
        ("work_vector", "f8", 3),
        ("work_R", "f8", (3, 3)),
    ],
    align=True,
)


_SAME_NAME = {field.name for field in fields(EstimatorCfg)} & set(FILTER_DTYPE.names or ())
"""Settings that the kernels use exactly as they are configured."""


def new_filter(
    cfg: EstimatorCfg,
    *,
    dt_s: float,
    field_enu_ut: Vector3,
    gravity_mps2: float,
    drag: DragModel | None = None,
    start_enu_m: Vector3 | None = None,
) -> np.ndarray:
    """Create a filter before its alignment, as one record in an array of shape (1,).

    Args:
        cfg: Tuning of the filter.
        dt_s: Time between two IMU samples.
        field_enu_ut: Earth's magnetic field at the place of flight, by a geomagnetic model.
        gravity_mps2: Standard gravity at the place of flight.
        drag: Drag of the vehicle; None estimates no wind.
        start_enu_m: Given start position; None waits for satellites.
    """
    filters = np.zeros(1, FILTER_DTYPE)
    f = filters[0]
    # The identity; zeros are no rotation.
    f["quat_wxyz"][0] = 1.0
    f["dt_s"] = dt_s
    f["gravity_mps2"] = gravity_mps2
    f["field_enu_ut"] = field_enu_ut
    # NaN means that nothing below has been measured yet.
    f["terrain_height_m"] = np.nan
    f["n_align"] = round(cfg.align_s / dt_s)
    f["aligned_sigma"] = _aligned_sigma(cfg)
    if start_enu_m is not None:
        f["has_start"], f["start_enu_m"] = 1, start_enu_m
    _configure(f, cfg)
    if drag is not None:
        f["drag_ticks"] = round(cfg.drag_interval_s / dt_s)
        f["drag_rotor_mps_per_rad"][: len(drag.rotor_mps_per_rad)] = drag.rotor_mps_per_rad
        f["drag_fuselage_per_m"] = drag.fuselage_per_m
        f["thrust_m"][: len(drag.thrust_m)] = drag.thrust_m
    return filters


def _configure(f: np.void, cfg: EstimatorCfg) -> None:
    """Copy variances and limits; the kernels work with squares, so deviations are squared here."""
    for name in _SAME_NAME:
        f[name] = getattr(cfg, name)
    f["gyro_variance_rate"] = cfg.gyro_noise_density**2
    f["accel_variance_rate"] = cfg.accel_noise_density**2
    f["gyro_bias_variance_rate"] = cfg.gyro_bias_walk**2
    f["accel_bias_variance_rate"] = cfg.accel_bias_walk**2
    f["baro_offset_variance_rate"] = cfg.baro_offset_walk**2
    f["baro_variance_m2"] = cfg.baro_sigma_m**2
    f["heading_variance_rad2"] = cfg.heading_sigma_rad**2
    f["wander_variance_m2"] = _axes_squared(cfg.gnss_wander_sigma_m)
    f["wander_correlation_s"] = cfg.gnss_wander_correlation_s
    f["vio_walk_m2pm"] = _axes_squared(cfg.vio_position_walk)
    f["vio_yaw_walk_rad2pm"] = cfg.vio_yaw_walk**2
    f["vio_variance_m2"] = cfg.vio_position_sigma_m**2
    f["vio_yaw_variance_rad2"] = cfg.vio_yaw_sigma_rad**2
    f["mocap_variance_m2"] = cfg.mocap_position_sigma_m**2
    f["mocap_yaw_variance_rad2"] = cfg.mocap_yaw_sigma_rad**2
    f["wind_variance_rate"] = cfg.wind_walk**2
    f["drag_variance"] = cfg.drag_sigma_mps2**2
    f["range_variance_m2"] = cfg.range_sigma_m**2


def _axes_squared(pair: tuple[float, float]) -> tuple[float, float, float]:
    horizontal, vertical = pair
    return (horizontal**2, horizontal**2, vertical**2)


def _aligned_sigma(cfg: EstimatorCfg) -> np.ndarray:
    """Standard deviations after alignment of the states that alignment does not measure."""
    sigma = np.zeros(N_STATES)
    sigma[VELOCITY : VELOCITY + 3] = cfg.initial_velocity_sigma_mps
    sigma[ATTITUDE : ATTITUDE + 2] = cfg.initial_tilt_sigma_rad
    sigma[ATTITUDE + 2] = cfg.initial_yaw_sigma_rad
    sigma[GYRO_BIAS : GYRO_BIAS + 3] = cfg.initial_gyro_bias_sigma_radps
    sigma[ACCEL_BIAS : ACCEL_BIAS + 3] = cfg.initial_accel_bias_sigma_mps2
    sigma[WIND : WIND + 2] = cfg.initial_wind_sigma_mps
    return sigma
