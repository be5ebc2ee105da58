"""Actions at four levels: four numbers of -1 to 1 for each vehicle, to set points.

level     numbers
motors    thrust of each rotor: -1 none, 0 that of hover, 1 the most; in the airframe's order
rates     collective thrust, likewise; body rates about FLU x, y, z over 6, 6 and 3 rad/s
velocity  east, north, up over 5, 5 and 3 m/s; yaw rate over 1.5 rad/s
position  displacement east, north, up over 2 m from the vehicle; yaw rate over 1.5 rad/s

Zero is the thrust of hover, no rotation, no velocity or no displacement, so that a policy begins
near hover.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float

from autonomy.model.quadrotor import GRAVITY_MPS2
from autonomy.types import ControlLevel
from flightsim.plant import Fleet
from flightsim.vehicles.airframe import Airframe
from scenarios.environments.cfg import ActionLevel, EnvironmentInputError

N_ACTIONS = 4
_MOST_RATE_RADPS = np.array([6.0, 6.0, 3.0])
_MOST_VELOCITY_MPS = np.array([5.0, 5.0, 3.0])
_MOST_YAW_RATE_RADPS = 1.5
_MOST_DISPLACEMENT_M = 2.0
_LEVELS = {
    "motors": ControlLevel.OFF,  # at which the rotors turn at given speeds
    "rates": ControlLevel.RATE,
    "velocity": ControlLevel.TRAJECTORY,
    "position": ControlLevel.TRAJECTORY,
}


def checked_actions(actions: object, shape: tuple[int, ...]) -> Float[np.ndarray, "*n 4"]:
    """Return actions as an array, clipped to -1 to 1.

    Raises:
        EnvironmentInputError: If the shape is another one, or a number is not finite.
    """
    try:
        array = np.asarray(actions, dtype=np.float64)
    except (TypeError, ValueError):
        raise EnvironmentInputError(
            f"action = {actions!r}: numbers of -1 to 1 in an array of shape {shape} are valid"
        ) from None
    if array.shape != shape:
        raise EnvironmentInputError(
            f"action: its shape is {array.shape}; numbers of -1 to 1 in shape {shape} are valid"
        )
    if not np.isfinite(array).all():
        where = tuple(np.argwhere(~np.isfinite(array))[0].tolist())
        place = ", ".join(map(str, where))
        raise EnvironmentInputError(
            f"action[{place}] = {array[where]}: finite numbers of -1 to 1 are valid"
        )
    # Not `np.clip`, which takes longer for small arrays.
    return np.minimum(np.maximum(array, -1.0), 1.0)


def check_motors(level: ActionLevel, airframe: Airframe) -> None:
    """Refuse motor commands for a vehicle with more motors than an action has numbers.

    Raises:
        EnvironmentInputError: If the level is "motors" and the vehicle has not four motors.
    """
    n_motors = len(airframe.quadrotor.rotors)
    if level == "motors" and n_motors != N_ACTIONS:
        raise EnvironmentInputError(
            f"action = 'motors': {airframe.name} has {n_motors} motors; rates, velocity, position "
            "are valid"
        )


class Actuation:
    """Writes actions into the set points of a fleet."""

    def __init__(self, fleet: Fleet, level: ActionLevel) -> None:
        self._fleet, self._level = fleet, level
        airframes = [world.airframe for world in fleet.worlds]
        self._hover_share = np.array([_hover_share(airframe) for airframe in airframes])[:, None]
        self._most_speed_radps = np.array(
            [[r.max_speed_radps for r in airframe.quadrotor.rotors] for airframe in airframes]
        )

    def apply(
        self, actions: Float[np.ndarray, "n 4"], position_enu_m: Float[np.ndarray, "n 3"]
    ) -> None:
        """Command actions from the next advance on.

        Args:
            actions: Checked actions.
            position_enu_m: Position of each vehicle by its own knowledge.
        """
        setpoints = self._fleet.setpoints
        setpoints["level"] = _LEVELS[self._level]
        if self._level == "motors":
            share = self._thrust_share(actions)
            # Thrust grows with the square of the speed.
            self._fleet.motor_speeds_radps[:] = self._most_speed_radps * np.sqrt(share)
        elif self._level == "rates":
            setpoints["thrust"] = self._thrust_share(actions[:, :1])[:, 0]
            setpoints["angular_rate_flu_radps"] = _MOST_RATE_RADPS * actions[:, 1:]
        else:
            setpoints["yaw_rate_radps"] = _MOST_YAW_RATE_RADPS * actions[:, 3]
            if self._level == "velocity":
                setpoints["velocity_enu_mps"] = _MOST_VELOCITY_MPS * actions[:, :3]
            else:
                away_m = _MOST_DISPLACEMENT_M * actions[:, :3]
                setpoints["position_enu_m"] = position_enu_m + away_m

    def stop(self, which: int | Bool[np.ndarray, " n"]) -> None:
        """Stop the rotors of one vehicle, or of several, from the next advance on."""
        self._fleet.setpoints["level"][which] = ControlLevel.OFF
        self._fleet.motor_speeds_radps[which] = 0.0

    def _thrust_share(self, number: Float[np.ndarray, "n k"]) -> Float[np.ndarray, "n k"]:
        """Return the share of the greatest thrust: none at -1, hover's share at 0, all at 1."""
        hover = self._hover_share
        return np.where(number < 0.0, hover * (1.0 + number), hover + (1.0 - hover) * number)


def _hover_share(airframe: Airframe) -> float:
    return airframe.quadrotor.mass_kg * GRAVITY_MPS2 / airframe.quadrotor.max_thrust_n
