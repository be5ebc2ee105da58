"""Record of a plant: its engine, all of its parts, and its log."""

from __future__ import annotations

from typing import Any

import numpy as np

from autonomy.control import CONTROLLER_DTYPE, SETPOINT_DTYPE, STATE_DTYPE
from autonomy.estimation.error_state import FILTER_DTYPE
from autonomy.jit import fields
from autonomy.model.quadrotor import MAX_ROTORS
from flightsim.environment.motion import TRAFFIC_DTYPE
from flightsim.environment.wind import AIR_DTYPE
from flightsim.plant.free_flight import FREE_FLIGHT_DTYPE
from flightsim.plant.rays import RAYS_DTYPE
from flightsim.plant.sensing import SENSORS
from flightsim.plant.sky import SKY_DTYPE
from flightsim.plant.surfaces import SURFACES_DTYPE
from flightsim.sensors.vibration import VIBRATION_DTYPE
from flightsim.vehicles.rotor_model import ROTORS_DTYPE

ENGINE_DTYPE = np.dtype(
    [
        ("tick", "i8"),  # control ticks since the start
        *fields("tick_us", "tick_hz", "steps_per_tick", "ticks_per_advance", kind="i8"),
        *fields("has_new_setpoint", "has_power", "contact_ticks", "is_touching", kind="i8"),
        ("knows_truth", "i8"),  # the controller, instead of the estimate
        ("has_sensors", "i8"),  # or nothing is measured and estimated
        ("is_held", "i8"),  # by a hand: the vehicle stays where it is
        ("is_lost", "i8"),  # the engine gave its state up and began anew
        *fields("step_address", "kinematics_address", "clock_address", kind="i8"),  # of MuJoCo
        ("rays", RAYS_DTYPE),
        *fields("model_address", "data_address", "time_address", kind="i8"),
        # of the vehicle, in MuJoCo's memory: pose (7,), velocity (6,), wrench to apply (6,)
        *fields("qpos_address", "qvel_address", "applied_address", kind="i8"),
        ("constraint_address", "i8"),  # of its constraint forces (6,)
        # of the world: poses of movers, what geoms and bodies may touch
        *fields("mocap_pos_address", "mocap_quat_address", kind="i8"),
        *fields("geom_bits_address", "body_bits_address", kind="i8"),
        *fields("n_geoms", "n_bodies", kind="i8"),
        # of what has no fixed size, and its rows (`flightsim.plant.surroundings`)
        *fields("movers_address", "mover_points_address", "rooms_address", kind="i8"),
        *fields("shelter_address", "steel_address", "normals_address", kind="i8"),
        ("history_address", "i8"),
        *fields("n_movers", "n_mover_points", "n_rooms", "n_steel", "n_normals", kind="i8"),
        ("shelter_shape", "i8", 3),
        ("vehicle_body", "i4"),
        ("no_command", "f8", MAX_ROTORS),
    ],
    align=True,
)

_OF_ROTORS = ("rotor_command_radps", "rotor_speed_radps")


def history_dtype(n_rotors: int) -> np.dtype:
    """One control tick of the log of a vehicle with so many rotors."""
    return np.dtype(
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
            *fields(*_OF_ROTORS, shape=(n_rotors,)),
        ],
        align=True,
    )


HISTORY_DTYPE = history_dtype(MAX_ROTORS)
"""One control tick of the log as the kernel writes it, with room for every rotor."""


def with_rotors(history: np.ndarray, n_rotors: int) -> np.ndarray:
    """The same rows of the log (n,) as a view whose columns of rotors are the vehicle's alone."""
    wide, narrow = HISTORY_DTYPE.fields or {}, history_dtype(n_rotors).fields or {}
    layout: Any = {
        "names": list(narrow),
        "formats": [kind for kind, *_ in narrow.values()],
        "offsets": [wide[name][1] for name in narrow],
        "itemsize": HISTORY_DTYPE.itemsize,
    }
    return history.view(np.dtype(layout))


def without_gaps(history: np.ndarray) -> np.ndarray:
    """Copy of such rows without the room for rotors that the vehicle does not have."""
    (n_rotors,) = history.dtype["rotor_speed_radps"].shape
    return history.astype(history_dtype(n_rotors))


PLANT_DTYPE = np.dtype(
    [
        ("engine", ENGINE_DTYPE),
        ("free_flight", FREE_FLIGHT_DTYPE),
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
