"""Record of a plant: its engine, all of its parts, and its log.

One numpy record holds the complete state of a vehicle, because a compiled kernel reads its fields
without any Python object, and Python can read the same fields at any time. Arrays whose size
depends on the scene stay outside and are named by address.
"""

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
        ("knows_truth", "i8"),  # 1: the controller gets the true state, not the estimate
        ("has_sensors", "i8"),  # 0: nothing is measured and estimated
        ("is_held", "i8"),  # 1: the vehicle is held where it is
        ("is_lost", "i8"),  # 1: the engine gave its state up and began anew
        # functions of MuJoCo
        *fields("step_address", "kinematics_address", "clock_address", kind="i8"),
        ("rays", RAYS_DTYPE),
        *fields("model_address", "data_address", "time_address", kind="i8"),
        # the vehicle in MuJoCo's memory: pose (7,), velocity (6,), wrench to apply (6,)
        *fields("qpos_address", "qvel_address", "applied_address", kind="i8"),
        ("constraint_address", "i8"),  # its constraint forces (6,)
        # the world in MuJoCo's memory: poses of movers, contact bits of geoms and bodies
        *fields("mocap_pos_address", "mocap_quat_address", kind="i8"),
        *fields("geom_bits_address", "body_bits_address", kind="i8"),
        *fields("n_geoms", "n_bodies", kind="i8"),
        # arrays without a fixed size, and their rows (`flightsim.plant.surroundings`)
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

_ROTOR_COLUMNS = ("rotor_command_radps", "rotor_speed_radps")


def history_dtype(n_rotors: int) -> np.dtype:
    """Return the type of one control tick of the log, for a vehicle with this number of rotors."""
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
            *fields(*_ROTOR_COLUMNS, shape=(n_rotors,)),
        ],
        align=True,
    )


HISTORY_DTYPE = history_dtype(MAX_ROTORS)
"""One control tick of the log as the kernel writes it, with room for every rotor."""


def with_rotors(history: np.ndarray, n_rotors: int) -> np.ndarray:
    """Return the rows of a log as a view whose rotor columns are the vehicle's alone.

    Args:
        history: Rows (n,) of `HISTORY_DTYPE`, which has room for the most rotors.
        n_rotors: Number of the vehicle's rotors.
    """
    wide, narrow = HISTORY_DTYPE.fields or {}, history_dtype(n_rotors).fields or {}
    layout: Any = {
        "names": list(narrow),
        "formats": [kind for kind, *_ in narrow.values()],
        "offsets": [wide[name][1] for name in narrow],
        "itemsize": HISTORY_DTYPE.itemsize,
    }
    return history.view(np.dtype(layout))


def without_gaps(history: np.ndarray) -> np.ndarray:
    """Return a copy of such rows without the unused room for rotors, as files store them.

    Args:
        history: Rows as `with_rotors` returns them.
    """
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
"""Complete state of a plant. Sensors come in one run before the filter; `memory._written` relies on
it."""
