"""Record of a plant: its engine, all of its parts, and its log."""

from __future__ import annotations

import numpy as np

from autonomy.control import CONTROLLER_DTYPE, SETPOINT_DTYPE, STATE_DTYPE
from autonomy.estimation.error_state import FILTER_DTYPE
from autonomy.jit import fields
from flightsim.environment.motion import TRAFFIC_DTYPE
from flightsim.environment.wind import AIR_DTYPE
from flightsim.plant.sensing import SENSORS
from flightsim.plant.sky import SKY_DTYPE
from flightsim.plant.surfaces import SURFACES_DTYPE
from flightsim.sensors.vibration import VIBRATION_DTYPE
from flightsim.vehicles.rotor_model import ROTORS_DTYPE

ENGINE_DTYPE = np.dtype(
    [
        ("tick", "i8"),  # control ticks since the start
        *fields("tick_us", "tick_hz", "steps_per_tick", "ticks_per_advance", kind="i8"),
        *fields("has_new_setpoint", "has_power", "contact_ticks", kind="i8"),
        ("knows_truth", "i8"),  # the controller, instead of the estimate
        *fields("step_address", "ray_address", "clock_address", kind="i8"),  # of MuJoCo
        *fields("model_address", "data_address", kind="i8"),
        # of the vehicle, in MuJoCo's memory: pose (7,), velocity (6,), wrench to apply (6,)
        *fields("qpos_address", "qvel_address", "applied_address", kind="i8"),
        # of the world: constraint forces, poses of movers, what geoms and bodies may touch
        *fields("constraint_address", "mocap_pos_address", "mocap_quat_address", kind="i8"),
        *fields("geom_bits_address", "body_bits_address", kind="i8"),
        *fields("n_constraints", "n_geoms", "n_bodies", kind="i8"),
        ("vehicle_body", "i4"),
        ("no_command", "f8", 4),
    ],
    align=True,
)

HISTORY_DTYPE = np.dtype(
    [
        *fields("time_us", "is_touching", kind="i8"),
        ("setpoint_level", "f8"),
        *fields("position_true_enu_m", "velocity_true_enu_mps", shape=(3,)),
        *fields("angular_rate_true_flu_radps", "wind_enu_mps", shape=(3,)),
        *fields("position_est_enu_m", "velocity_est_enu_mps", shape=(3,)),
        *fields("angular_rate_est_flu_radps", "accel_flu_mps2", "gyro_flu_radps", shape=(3,)),
        *fields("setpoint_position_enu_m", "setpoint_velocity_enu_mps", shape=(3,)),
        *fields("reference_position_enu_m", "reference_velocity_enu_mps", shape=(3,)),
        *fields("quat_true_wxyz", "quat_est_wxyz", shape=(4,)),
        *fields("rotor_command_radps", "rotor_speed_radps", shape=(4,)),
    ],
    align=True,
)
"""One control tick of the log."""

PLANT_DTYPE = np.dtype(
    [
        ("engine", ENGINE_DTYPE),
        ("rotors", ROTORS_DTYPE),
        ("surfaces", SURFACES_DTYPE),
        ("vibration", VIBRATION_DTYPE),
        ("sky", SKY_DTYPE),
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
"""Complete state of a plant."""
