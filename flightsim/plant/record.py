"""The records of the plant as a whole: its clock and engine, what it logs, what it reports."""

from __future__ import annotations

import numpy as np

from autonomy.estimation.error_state import N_STATES

ENGINE_DTYPE = np.dtype(
    [
        ("tick", "i8"),  # control ticks since the start
        ("tick_us", "i8"),
        ("tick_hz", "i8"),
        ("steps_per_tick", "i8"),
        ("ticks_per_advance", "i8"),
        ("has_new_setpoint", "i8"),
        ("has_power", "i8"),
        ("knows_truth", "i8"),  # the controller, instead of the estimate
        ("contact_ticks", "i8"),
        ("step_address", "i8"),
        ("ray_address", "i8"),
        ("model_address", "i8"),
        ("data_address", "i8"),
        ("vehicle_body", "i4"),
        ("ray_geom", "i4", 1),
        ("no_command", "f8", 4),
    ],
    align=True,
)

HISTORY_DTYPE = np.dtype(
    [
        ("time_us", "i8"),
        ("position_true_enu_m", "f8", 3),
        ("velocity_true_enu_mps", "f8", 3),
        ("quat_true_wxyz", "f8", 4),
        ("angular_rate_true_flu_radps", "f8", 3),
        ("wind_enu_mps", "f8", 3),
        ("position_est_enu_m", "f8", 3),
        ("velocity_est_enu_mps", "f8", 3),
        ("quat_est_wxyz", "f8", 4),
        ("angular_rate_est_flu_radps", "f8", 3),
        ("accel_flu_mps2", "f8", 3),
        ("gyro_flu_radps", "f8", 3),
        ("rotor_command_radps", "f8", 4),
        ("rotor_speed_radps", "f8", 4),
        ("setpoint_level", "f8"),
        ("setpoint_position_enu_m", "f8", 3),
        ("setpoint_velocity_enu_mps", "f8", 3),
        ("reference_position_enu_m", "f8", 3),
        ("reference_velocity_enu_mps", "f8", 3),
        ("is_touching", "i8"),
    ],
    align=True,
)
"""One control tick of the log."""

REPORT_DTYPE = np.dtype(
    [
        ("position_true", "f8", 3),
        ("velocity_true", "f8", 3),
        ("quat_true", "f8", 4),
        ("rate_true", "f8", 3),
        ("position_est", "f8", 3),
        ("velocity_est", "f8", 3),
        ("quat_est", "f8", 4),
        ("rate_est", "f8", 3),
        ("rotor_speed", "f8", 4),
        ("rotor_command", "f8", 4),
        ("thrust_fraction", "f8"),
        ("terrain_height", "f8"),
        ("is_aligned", "f8"),
        ("variance", "f8", N_STATES),
        ("gyro_bias", "f8", 3),
        ("accel_bias", "f8", 3),
        ("ratios", "f8", 4),  # GNSS position, GNSS velocity, barometer, heading
        ("gnss_age_ticks", "f8"),
        ("wind", "f8", 2),
        ("accel", "f8", 3),
        ("gyro", "f8", 3),
        ("gnss_tick", "f8"),
        ("gnss_settling", "f8"),
        ("hears_satellites", "f8"),
        ("gnss_position", "f8", 3),
        ("gnss_velocity", "f8", 3),
        ("baro_tick", "f8"),
        ("pressure", "f8"),
        ("pressure_altitude", "f8"),
        ("temperature", "f8"),
        ("mag_tick", "f8"),
        ("field", "f8", 3),
        ("range", "f8"),
        ("contact_ticks", "f8"),
    ],
    align=True,
)
"""What Python reads at most once an advance: doubles alone, so that one `tolist` reads them all."""


def report_slices() -> dict[str, slice]:
    """Where each field of `REPORT_DTYPE` lies in the flat list of doubles."""
    slices = {}
    for name, (dtype, offset, *_) in (REPORT_DTYPE.fields or {}).items():
        first = offset // 8
        slices[name] = slice(first, first + dtype.itemsize // 8)
    return slices
