"""Room between the hulls of a vehicle and of movers.

Upright cylinders and boxes give a distance in closed form for every tick of every flight. They hold
the true hulls, so a gap is never overstated.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from flightsim.environment.movers import ObstacleStates
from flightsim.vehicles.airframe import Airframe


def room_to_movers_m(
    vehicle_enu_m: Float[np.ndarray, 3], airframe: Airframe, movers: ObstacleStates
) -> float:
    """The distance between an upright cylinder around the vehicle and the nearest mover's box.

    Args:
        vehicle_enu_m: Centre of mass of the vehicle.
        airframe: Vehicle: its collision radius, its legs, and its fuselage above them.
        movers: At least one.

    Returns:
        The gap in m; 0 if they overlap.
    """
    away_m = vehicle_enu_m - movers.position_enu_m
    c, s = np.cos(movers.yaw_rad), np.sin(movers.yaw_rad)
    x_m, y_m = c * away_m[:, 0] + s * away_m[:, 1], c * away_m[:, 1] - s * away_m[:, 0]
    half_m = movers.size_m / 2
    beside_m = np.hypot(
        np.maximum(np.abs(x_m) - half_m[:, 0], 0.0), np.maximum(np.abs(y_m) - half_m[:, 1], 0.0)
    )
    beside_m = np.maximum(beside_m - airframe.collision_radius_m, 0.0)
    # Down to the legs' ends below the centre, but only half the fuselage above it.
    above_m = away_m[:, 2] - airframe.leg_length_m - half_m[:, 2]
    below_m = -away_m[:, 2] - airframe.body_size_m[2] / 2 - half_m[:, 2]
    gap_m = np.hypot(beside_m, np.maximum(np.maximum(above_m, below_m), 0.0))
    return float(gap_m.min())


def room_to_vehicle_m(
    own_enu_m: Float[np.ndarray, "n 3"],
    own: Airframe,
    other_enu_m: Float[np.ndarray, "n 3"],
    other: Airframe,
) -> Float[np.ndarray, " n"]:
    """Return the distances between upright cylinders around two vehicles, m.

    Args:
        own_enu_m: Centres of mass of one vehicle.
        own: Its collision radius, its legs, and its fuselage above them.
        other_enu_m: Centres of mass of the other one at the same times.
        other: The same of the other one.
    """
    away_m = own_enu_m - other_enu_m
    beside_m = np.hypot(away_m[:, 0], away_m[:, 1])
    beside_m = np.maximum(beside_m - own.collision_radius_m - other.collision_radius_m, 0.0)
    above_m = away_m[:, 2] - own.leg_length_m - other.body_size_m[2] / 2
    below_m = -away_m[:, 2] - other.leg_length_m - own.body_size_m[2] / 2
    return np.hypot(beside_m, np.maximum(np.maximum(above_m, below_m), 0.0))
