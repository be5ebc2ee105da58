"""The gimbal as a mount: older messages and commands with a mode, and its own reports.

DroneKit and scripts for ArduPilot turn it so. Angles on the wire count up and clockwise from the
nose, in hundredths of a degree; the gimbal's own count down and counter-clockwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from autonomy.types import Vector3
from flightsim.autopilot.events import Severity
from flightsim.autopilot.results import ACCEPTED, CommandResult, Reply, denied
from flightsim.frames import Geodetic
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.commands import Order, choice, explanation
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.dialect import layout
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.payload.gimbal_messages import Control
from flightsim.mavlink.service import Handler
from flightsim.mavlink.statustext import StatustextSender
from flightsim.mavlink.view import VehicleView
from flightsim.payload.gimbal import Gimbal, Pointing

STRAIGHT = Pointing(pitch_down_rad=0.0, yaw_rad=0.0)
_MOUNT_STATUS = layout("MOUNT_STATUS")
_MOUNT_ORIENTATION = layout("MOUNT_ORIENTATION")
_CENTI, _E7 = 0.01, 1e-7
_RETRACT, _NEUTRAL = mav.MAV_MOUNT_MODE_RETRACT, mav.MAV_MOUNT_MODE_NEUTRAL
_ANGLES, _PLACE = mav.MAV_MOUNT_MODE_MAVLINK_TARGETING, mav.MAV_MOUNT_MODE_GPS_POINT
_HOME, _WAYPOINT = mav.MAV_MOUNT_MODE_HOME_LOCATION, mav.MAV_MOUNT_MODE_WPNEXT_OFFSET
_VALID = "valid are 0, 1 (straight), 2 (angles), 4 (place), 6 (home), 7 (next waypoint)"


class Mount:
    """A mode, and angles or a place within it.

    Attributes:
        handlers: MOUNT_CONFIGURE and MOUNT_CONTROL, which have no acknowledgement.
        producers: MOUNT_STATUS and MOUNT_ORIENTATION.
    """

    def __init__(
        self, view: VehicleView, gimbal: Gimbal, control: Control, statustext: StatustextSender
    ) -> None:
        self._view = view
        self._gimbal = gimbal
        self._control = control
        self._statustext = statustext
        self._mode = _ANGLES
        self.handlers: Mapping[str, Handler] = {
            "MOUNT_CONFIGURE": self._on_configure,
            "MOUNT_CONTROL": self._on_control,
        }
        self.producers: Mapping[str, Callable[[], bytes]] = {
            "MOUNT_STATUS": self._status,
            "MOUNT_ORIENTATION": self._orientation,
        }

    def configure(self, c: Order) -> Reply:
        """Take the mode that parameter 1 names."""
        return self._choose(choice(c.param1))

    def turn(self, c: Order) -> Reply:
        """Take the mode that parameter 7 names, and its angles in degrees (parameters 1 and 3)."""
        mode = choice(c.z, default=_ANGLES)
        # The command has no room for a place: only modes without one.
        if mode not in {_RETRACT, _NEUTRAL, _ANGLES}:
            return Reply(CommandResult.UNSUPPORTED)
        reply = self._choose(mode)
        return self._point(c.param1, c.param3) if mode == _ANGLES else reply

    def _choose(self, mode: int | None) -> Reply:
        if mode in {_RETRACT, _NEUTRAL}:
            self._gimbal.point(STRAIGHT)
        elif mode == _HOME:
            self._gimbal.look_at(self._home)
        elif mode == _WAYPOINT:
            self._gimbal.look_at(lambda: self._view.autopilot.target_enu_m)
        elif mode not in {_ANGLES, _PLACE} or mode is None:
            return denied(f"mount mode {mode}; {_VALID}")
        self._mode = mode
        return ACCEPTED

    def _home(self) -> Vector3 | None:
        home = self._view.autopilot.home
        return None if home is None else home.position_enu_m

    def _point(self, pitch_deg: float, yaw_deg: float) -> Reply:
        """Turn to angles; an angle that is not a number leaves its axis alone."""
        pitch_rad, yaw_rad = math.radians(pitch_deg), math.radians(yaw_deg)
        self._gimbal.point(
            Pointing(
                pitch_down_rad=-pitch_rad if math.isfinite(pitch_rad) else None,
                yaw_rad=-yaw_rad if math.isfinite(yaw_rad) else None,
            )
        )
        return ACCEPTED

    def _on_configure(self, _: Channel, m: Message) -> None:
        self._answer("MOUNT_CONFIGURE", m, lambda: self._choose(m.mount_mode))

    def _on_control(self, _: Channel, m: Message) -> None:
        self._answer("MOUNT_CONTROL", m, lambda: self._obey(m))

    def _answer(self, name: str, message: Message, act: Callable[[], Reply]) -> None:
        """Act for a client that may turn the gimbal; a text says why not, as no answer exists."""
        sender = (message.get_srcSystem(), message.get_srcComponent())
        if self._control.allows(sender):
            reply = act()
        else:
            system, component = self._control.primary
            reply = denied(f"the gimbal is controlled by {system}/{component}")
        if reply.reason:
            self._statustext.broadcast(Severity.WARNING, explanation(name, reply))

    def _obey(self, m: Message) -> Reply:
        """Do what MOUNT_CONTROL demands in the present mode."""
        if self._mode == _ANGLES:
            return self._point(_CENTI * m.input_a, _CENTI * m.input_c)
        if self._mode != _PLACE:
            return denied(f"the mount is in mode {self._mode}; valid are 2 (angles), 4 (place)")
        latitude_deg, longitude_deg = _E7 * m.input_a, _E7 * m.input_b
        if not (abs(latitude_deg) <= 90.0 and abs(longitude_deg) <= 180.0):
            return denied(
                f"latitude {latitude_deg:g}, longitude {longitude_deg:g} is off the globe"
            )
        # ArduPilot's altitude of a place counts from home, in centimetres.
        altitude_m = _CENTI * m.input_c + self._view.home_altitude_m
        place = Geodetic(latitude_deg, longitude_deg, altitude_m)
        target_enu_m = self._view.frame.enu_from_geodetic(place)
        self._gimbal.look_at(lambda: target_enu_m)
        return ACCEPTED

    @property
    def _angles_deg(self) -> tuple[float, float]:
        """Pitch up and yaw clockwise from the nose, degrees."""
        gimbal = self._gimbal
        return -math.degrees(gimbal.pitch_down_rad), -math.degrees(gimbal.yaw_rad)

    def _status(self) -> bytes:
        pitch_deg, yaw_deg = self._angles_deg
        return _MOUNT_STATUS.encode(
            pointing_a=round(pitch_deg / _CENTI),
            pointing_c=round(yaw_deg / _CENTI),
            mount_mode=self._mode,
        )

    def _orientation(self) -> bytes:
        pitch_deg, yaw_deg = self._angles_deg
        return _MOUNT_ORIENTATION.encode(
            time_boot_ms=self._view.time_boot_ms,
            pitch=pitch_deg,
            yaw=yaw_deg,
            yaw_absolute=(yaw_deg + self._view.heading_deg) % 360.0,
        )
