"""Land detector: decides from estimates and commanded thrust whether something carries the vehicle.

A vehicle whose rotors carry clearly less than its weight and that does not sink is carried by
something else. No contact sensor is needed, nor the rangefinder. The difficulty is air: an
updraught carries a part of the weight for seconds. So the detector asks for more time and for less
thrust the farther the rangefinder sees the ground away.
"""

from __future__ import annotations

from math import inf, isfinite, isnan, sqrt

from flightsim.autopilot.parameters import Parameters
from flightsim.autopilot.vehicle import TICK_S, Vehicle

_CARRIED_FRACTION = 0.8
"""Fraction of the hover thrust below which something may carry the vehicle. In the air it would
sink at 2 m/s within a second."""
_HIGH_M, _HIGH_FRACTION = 1.0, 0.5
"""Height by the rangefinder, and fraction of the hover thrust that counts above it. An updraught
carries a part of the weight for seconds. PX4 finds no ground from 1 m on at all, but a vehicle
whose legs stand at an edge may see past it."""
_CARRIED_LOW_S, _CARRIED_LEANING_S, _CARRIED_HIGH_S = 0.1, 0.4, 1.2
"""Time for which something has to carry the vehicle: at the ground, leaning on the legs of one
side, and higher up, as at an edge. A gust from below carries it too, for half a second and more,
and a fall from 0.1 m is a hard landing."""
_LOW_M = 0.04  # up to here the vehicle stands on the ground
_LEAN_M = 0.3
"""Height that a tilt of 90 degrees would explain. A vehicle that leans by 20 degrees is 0.1 m
higher than at rest."""
_SINKING_SHARE, _SINKING_MPS = 0.6, 0.12
"""Share of the commanded speed, and least speed, beyond which the vehicle sinks: nothing carries
it."""
_CONTACT_S = 0.4  # time at an unknown height
_NEAR_GROUND_M = 0.25
# A descent stopped near the ground: for this time, below this height, by this much slower than
# commanded.
_TOUCH_S = 0.04
_TOUCH_HEIGHT_M = 0.06
_TOUCH_STOP_MPS = 0.2
_BARE_DESCENT_MPS = -0.25
"""Assumed speed of a descent to a position without a commanded velocity, until it is stopped."""
_FALL_MPS = 0.8  # falling faster than this, a vehicle that had contact has lost it
_LANDED_S = 1.0  # longer than contact: landed means that the vehicle may be disarmed
_MAX_RATE_RADPS = 0.7
_LIFT_OFF_S = 0.1
_LIFT_OFF_HEIGHT_M = 0.15
_LIFT_OFF_CLIMB_MPS = 0.25


