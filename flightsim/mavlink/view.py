"""Vehicle state in MAVLink's frames: NED relative to the start, FRD and geodetic."""

from __future__ import annotations

import math

from autonomy.types import State, Vector3
from flightsim.autopilot.autopilot import Autopilot
from flightsim.frames import (
    LocalFrame,
    euler_rpy_rad,
    swap_enu_ned,
    swap_flu_frd,
    swap_quat_enu_flu_ned_frd,
)
from flightsim.plant import Plant


class VehicleView:
    """State of one tick that many messages share, converted once.

    MAVLink's local frame has its origin at the vehicle's start, as in PX4's estimator: scripts fly
    to (0, 0, -5) right after arming and mean five metres straight up.
    """

    def __init__(
        self, plant: Plant, autopilot: Autopilot, frame: LocalFrame, local_origin_enu_m: Vector3
    ) -> None:
        self.plant = plant
        self.autopilot = autopilot
        self.frame = frame
        self.origin_enu_m = local_origin_enu_m
        self.origin = frame.geodetic_from_enu(local_origin_enu_m)
        self.has_estimate = False
        """Whether the estimator has ever been aligned; before that, its numbers mean nothing."""
        self.refresh()

    def refresh(self) -> None:
        """Convert the estimate of the present tick."""
        state: State = self.plant.estimate
        self.has_estimate = self.has_estimate or self.plant.estimator.is_attitude_valid
        self.time_us = self.plant.time_us
        self.time_boot_ms = self.time_us // 1000 & 0xFFFFFFFF
        self.position_ned_m = self.ned_from_enu(state.position_enu_m)
        self.velocity_ned_mps = swap_enu_ned(state.velocity_enu_mps)
        self.quat_ned_frd = swap_quat_enu_flu_ned_frd(state.quat_wxyz)
        self.rpy_rad = euler_rpy_rad(self.quat_ned_frd)
        self.rates_frd_radps = swap_flu_frd(state.angular_rate_flu_radps)
        self.place = self.frame.geodetic_from_enu(state.position_enu_m)

    def ned_from_enu(self, position_enu_m: Vector3) -> Vector3:
        """Convert a position from the scene's frame to MAVLink's local frame."""
        east, north, up = position_enu_m
        x0, y0, z0 = self.origin_enu_m
        return (north - y0, east - x0, z0 - up)

    def enu_from_ned(self, position_ned_m: Vector3) -> Vector3:
        """Convert a position from MAVLink's local frame to the scene's."""
        north, east, down = position_ned_m
        x0, y0, z0 = self.origin_enu_m
        return (east + x0, north + y0, z0 - down)

    @property
    def home_altitude_m(self) -> float:
        """Altitude of home above mean sea level, or of the start while there is no home."""
        home = self.autopilot.home
        return self.origin.altitude_m if home is None else home.geodetic.altitude_m

    @property
    def heading_deg(self) -> float:
        """Heading in degrees clockwise from north, 0 to 360."""
        return math.degrees(self.rpy_rad[2]) % 360.0
