"""Actions at five levels: four numbers of -1 to 1 for each vehicle, to set points.

level     numbers
motors    thrust of each rotor: -1 none, 0 that of hover, 1 the most; in the airframe's order
rates     collective thrust, likewise; body rates about FLU x, y, z over 6, 6 and 3 rad/s
attitude  collective thrust, likewise; roll and pitch about FLU x, y over 0.6 rad; heading over
          0.5 rad from the present one
velocity  east, north, up over 5, 5 and 3 m/s; yaw rate over 1.5 rad/s
position  displacement east, north, up over 2 m from the vehicle; yaw rate over 1.5 rad/s

Zero is the thrust of hover, no rotation, no velocity or no displacement, so that a policy begins
near hover. The numbers become the fields of a set point in one place (`commands`), whoever then
follows it: the plant's own controller, or an autopilot that gets it by MAVLink.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

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
_MOST_TILT_RAD = 0.6
_MOST_TURN_RAD = 0.5
_LEVELS = {
    "motors": ControlLevel.OFF,  # at which the rotors turn at given speeds
    "rates": ControlLevel.RATE,
    "attitude": ControlLevel.ATTITUDE,
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
            f"action = 'motors': {airframe.name} has {n_motors} motors; rates, attitude, velocity, "
            "position are valid"
        )


class ActionScale:
    """Converts actions at one level into the fields of set points, for vehicles in a row."""

    def __init__(self, airframes: Sequence[Airframe], level: ActionLevel) -> None:
        """Prepare the conversion.

        Args:
            airframes: Airframe of each of n vehicles, with equal numbers of rotors.
            level: Meaning of the actions.
        """
        self._level: ActionLevel = level
        self.control_level = _LEVELS[level]
        self._hover_share = np.array([_hover_share(airframe) for airframe in airframes])[:, None]
        self._most_speed_radps = np.array(
            [[r.max_speed_radps for r in airframe.quadrotor.rotors] for airframe in airframes]
        )

    def motor_speeds_radps(self, actions: Float[np.ndarray, "n 4"]) -> Float[np.ndarray, "n 4"]:
        """Return the rotor speeds of actions at the level "motors"."""
        # Thrust grows with the square of the speed.
        return self._most_speed_radps * np.sqrt(self._thrust_share(actions))

    def commands(
        self,
        actions: Float[np.ndarray, "n 4"],
        position_enu_m: Float[np.ndarray, "n 3"],
        quat_wxyz: Float[np.ndarray, "n 4"],
    ) -> Mapping[str, np.ndarray]:
        """Return the fields of set points by their names in `autonomy.types.Setpoint`.

        Fields that are not named keep the values of a new set point. The level "motors" has none.

        Args:
            actions: Checked actions.
            position_enu_m: Position of each vehicle by its own knowledge.
            quat_wxyz: Its attitude, body to ENU, likewise.
        """
        if self._level == "motors":
            return {}
        if self._level in {"velocity", "position"}:
            yaw_rate = _MOST_YAW_RATE_RADPS * actions[:, 3]
            if self._level == "velocity":
                velocity = _MOST_VELOCITY_MPS * actions[:, :3]
                return {"velocity_enu_mps": velocity, "yaw_rate_radps": yaw_rate}
            away_m = _MOST_DISPLACEMENT_M * actions[:, :3]
            return {"position_enu_m": position_enu_m + away_m, "yaw_rate_radps": yaw_rate}
        thrust = self._thrust_share(actions[:, :1])[:, 0]
        if self._level == "rates":
            return {"thrust": thrust, "angular_rate_flu_radps": _MOST_RATE_RADPS * actions[:, 1:]}
        return {"thrust": thrust, "quat_wxyz": _attitudes(actions[:, 1:], quat_wxyz)}

    def _thrust_share(self, number: Float[np.ndarray, "n k"]) -> Float[np.ndarray, "n k"]:
        """Return the share of the greatest thrust: none at -1, hover's share at 0, all at 1."""
        hover = self._hover_share
        return np.where(number < 0.0, hover * (1.0 + number), hover + (1.0 - hover) * number)


class Actuation:
    """Writes actions into the set points of a fleet, whose own controller follows them."""

    def __init__(self, fleet: Fleet, level: ActionLevel) -> None:
        self._fleet, self._level = fleet, level
        self._scale = ActionScale([world.airframe for world in fleet.worlds], level)

    def apply(
        self,
        actions: Float[np.ndarray, "n 4"],
        position_enu_m: Float[np.ndarray, "n 3"],
        quat_wxyz: Float[np.ndarray, "n 4"],
    ) -> None:
        """Command actions from the next advance on.

        Args:
            actions: Checked actions.
            position_enu_m: Position of each vehicle by its own knowledge.
            quat_wxyz: Its attitude, body to ENU, likewise.
        """
        setpoints = self._fleet.setpoints
        setpoints["level"] = self._scale.control_level
        if self._level == "motors":
            self._fleet.motor_speeds_radps[:] = self._scale.motor_speeds_radps(actions)
        for name, value in self._scale.commands(actions, position_enu_m, quat_wxyz).items():
            setpoints[name] = value

    def stop(self, which: int | Bool[np.ndarray, " n"]) -> None:
        """Stop the rotors of one vehicle, or of several, from the next advance on."""
        self._fleet.setpoints["level"][which] = ControlLevel.OFF
        self._fleet.motor_speeds_radps[which] = 0.0


def _hover_share(airframe: Airframe) -> float:
    return airframe.quadrotor.mass_kg * GRAVITY_MPS2 / airframe.quadrotor.max_thrust_n


def _attitudes(
    numbers: Float[np.ndarray, "n 3"], quat_wxyz: Float[np.ndarray, "n 4"]
) -> Float[np.ndarray, "n 4"]:
    """Return attitudes, body to ENU: roll, pitch, and a turn from the present heading."""
    w, x, y, z = quat_wxyz.T
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    roll, pitch = _MOST_TILT_RAD * numbers[:, :2].T
    halves = 0.5 * np.stack([roll, pitch, yaw + _MOST_TURN_RAD * numbers[:, 2]])
    (cr, cp, cy), (sr, sp, sy) = np.cos(halves), np.sin(halves)
    # Heading times pitch times roll, multiplied out.
    return np.stack(
        [
            cy * cp * cr + sy * sp * sr,
            cy * cp * sr - sy * sp * cr,
            cy * sp * cr + sy * cp * sr,
            sy * cp * cr - cy * sp * sr,
        ],
        axis=1,
    )
