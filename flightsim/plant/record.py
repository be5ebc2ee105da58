"""The record of a plant: its engine, all of its parts, and what it logs."""

from __future__ import annotations

import numpy as np

from autonomy.control import CONTROLLER_DTYPE, SETPOINT_DTYPE, STATE_DTYPE
from autonomy.estimation.error_state import FILTER_DTYPE
from flightsim.environment.motion import TRAFFIC_DTYPE
from flightsim.environment.wind import AIR_DTYPE
from flightsim.plant.sensing import SENSORS
from flightsim.vehicles.rotor_model import ROTORS_DTYPE

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
        # of the vehicle, in MuJoCo's memory: pose (7,), velocity (6,), wrench to apply (6,)
        ("qpos_address", "i8"),
        ("qvel_address", "i8"),
        ("applied_address", "i8"),
        # of the world: constraint forces, poses of movers, what geoms and bodies may touch
        ("constraint_address", "i8"),
        ("mocap_pos_address", "i8"),
        ("mocap_quat_address", "i8"),
        ("geom_bits_address", "i8"),
        ("body_bits_address", "i8"),
        ("n_constraints", "i8"),
        ("n_geoms", "i8"),
        ("n_bodies", "i8"),
        ("vehicle_body", "i4"),
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

PLANT_DTYPE = np.dtype(
    [
        ("engine", ENGINE_DTYPE),
        ("rotors", ROTORS_DTYPE),
        ("air", AIR_DTYPE),
        ("traffic", TRAFFIC_DTYPE),
        *((sensor.name, sensor.dtype) for sensor in SENSORS),
        ("filter", FILTER_DTYPE),
        ("state", STATE_DTYPE),
        ("setpoint", SETPOINT_DTYPE),
        ("controller", CONTROLLER_DTYPE),
    ],
    align=True,
)
"""All that a plant is and knows, in one piece."""
