"""Motion limits from parameters, and the speeds that clients and missions ask for."""

from __future__ import annotations

from flightsim.autopilot.limits import MotionLimits
from flightsim.autopilot.parameters import Parameters


class FlightLimits:
    """Limits of each kind of flight: the same objects until a parameter or a speed changes.

    Attributes:
        automatic: Limits of automatic flight.
        takeoff: Limits of a takeoff.
        sticks: Limits of position and altitude mode.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._cruise_mps: float | None = None
        self._climb_mps: float | None = None
        self._descent_mps: float | None = None
        self._build()
        parameters.add_listener(lambda _spec, _value: self._build())

    def use_speeds(
        self,
        *,
        cruise_mps: float | None = None,
        climb_mps: float | None = None,
        descent_mps: float | None = None,
    ) -> None:
        """Set the speeds of automatic flight; None is the parameter's."""
        wanted = (cruise_mps, climb_mps, descent_mps)
        if wanted != (self._cruise_mps, self._climb_mps, self._descent_mps):
            self._cruise_mps, self._climb_mps, self._descent_mps = wanted
            self._build()

    def change_speeds(
        self,
        *,
        cruise_mps: float | None = None,
        climb_mps: float | None = None,
        descent_mps: float | None = None,
    ) -> None:
        """Set some of the speeds of automatic flight; None leaves one as it is."""
        self.use_speeds(
            cruise_mps=cruise_mps or self._cruise_mps,
            climb_mps=climb_mps or self._climb_mps,
            descent_mps=descent_mps or self._descent_mps,
        )

    def _build(self) -> None:
        p = self._parameters
        speed_xy_mps = min(self._cruise_mps or p["MPC_XY_CRUISE"], p["MPC_XY_VEL_MAX"])
        climb_mps = self._climb_mps or p["MPC_Z_V_AUTO_UP"]
        descent_mps = self._descent_mps or p["MPC_Z_V_AUTO_DN"]
        acceleration_mps2, jerk_mps3 = p["MPC_ACC_HOR"], p["MPC_JERK_AUTO"]
        self.automatic = self._limits(
            speed_xy_mps, climb_mps, descent_mps, acceleration_mps2, jerk_mps3
        )
        self.takeoff = self._limits(
            speed_xy_mps, p["MPC_TKO_SPEED"], descent_mps, acceleration_mps2, jerk_mps3
        )
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
            speed_up_mps=min(climb_mps, p["MPC_Z_VEL_MAX_UP"]),
            speed_down_mps=min(descent_mps, p["MPC_Z_VEL_MAX_DN"]),
            acceleration_xy_mps2=acceleration_xy_mps2,
            acceleration_up_mps2=p["MPC_ACC_UP_MAX"],
            acceleration_down_mps2=p["MPC_ACC_DOWN_MAX"],
            jerk_mps3=jerk_mps3,
        )
