"""Motion limits from parameters, and speeds requested by clients and missions."""

from __future__ import annotations

from dataclasses import dataclass

from flightsim.autopilot.limits import MotionLimits
from flightsim.autopilot.parameters import Parameters


@dataclass(frozen=True, kw_only=True, slots=True)
class SpeedRequests:
    """Requested speeds of automatic flight, m/s; None uses the parameter."""

    cruise_mps: float | None = None
    climb_mps: float | None = None
    descent_mps: float | None = None


class FlightLimits:
    """Limits of each kind of flight: the same objects until a parameter or a speed changes.

    A behaviour can therefore notice a change by identity, and plans its leg anew only then.

    Attributes:
        automatic: Limits of automatic flight.
        takeoff: Limits of a takeoff.
        sticks: Limits of position and altitude modes.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._speeds = SpeedRequests()
        self._pilot_speeds_limit_all = True
        self._build()
        parameters.add_listener(lambda _spec, _value: self._build())

    @property
    def speeds(self) -> SpeedRequests:
        """Requested speeds; setting them takes effect at once."""
        return self._speeds

    @speeds.setter
    def speeds(self, speeds: SpeedRequests) -> None:
        if speeds != self._speeds:
            self._speeds = speeds
            self._build()

    @property
    def pilot_speeds_limit_all(self) -> bool:
        """True if the sticks' greatest climb and descent bound automatic flight too (PX4)."""
        return self._pilot_speeds_limit_all

    @pilot_speeds_limit_all.setter
    def pilot_speeds_limit_all(self, is_so: bool) -> None:
        self._pilot_speeds_limit_all = is_so
        self._build()

    def _build(self) -> None:
        p = self._parameters
        speed_xy_mps = min(self._speeds.cruise_mps or p["MPC_XY_CRUISE"], p["MPC_XY_VEL_MAX"])
        climb_mps = self._speeds.climb_mps or p["MPC_Z_V_AUTO_UP"]
        descent_mps = self._speeds.descent_mps or p["MPC_Z_V_AUTO_DN"]
        takeoff_mps = p["MPC_TKO_SPEED"]
        if self._pilot_speeds_limit_all:
            climb_mps = min(climb_mps, p["MPC_Z_VEL_MAX_UP"])
            takeoff_mps = min(takeoff_mps, p["MPC_Z_VEL_MAX_UP"])
            descent_mps = min(descent_mps, p["MPC_Z_VEL_MAX_DN"])
        # Automatic flight is gentler than sticks: its acceleration and jerk have parameters of
        # their own.
        gentle = (descent_mps, p["MPC_ACC_HOR"], p["MPC_JERK_AUTO"])
        self.automatic = self._limits(speed_xy_mps, climb_mps, *gentle)
        self.takeoff = self._limits(speed_xy_mps, takeoff_mps, *gentle)
        self.sticks = self._limits(
            min(p["MPC_VEL_MANUAL"], p["MPC_XY_VEL_MAX"]),
            p["MPC_Z_VEL_MAX_UP"],
            p["MPC_Z_VEL_MAX_DN"],
            p["MPC_ACC_HOR_MAX"],
            p["MPC_JERK_MAX"],
        )

    def _limits(
        self,
        speed_xy_mps: float,
        climb_mps: float,
        descent_mps: float,
        acceleration_xy_mps2: float,
        jerk_mps3: float,
    ) -> MotionLimits:
        p = self._parameters
        return MotionLimits(
            speed_xy_mps=speed_xy_mps,
            speed_up_mps=climb_mps,
            speed_down_mps=descent_mps,
            acceleration_xy_mps2=acceleration_xy_mps2,
            acceleration_up_mps2=p["MPC_ACC_UP_MAX"],
            acceleration_down_mps2=p["MPC_ACC_DOWN_MAX"],
            jerk_mps3=jerk_mps3,
        )
