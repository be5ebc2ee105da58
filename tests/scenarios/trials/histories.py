"""Short histories of flights that never were."""

import math

import numpy as np

from aeroscene.scene import InteractionArea
from autonomy.model.quadrotor import GRAVITY_MPS2
from autonomy.types import ControlLevel
from flightsim.plant.record import history_dtype
from flightsim.vehicles.catalogue import AIRFRAMES

LEG_M = AIRFRAMES["iris"].leg_length_m
TICK_US = 4_000
_IRIS = AIRFRAMES["iris"].quadrotor
HOVER = math.sqrt(
    _IRIS.mass_kg * GRAVITY_MPS2 / sum(rotor.thrust_constant for rotor in _IRIS.rotors)
)
"""Rotor speed of an Iris in hover, rad/s."""


def square(number, centre, half_m):
    (x, y, z), h = centre, half_m
    return InteractionArea(
        id=number,
        object_id=None,
        polygon=((x - h, y - h, z), (x + h, y - h, z), (x + h, y + h, z), (x - h, y + h, z)),
        centroid=centre,
        radius=half_m,
        drone_class="medium",
        slope_rad=0.0,
        clearance_m=20.0,
        surface="concrete",
    )


AREA = square(3, (10.0, 0.0, 2.0), 1.0)
BESIDE = square(4, (14.0, 0.0, 0.0), 1.0)
START, AIR = (0.0, 0.0, LEG_M), (5.0, 0.0, 8.0)
LANDED = (10.2, 0.1, 2.0 + LEG_M)


def flight(*segments, quat_wxyz=(1.0, 0.0, 0.0, 0.0)):
    """History of segments at rest: seconds, position, whether it touches, speed of its rotors."""
    rows = [np.zeros(round(segment[0] * 1e6) // TICK_US, history_dtype(4)) for segment in segments]
    for part, (_, position, is_touching, *rotor_radps) in zip(rows, segments, strict=True):
        part["position_true_enu_m"] = part["position_est_enu_m"] = position
        part["is_touching"] = is_touching
        part["rotor_speed_radps"] = rotor_radps[0] if rotor_radps else 0.0
    history = np.concatenate(rows)
    history["time_us"] = np.arange(1, len(history) + 1) * TICK_US
    history["quat_true_wxyz"] = history["quat_est_wxyz"] = quat_wxyz
    history["setpoint_level"] = ControlLevel.TRAJECTORY
    return history
