"""Decides from estimates and commanded thrust whether the vehicle stands on something.

The reasoning is physics: a vehicle whose rotors carry clearly less than its weight and that does
not sink is carried by something else. Contact sensors are not needed, nor the rangefinder.
"""

from __future__ import annotations

from math import isfinite

from flightsim.autopilot.parameters import Parameters
from flightsim.autopilot.vehicle import TICK_S, Vehicle

_CARRIED_FRACTION = 0.8
"""Of the hover thrust. In the air the vehicle would sink at 2 m/s within a second."""
_CONTACT_AFTER_S = 0.3
_LANDED_AFTER_S = 1.0
_MAX_RATE_RADPS = 0.7
_LIFT_OFF_AFTER_S = 0.1
_LIFT_OFF_HEIGHT_M = 0.15
_LIFT_OFF_CLIMB_MPS = 0.25


class LandDetector:
    """Keeps `vehicle.is_landed` and whether there is ground contact."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._carried_s = 0.0
        self._lifting_s = 0.0

    @property
    def has_contact(self) -> bool:
        """Whether the vehicle seems to touch down, before that counts as landed."""
        return self._carried_s >= _CONTACT_AFTER_S

    def update(self, vehicle: Vehicle, *, is_armed: bool) -> bool:
        """Take a tick in, and return whether the vehicle is landed."""
        if vehicle.is_landed:
            vehicle.is_landed = not self._is_lifting_off(vehicle, is_armed=is_armed)
            if not vehicle.is_landed:
                self._carried_s = 0.0
        else:
            self._carried_s = self._carried_s + TICK_S if self._is_carried(vehicle) else 0.0
            if self._carried_s >= _LANDED_AFTER_S:
                vehicle.is_landed = True
        if vehicle.is_landed and not is_armed and isfinite(vehicle.range_m):
            vehicle.resting_range_m = vehicle.range_m * vehicle.cos_tilt
        return vehicle.is_landed

    def _is_carried(self, vehicle: Vehicle) -> bool:
        if vehicle.thrust_fraction > _CARRIED_FRACTION * vehicle.hover_thrust_fraction:
            return False
        if abs(vehicle.velocity_enu_mps[2]) > self._parameters["LNDMC_Z_VEL_MAX"]:
            return False
        if vehicle.is_position_ok and vehicle.speed_xy_mps > self._parameters["LNDMC_XY_VEL_MAX"]:
            return False
        p, q, r = vehicle.angular_rate_flu_radps
        return p * p + q * q + r * r < _MAX_RATE_RADPS**2

    def _is_lifting_off(self, vehicle: Vehicle, *, is_armed: bool) -> bool:
        """Whether the rotors carry the weight and the vehicle rises."""
        if not is_armed or vehicle.thrust_fraction < (
            _CARRIED_FRACTION * vehicle.hover_thrust_fraction
        ):
            self._lifting_s = 0.0
            return False
        height_m = vehicle.height_m
        is_rising = vehicle.velocity_enu_mps[2] > _LIFT_OFF_CLIMB_MPS or (
            height_m is not None and height_m > _LIFT_OFF_HEIGHT_M
        )
        self._lifting_s = self._lifting_s + TICK_S if is_rising else 0.0
        return self._lifting_s >= _LIFT_OFF_AFTER_S
