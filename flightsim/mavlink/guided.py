"""ArduPilot's guided mode: it follows setpoints and single items without a change of mode.

PX4 separates hold (a place) from offboard (a stream); ArduPilot has one GUIDED mode for both. This
module chooses between our two modes by what comes, so that clients of ArduPilot see one mode.
"""

from __future__ import annotations

import math

from autonomy.model.quadrotor import GRAVITY_MPS2
from autonomy.types import NAN3, ControlLevel, Setpoint, yaw_of
from flightsim.autopilot.mission_item import FRAME_GLOBAL, MissionItem
from flightsim.autopilot.modes import LandedState, Mode
from flightsim.autopilot.results import Reply, rejected
from flightsim.frames import Geodetic
from flightsim.mavlink.mode_report import ModeReport
from flightsim.mavlink.view import VehicleView

_SAME_PLACE_M = 0.01
"""Distance within which a place counts as repeated: a stream of one place starts one flight."""
_GUIDED_MODES = frozenset({Mode.HOLD, Mode.TAKEOFF, Mode.OFFBOARD})


class GuidedInput:
    """Setpoints and single mission items that are flown while the vehicle is guided."""

    def __init__(self, view: VehicleView, modes: ModeReport) -> None:
        self._view = view
        self._modes = modes

    @property
    def is_guided(self) -> bool:
        """True if the vehicle flies and follows guided requests."""
        is_flying = self._view.autopilot.landed_state is not LandedState.ON_GROUND
        return is_flying and self._is_ready

    @property
    def _is_ready(self) -> bool:
        """True if guided requests are followed, or would be if the vehicle flew."""
        autopilot = self._view.autopilot
        is_chosen = Mode.OFFBOARD in self._modes.entry.also
        return autopilot.is_armed and is_chosen and autopilot.mode in _GUIDED_MODES

    def accept_setpoint(self, setpoint: Setpoint) -> str | None:
        """Fly to a bare place and stay; follow any other setpoint until the stream ends.

        From the ground nothing but an attitude with a climb is followed, as by ArduCopter.

        Args:
            setpoint: The setpoint.

        Returns:
            The reason why the setpoint is not followed; None if it is.
        """
        takes_off = False
        if setpoint.level is ControlLevel.ATTITUDE:
            setpoint = self._with_climb(setpoint)
            takes_off = setpoint.velocity_enu_mps[2] > 0.0
        if not (self._is_ready if takes_off else self.is_guided):
            return "not flying in guided mode"
        autopilot = self._view.autopilot
        if _is_bare_place(setpoint):
            self._fly_to(setpoint)
            return None
        autopilot.set_offboard_setpoint(setpoint)
        if autopilot.mode is not Mode.OFFBOARD:
            autopilot.set_mode(Mode.OFFBOARD)
        return None

    def accept_item(self, item: MissionItem, *, is_altitude_only: bool) -> Reply:
        """Fly to the place of a mission item that is not part of a mission.

        Args:
            item: The item.
            is_altitude_only: True keeps the horizontal place.

        Returns:
            The reply; rejected unless the vehicle flies in guided mode.
        """
        if not self.is_guided:
            return rejected("not flying in guided mode")
        is_amsl = item.frame in FRAME_GLOBAL
        altitude_m = item.z if is_amsl else item.z + self._view.home_altitude_m
        if is_altitude_only or item.is_here or not item.is_geodetic:
            return self._view.autopilot.goto(Geodetic(math.nan, math.nan, altitude_m))
        return self._view.autopilot.goto(Geodetic(item.x, item.y, altitude_m))

    def _with_climb(self, setpoint: Setpoint) -> Setpoint:
        """Return tilt and heading of an attitude, with a climb by its thrust: 0.5 keeps the height.

        If body rates alone are given, thrust stays thrust here; ArduCopter climbs by it too.

        Source: ArduCopter 4.5, GCS_Mavlink.cpp, SET_ATTITUDE_TARGET without GUID_OPTIONS.
        """
        parameters = self._view.autopilot.parameters
        share = 2.0 * setpoint.thrust - 1.0
        speed_mps = parameters["MPC_Z_V_AUTO_UP" if share > 0.0 else "MPC_Z_V_AUTO_DN"]
        w, x, y, z = setpoint.quat_wxyz
        # Body z in the world: the direction of the thrust.
        east, north, up = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)
        tilt_rad = min(math.atan2(math.hypot(east, north), up), self._tilt_max_rad)
        level = max(math.hypot(east, north), 1e-9)
        # A level acceleration of g tan(tilt) leads the position controller to that tilt.
        push_mps2 = GRAVITY_MPS2 * math.tan(tilt_rad) / level
        return Setpoint(
            level=ControlLevel.TRAJECTORY,
            position_enu_m=NAN3,
            velocity_enu_mps=(math.nan, math.nan, share * speed_mps),
            acceleration_enu_mps2=(east * push_mps2, north * push_mps2, 0.0),
            yaw_rad=yaw_of(setpoint.quat_wxyz),
        )

    @property
    def _tilt_max_rad(self) -> float:
        return math.radians(self._view.autopilot.parameters["MPC_MAN_TILT_MAX"])

    def _fly_to(self, setpoint: Setpoint) -> None:
        autopilot = self._view.autopilot
        here = self._view.plant.estimate.position_enu_m
        x, y, z = (
            h if math.isnan(c) else c for c, h in zip(setpoint.position_enu_m, here, strict=True)
        )
        target = autopilot.target_enu_m
        is_same = target is not None and math.dist(target, (x, y, z)) < _SAME_PLACE_M
        # The vehicle flies there already, or holds there.
        if autopilot.mode is Mode.HOLD and is_same:
            return
        yaw_rad = None if math.isnan(setpoint.yaw_rad) else setpoint.yaw_rad
        autopilot.goto(self._view.frame.geodetic_from_enu((x, y, z)), yaw_rad=yaw_rad)


def _is_bare_place(setpoint: Setpoint) -> bool:
    moving = (*setpoint.velocity_enu_mps, *setpoint.acceleration_enu_mps2)
    is_place = any(map(math.isfinite, setpoint.position_enu_m))
    return setpoint.level is ControlLevel.TRAJECTORY and is_place and all(map(math.isnan, moving))
