"""Steady wind."""

from __future__ import annotations

import math

from autonomy.model.quadrotor import Vector3

MAX_WIND_MPS = 30.0


class WindError(ValueError):
    """A wind that the simulator does not take."""


def wind_towards(velocity_enu_mps: Vector3) -> Vector3:
    """A wind by the velocity of its air, checked.

    Raises:
        WindError: If a component is not finite or the speed exceeds `MAX_WIND_MPS`.
    """
    speed = math.hypot(*velocity_enu_mps)
    if not speed <= MAX_WIND_MPS:
        raise WindError(
            f"wind_enu_mps = {velocity_enu_mps}: three finite numbers with a speed of at most "
            f"{MAX_WIND_MPS:g} m/s are valid"
        )
    east, north, up = velocity_enu_mps
    return (float(east), float(north), float(up))


def wind_from(direction_deg: float, speed_mps: float) -> Vector3:
    """A horizontal wind as meteorologists say it: where it comes from, clockwise from north.

    Raises:
        WindError: As `wind_towards`.
    """
    angle = math.radians(direction_deg)
    return wind_towards((-speed_mps * math.sin(angle), -speed_mps * math.cos(angle), 0.0))
