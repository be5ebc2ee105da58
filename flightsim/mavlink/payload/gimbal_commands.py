"""Commands of the gimbal: control, angles and rates, regions of interest (gimbal protocol v2).

Angles on the wire count up and clockwise; the gimbal's own count down and counter-clockwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from autonomy.types import Vector3
from flightsim.autopilot.results import ACCEPTED, Reply, denied
from flightsim.frames import Geodetic, euler_rpy_rad, swap_yaw_enu_ned
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.commands import UNSUPPORTED, Order, choice, given
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.payload.camera_commands import OrderExecutor
from flightsim.mavlink.payload.gimbal_messages import DEVICE_ID, NOBODY, Address, Control
from flightsim.mavlink.payload.mount import STRAIGHT, Mount
from flightsim.mavlink.service import Handler
from flightsim.mavlink.view import VehicleView
from flightsim.payload.gimbal import Gimbal, Pointing

# MAVSDK names the component, others the device; 0 means all.
_DEVICE_IDS = frozenset({0, DEVICE_ID, mav.MAV_COMP_ID_GIMBAL})
_MAX_ID = 255


class GimbalCommands:
    """Turns the gimbal for the clients that may control it.

    Attributes:
        orders: Orders that clients and mission items may give.
        handlers: Messages that turn it, which have no answer.
    """

    def __init__(
        self,
        view: VehicleView,
        gimbal: Gimbal,
        control: Control,
        *,
        mount: Mount,
        own_address: Address,
        report_status: Callable[[], None],
    ) -> None:
        """Obey from now on.

        Args:
            view: State of the vehicle.
            gimbal: The gimbal.
            control: The clients in control; changed here.
            mount: The same gimbal, for older commands.
            own_address: The autopilot, whose mission items act whoever is in control.
            report_status: Called when the control has changed.
        """
        self._view = view
        self._gimbal = gimbal
        self._control = control
        self._own_address = own_address
        self._report_status = report_status
        turning: Mapping[int, OrderExecutor] = {
            mav.MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW: self._pitch_yaw,
            mav.MAV_CMD_DO_SET_ROI_LOCATION: self._look_at_place,
            mav.MAV_CMD_DO_SET_ROI_WPNEXT_OFFSET: self._look_ahead,
            mav.MAV_CMD_DO_SET_ROI_NONE: self._look_straight,
            mav.MAV_CMD_DO_SET_ROI: self._old_region,
            mav.MAV_CMD_DO_MOUNT_CONTROL: mount.turn,
            mav.MAV_CMD_DO_MOUNT_CONFIGURE: mount.configure,
        }
        self.orders: Mapping[int, OrderExecutor] = {
            mav.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE: self._configure,
            **{number: self._guarded(turn) for number, turn in turning.items()},
        }
        self.handlers: Mapping[str, Handler] = {
            "GIMBAL_MANAGER_SET_ATTITUDE": self._on_attitude,
            "GIMBAL_MANAGER_SET_PITCHYAW": self._on_pitch_yaw,
            "GIMBAL_MANAGER_SET_MANUAL_CONTROL": self._on_manual_control,
        }

    def _guarded(self, turn: OrderExecutor) -> OrderExecutor:
        """Return an executor that refuses clients that are not in control, while somebody is."""

        def execute(c: Order) -> Reply:
            if c.sender == self._own_address or self._control.allows(c.sender):
                return turn(c)
            system, component = self._control.primary
            return denied(f"the gimbal is controlled by {system}/{component}")

        return execute

    # --- control ---

    def _configure(self, c: Order) -> Reply:
        fault = _device_fault(c.z)
        if fault:
            return denied(fault)
        control = self._control
        parts = [choice(value) for value in (c.param1, c.param2, c.param3, c.param4)]
        try:
            primary = _address(parts[0], parts[1], control.primary, c.sender)
            secondary = _address(parts[2], parts[3], control.secondary, c.sender)
        except ValueError as error:
            return denied(str(error))
        control.primary, control.secondary = primary, secondary
        self._report_status()
        return ACCEPTED

    # --- angles and rates ---

    def _pitch_yaw(self, c: Order) -> Reply:
        fault = _device_fault(c.z)
        flags = choice(c.param5, default=0)
        if fault or flags is None:
            return denied(fault or f"flags {c.param5:g}; valid are whole numbers")
        angles = (c.param1, c.param2, c.param3, c.param4)
        self._turn(flags, *map(math.radians, angles))
        return ACCEPTED

    def _turn(
        self, flags: int, pitch_rad: float, yaw_rad: float, pitch_rate: float, yaw_rate: float
    ) -> None:
        """Turn by angles and rates in rad as they are on the wire; NaN leaves an axis alone."""
        gimbal = self._gimbal
        if flags & (mav.GIMBAL_MANAGER_FLAGS_NEUTRAL | mav.GIMBAL_MANAGER_FLAGS_RETRACT):
            gimbal.point(STRAIGHT)
            return
        # A locked yaw counts from north unless the frame's flags say otherwise.
        is_locked = bool(flags & mav.GIMBAL_MANAGER_FLAGS_YAW_LOCK)
        is_of_earth = is_locked
        if flags & mav.GIMBAL_MANAGER_FLAGS_YAW_IN_EARTH_FRAME:
            is_of_earth = True
        elif flags & mav.GIMBAL_MANAGER_FLAGS_YAW_IN_VEHICLE_FRAME:
            is_of_earth = False
        turn_rad = None
        if math.isfinite(yaw_rad):
            north_rad = yaw_rad + (0.0 if is_of_earth else self._view.rpy_rad[2])
            # The gimbal's own angle counts from the nose, counter-clockwise.
            from_nose_rad = -(north_rad - self._view.rpy_rad[2])
            turn_rad = swap_yaw_enu_ned(north_rad) if is_locked else from_nose_rad
        gimbal.point(
            Pointing(
                pitch_down_rad=_opposite(pitch_rad),
                yaw_rad=turn_rad,
                pitch_down_rate_radps=_opposite(pitch_rate),
                yaw_rate_radps=_opposite(yaw_rate),
                is_yaw_locked=is_locked,
            )
        )

    # --- regions of interest ---

    def _look_at_place(self, c: Order) -> Reply:
        fault = _device_fault(c.param1) or self._place_fault(c)
        if fault:
            return denied(fault)
        self._follow(c)
        return ACCEPTED

    # Every coordinate must be given: a region of interest has no default.
    def _place_fault(self, c: Order) -> str | None:
        if c.is_here or math.isnan(c.z):
            return "no place; valid are latitude, longitude and altitude"
        return c.place_fault()

    def _follow(self, c: Order) -> None:
        altitude_m = c.z
        if c.sender == self._own_address:
            altitude_m = c.altitude_amsl_m(self._view.home_altitude_m)
        # As in PX4 a client's is above the sea whatever the frame: SDKs rely on it.
        target_enu_m = self._view.frame.enu_from_geodetic(Geodetic(c.x, c.y, altitude_m))
        self._gimbal.look_at(lambda: target_enu_m)

    def _look_ahead(self, c: Order) -> Reply:
        offsets = (given(value) or 0.0 for value in (c.param5, c.y, c.z))
        if any(offsets):
            return denied("offsets from the next waypoint; valid are zeros")
        self._gimbal.look_at(self._next_waypoint)
        return ACCEPTED

    def _next_waypoint(self) -> Vector3 | None:
        return self._view.autopilot.target_enu_m

    def _look_straight(self, _: Order) -> Reply:
        self._gimbal.point(STRAIGHT)
        return ACCEPTED

    def _old_region(self, c: Order) -> Reply:
        match choice(c.param1, default=mav.MAV_ROI_LOCATION):
            case mav.MAV_ROI_NONE:
                return self._look_straight(c)
            case mav.MAV_ROI_WPNEXT:
                self._gimbal.look_at(self._next_waypoint)
                return ACCEPTED
            case mav.MAV_ROI_LOCATION:
                fault = self._place_fault(c)
                if fault:
                    return denied(fault)
                self._follow(c)
                return ACCEPTED
        return UNSUPPORTED

    # --- messages ---

    def _may_turn(self, message: Message) -> bool:
        sender = (message.get_srcSystem(), message.get_srcComponent())
        is_ours = message.gimbal_device_id in _DEVICE_IDS
        return is_ours and self._control.allows(sender)

    def _on_attitude(self, _: Channel, m: Message) -> None:
        if not self._may_turn(m):
            return
        w, x, y, z = m.q
        pitch_rad = yaw_rad = math.nan
        length = math.hypot(w, x, y, z)
        # Far from unit length it is no attitude; NaN then leaves both angles alone.
        if 0.5 < length < 2.0:
            unit = (w / length, x / length, y / length, z / length)
            pitch_rad, yaw_rad = euler_rpy_rad(unit)[1:]
        self._turn(m.flags, pitch_rad, yaw_rad, m.angular_velocity_y, m.angular_velocity_z)

    def _on_pitch_yaw(self, _: Channel, m: Message) -> None:
        if self._may_turn(m):
            self._turn(m.flags, m.pitch, m.yaw, m.pitch_rate, m.yaw_rate)

    def _on_manual_control(self, _: Channel, m: Message) -> None:
        """Turn by sticks, -1 to 1: shares of the range (angles) or the greatest rate (rates)."""
        if not self._may_turn(m):
            return
        cfg = self._gimbal.cfg
        pitch, yaw, pitch_rate, yaw_rate = (
            max(-1.0, min(1.0, value)) if math.isfinite(value) else math.nan
            for value in (m.pitch, m.yaw, m.pitch_rate, m.yaw_rate)
        )
        way = -cfg.highest_pitch_down_rad if pitch > 0.0 else cfg.lowest_pitch_down_rad
        rate = cfg.max_rate_radps
        self._turn(m.flags, pitch * way, yaw * math.pi, pitch_rate * rate, yaw_rate * rate)


def _opposite(value: float) -> float | None:
    """Return the value with its sign changed; None if it is not finite."""
    return -value if math.isfinite(value) else None


def _device_fault(number: float) -> str | None:
    """Return the fault of a gimbal's number, or None."""
    if choice(number, default=0) in _DEVICE_IDS:
        return None
    return f"gimbal {number:g}; valid are 0 (all) and {DEVICE_ID}"


def _address(
    system: int | None, component: int | None, present: Address, sender: Address
) -> Address:
    """Return the address that two parameters of CONFIGURE give control to.

    -1 leaves control unchanged, -2 takes it, -3 releases it if the sender has it.

    Raises:
        ValueError: If the parameters name no address.
    """
    if system is None or component is None:
        raise ValueError("an id is no whole number; valid are 0 to 255, -1, -2, -3")
    match system:
        case -1:
            return present
        case -2:
            return sender
        case -3:
            return NOBODY if present == sender else present
    if not (0 <= system <= _MAX_ID and 0 <= component <= _MAX_ID):
        raise ValueError(f"{system}/{component} is nobody; valid are 0 to 255, -1, -2, -3")
    return (system, component)
