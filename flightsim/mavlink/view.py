"""Vehicle state in MAVLink's frames: NED relative to the start, FRD and geodetic."""

from __future__ import annotations

import math

from autonomy.types import Quaternion, Vector3
from flightsim.autopilot.autopilot import Autopilot
from flightsim.environment.date import EPOCH_US
from flightsim.frames import (
    Geodetic,
    LocalFrame,
    euler_rpy_rad,
    swap_enu_ned,
    swap_flu_frd,
    swap_quat_enu_flu_ned_frd,
)
from flightsim.plant import Plant

_OLDEST_US = 250_000
"""Age of the oldest measurement that the filter can still use."""


class VehicleView:
    """State of the vehicle now, converted when it is asked for.

    Values that are streamed many times a second are converted by `flightsim.mavlink.streaming`
    instead.

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

    @property
    def time_us(self) -> int:
        """Simulated time, microseconds."""
        return self.plant.time_us

    @property
    def time_boot_ms(self) -> int:
        """Simulated time in MAVLink's 32 bits, which begins again after 49 days."""
        return self.plant.time_us // 1000 & 0xFFFFFFFF

    @property
    def position_ned_m(self) -> Vector3:
        """Estimated position in MAVLink's local frame."""
        return self.ned_from_enu(self.plant.estimate.position_enu_m)

    @property
    def velocity_ned_mps(self) -> Vector3:
        """Estimated velocity."""
        return swap_enu_ned(self.plant.estimate.velocity_enu_mps)

    @property
    def quat_ned_frd(self) -> Quaternion:
        """Estimated attitude, FRD to NED."""
        return swap_quat_enu_flu_ned_frd(self.plant.estimate.quat_wxyz)

    @property
    def rpy_rad(self) -> Vector3:
        """Estimated roll, pitch and yaw, FRD to NED."""
        return euler_rpy_rad(self.quat_ned_frd)

    @property
    def rates_frd_radps(self) -> Vector3:
        """Estimated angular rate about forward, right and down."""
        return swap_flu_frd(self.plant.estimate.angular_rate_flu_radps)

    @property
    def place(self) -> Geodetic:
        """Estimated latitude, longitude and altitude."""
        return self.frame.geodetic_from_enu(self.plant.estimate.position_enu_m)

    def ned_from_enu(self, position_enu_m: Vector3) -> Vector3:
        """Convert a position from the scene's frame (ENU) to MAVLink's local frame (NED), m."""
        east, north, up = position_enu_m
        x0, y0, z0 = self.origin_enu_m
        # ENU (x0, y0, z0) is the origin: north is y, east is x, down is -z.
        return (north - y0, east - x0, z0 - up)

    def enu_from_ned(self, position_ned_m: Vector3) -> Vector3:
        """Convert a position from MAVLink's local frame (NED) to the scene's (ENU), m."""
        north, east, down = position_ned_m
        x0, y0, z0 = self.origin_enu_m
        return (east + x0, north + y0, z0 - down)

    @property
    def home_altitude_m(self) -> float:
        """Altitude of home above mean sea level, or of the start while there is no home."""
        home = self.autopilot.home
        return self.origin.altitude_m if home is None else home.geodetic.altitude_m

    def age_s(self, time_us: int) -> float:
        """Return the age of a measurement by its time stamp, s.

        Args:
            time_us: The stamp, counted from the vehicle's start or from 1970 by its date.

        Returns:
            0 if the stamp belongs to another clock, or is older than the filter can use.
        """
        for stamp_us in (time_us, time_us - EPOCH_US):
            if 0 <= self.plant.time_us - stamp_us <= _OLDEST_US:
                return 1e-6 * (self.plant.time_us - stamp_us)
        return 0.0

    @property
    def heading_deg(self) -> float:
        """Heading in degrees clockwise from north, 0 to 360."""
        return math.degrees(self.rpy_rad[2]) % 360.0