class LandDetector:
    """Updates `vehicle.is_landed`, and detects ground contact before that.

    Attributes:
        has_contact: True while something seems to carry the vehicle. It begins when a commanded
            descent ends within some centimetres of the ground, or when the rotors have carried too
            little for 0.1 s there, longer above it. It ends when the vehicle is lifted, or falls
            and is not near the ground.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._carried_s = 0.0
        self._touching_s = 0.0
        self._lifting_s = 0.0
        self.has_contact = True

    def update(
        self, vehicle: Vehicle, *, is_armed: bool, is_descending: bool, commanded_up_mps: float
    ) -> bool:
        """Process one tick, and return true if the vehicle is landed.

        Args:
            vehicle: Estimates of the vehicle; `is_landed` is written.
            is_armed: True if the rotors may turn.
            is_descending: True if the present behaviour leads down.
            commanded_up_mps: Vertical speed commanded to the inner loops; NaN if none.
        """
        if vehicle.is_landed:
            vehicle.is_landed = not self._is_lifting_off(vehicle, is_armed=is_armed)
            self._carried_s = self._touching_s = 0.0
            self.has_contact = vehicle.is_landed
            # The legs hold the rangefinder above the ground: later heights count from this reading.
            if not is_armed and isfinite(vehicle.range_m):
                vehicle.resting_range_m = vehicle.range_m * vehicle.cos_tilt
            return vehicle.is_landed
        is_told = is_descending and not isnan(commanded_up_mps)
        is_carried = self._is_carried(vehicle, commanded_up_mps if is_told else 0.0)
        self._carried_s = self._carried_s + TICK_S if is_carried else 0.0
        # A setpoint may name a position without a speed; the detector then assumes a slow descent.
        if isnan(commanded_up_mps):
            commanded_up_mps = _BARE_DESCENT_MPS
        # Only a descent that ends early is a touchdown: infinity lets none begin otherwise.
        self._follow_contact(vehicle, commanded_up_mps if is_descending else inf)
        vehicle.is_landed = self._carried_s >= _LANDED_S and _is_still(vehicle)
        return vehicle.is_landed

    def _follow_contact(self, vehicle: Vehicle, commanded_up_mps: float) -> None:
        height_m, up_mps = vehicle.height_m, vehicle.velocity_enu_mps[2]
        if self.has_contact:
            is_lifted = _carries(vehicle) and (
                up_mps > _LIFT_OFF_CLIMB_MPS or (height_m or 0.0) > _NEAR_GROUND_M
            )
            is_falling = up_mps < -_FALL_MPS and (height_m is None or height_m > _NEAR_GROUND_M)
            self.has_contact = not is_lifted and not is_falling
            return
        is_touching = (
            height_m is not None
            and height_m < _TOUCH_HEIGHT_M
            and up_mps > commanded_up_mps + _TOUCH_STOP_MPS
        )
        self._touching_s = self._touching_s + TICK_S if is_touching else 0.0
        enough_s = _enough_s(vehicle)
        self.has_contact = self._touching_s >= _TOUCH_S or self._carried_s >= enough_s

    def _is_carried(self, vehicle: Vehicle, commanded_up_mps: float) -> bool:
        fraction = _HIGH_FRACTION if (vehicle.height_m or 0.0) > _HIGH_M else _CARRIED_FRACTION
        if vehicle.thrust_fraction > fraction * vehicle.hover_thrust_fraction:
            return False
        most_mps, up_mps = self._parameters["LNDMC_Z_VEL_MAX"], vehicle.velocity_enu_mps[2]
        sinking_mps = max(_SINKING_SHARE * -commanded_up_mps, _SINKING_MPS)
        if abs(up_mps) > most_mps or (commanded_up_mps < 0.0 and -up_mps > sinking_mps):
            return False
        return not (
            vehicle.is_position_ok and vehicle.speed_xy_mps > self._parameters["LNDMC_XY_VEL_MAX"]
        )

    def _is_lifting_off(self, vehicle: Vehicle, *, is_armed: bool) -> bool:
        """Return true if the rotors carry the weight and the vehicle rises."""
        if not (is_armed and _carries(vehicle)):
            self._lifting_s = 0.0
            return False
        height_m = vehicle.height_m
        is_rising = vehicle.velocity_enu_mps[2] > _LIFT_OFF_CLIMB_MPS or (
            height_m is not None and height_m > _LIFT_OFF_HEIGHT_M
        )
        self._lifting_s = self._lifting_s + TICK_S if is_rising else 0.0
        return self._lifting_s >= _LIFT_OFF_S


def _enough_s(vehicle: Vehicle) -> float:
    """Time for which something has to carry the vehicle to count as the ground, s."""
    height_m = vehicle.height_m
    if height_m is None:
        return _CONTACT_S
    if height_m < _LOW_M:
        return _CARRIED_LOW_S
    # The sine of the tilt: a vehicle on the legs of one side is that much higher.
    leaning_m = _LEAN_M * sqrt(1.0 - vehicle.cos_tilt**2)
    return _CARRIED_LEANING_S if height_m < _LOW_M + leaning_m else _CARRIED_HIGH_S


def _carries(vehicle: Vehicle) -> bool:
    """Return true if the rotors may carry the weight."""
    return vehicle.thrust_fraction > _CARRIED_FRACTION * vehicle.hover_thrust_fraction


def _is_still(vehicle: Vehicle) -> bool:
    p, q, r = vehicle.angular_rate_flu_radps
    # Compared as squares; a vehicle that still rocks on its legs is not landed.
    return p * p + q * q + r * r < _MAX_RATE_RADPS**2
