"""Offboard setpoints: SET_POSITION_TARGET_LOCAL_NED, _GLOBAL_INT and SET_ATTITUDE_TARGET.

A setpoint with a field that is not a number or out of range is dropped whole, so the stream counts
as lost, and its sender gets a text. NaN in a position, velocity or acceleration means "free", as in
PX4. Flying the valid half of a setpoint would be worse: the vehicle would do something that nobody
asked for.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence

from autonomy.types import NAN3, ControlLevel, Quaternion, Setpoint, Vector3
from flightsim.autopilot.mission_item import (
    FRAME_GLOBAL,
    FRAME_RELATIVE,
    FRAME_TERRAIN,
    GEODETIC_FRAMES,
)
from flightsim.frames import (
    Geodetic,
    swap_enu_ned,
    swap_flu_frd,
    swap_quat_enu_flu_ned_frd,
    swap_yaw_enu_ned,
)
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler
from flightsim.mavlink.view import VehicleView

_BODY_FRAMES = frozenset(
    {mav.MAV_FRAME_BODY_NED, mav.MAV_FRAME_BODY_OFFSET_NED, mav.MAV_FRAME_BODY_FRD}
)
# BODY_NED turns velocities, but its positions are not offsets from the vehicle.
_OFFSET_FRAMES = _BODY_FRAMES - {mav.MAV_FRAME_BODY_NED} | {mav.MAV_FRAME_LOCAL_OFFSET_NED}
_LOCAL_FRAMES = frozenset({mav.MAV_FRAME_LOCAL_NED, *_OFFSET_FRAMES, *_BODY_FRAMES})
_FORCE = mav.POSITION_TARGET_TYPEMASK_FORCE_SET
_IGNORE_YAW = mav.POSITION_TARGET_TYPEMASK_YAW_IGNORE
_IGNORE_YAW_RATE = mav.POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE
_IGNORE_THRUST = mav.ATTITUDE_TARGET_TYPEMASK_THROTTLE_IGNORE
_IGNORE_ATTITUDE = mav.ATTITUDE_TARGET_TYPEMASK_ATTITUDE_IGNORE

_LIMITS = (1e5, 100.0, 100.0)
"""Largest magnitudes of position in m, velocity in m/s and acceleration in m/s^2."""
_MAX_RATE_RADPS = 50.0


class OffboardService:
    """Converts MAVLink's setpoints into the autopilot's."""

    def __init__(self, view: VehicleView, accept: Callable[[Setpoint], str | None]) -> None:
        """Serve a vehicle.

        Args:
            view: The vehicle, whose frames convert the setpoints.
            accept: Takes a setpoint; returns the reason if it does not, else None.
        """
        self._view = view
        self._accept = accept
        self.handlers: Mapping[str, Handler] = {
            "SET_POSITION_TARGET_LOCAL_NED": self._on_local,
            "SET_POSITION_TARGET_GLOBAL_INT": self._on_global,
            "SET_ATTITUDE_TARGET": self._on_attitude,
        }

    def _on_local(self, _: Channel, message: Message) -> str | None:
        if message.coordinate_frame not in _LOCAL_FRAMES:
            return f"frame {message.coordinate_frame}; valid are {_numbers(_LOCAL_FRAMES)}"
        return self._apply(message, self._position_of_local(message))

    def _on_global(self, _: Channel, message: Message) -> str | None:
        position = self._position_of_global(message)
        if position is None:
            return f"frame {message.coordinate_frame}; valid are {_numbers(GEODETIC_FRAMES)}"
        return self._apply(message, position)

    def _position_of_local(self, message: Message) -> Vector3:
        """Return the desired position in ENU, m, NaN on ignored axes."""
        position = _masked((message.x, message.y, message.z), message.type_mask)
        frame = message.coordinate_frame
        if frame not in _OFFSET_FRAMES:
            return self._view.enu_from_ned(position)
        if frame in _BODY_FRAMES:
            position = self._ned_from_heading(position)
        x, y, z = self._view.position_ned_m
        return self._view.enu_from_ned((x + position[0], y + position[1], z + position[2]))

    def _position_of_global(self, message: Message) -> Vector3 | None:
        """Return the desired position in ENU, m; None if the frame is not global."""
        view, frame = self._view, message.coordinate_frame
        if frame in FRAME_GLOBAL:
            altitude_m = message.alt
        elif frame in FRAME_RELATIVE:
            altitude_m = message.alt + view.home_altitude_m
        elif frame in FRAME_TERRAIN:
            terrain = (0.0, 0.0, view.plant.terrain_height_est_m)
            # Terrain is the estimate's: the height of the ground below the vehicle.
            altitude_m = message.alt + view.frame.geodetic_from_enu(terrain).altitude_m
        else:
            return None
        place = Geodetic(message.lat_int * 1e-7, message.lon_int * 1e-7, altitude_m)
        east, north, up = view.frame.enu_from_geodetic(place)
        # The mask counts x (north), y (east), z, while ENU begins with east.
        north, east, up = _masked((north, east, up), message.type_mask)
        return (east, north, up)

    def _apply(self, message: Message, position_enu_m: Vector3) -> str | None:
        """Apply the fields of both messages: velocity, acceleration, yaw; NED or by heading."""
        mask = message.type_mask
        # The mask has three bits each for position, velocity and acceleration.
        velocity = _masked((message.vx, message.vy, message.vz), mask >> 3)
        acceleration = _masked((message.afx, message.afy, message.afz), mask >> 6)
        if message.coordinate_frame in _BODY_FRAMES:
            velocity = self._ned_from_heading(velocity)
            acceleration = self._ned_from_heading(acceleration)
        vectors = (position_enu_m, swap_enu_ned(velocity), swap_enu_ned(acceleration))
        if mask & _FORCE and any(map(math.isfinite, acceleration)):
            return "a force; valid is an acceleration, without bit 512 of type_mask"
        if not _is_usable(vectors):
            return "no position, velocity or acceleration in range is given"
        yaw = math.nan if mask & _IGNORE_YAW else message.yaw
        yaw_rate = (
            0.0 if mask & _IGNORE_YAW_RATE or math.isnan(message.yaw_rate) else message.yaw_rate
        )
        if math.isinf(yaw) or not abs(yaw_rate) <= _MAX_RATE_RADPS:
            return f"yaw {yaw:g} rad, yaw rate {yaw_rate:g} rad/s is out of range"
        return self._accept(
            Setpoint(
                level=ControlLevel.TRAJECTORY,
                position_enu_m=vectors[0],
                velocity_enu_mps=vectors[1],
                acceleration_enu_mps2=vectors[2],
                yaw_rad=swap_yaw_enu_ned(yaw) if math.isfinite(yaw) else math.nan,
                # Clockwise from above on the wire, counter-clockwise in ENU.
                yaw_rate_radps=-yaw_rate,
            )
        )

    def _on_attitude(self, _: Channel, message: Message) -> str | None:
        mask = message.type_mask
        rates = _masked(
            (message.body_roll_rate, message.body_pitch_rate, message.body_yaw_rate), mask
        )
        # A rate that is free is zero: the attitude decides then.
        rates = (_or_zero(rates[0]), _or_zero(rates[1]), _or_zero(rates[2]))
        has_thrust = not mask & _IGNORE_THRUST and math.isfinite(message.thrust)
        if not has_thrust or not all(abs(rate) <= _MAX_RATE_RADPS for rate in rates):
            return f"no thrust is given, or a rate above {_MAX_RATE_RADPS:g} rad/s"
        quat: Quaternion | None = (1.0, 0.0, 0.0, 0.0)
        level = ControlLevel.RATE
        if not mask & _IGNORE_ATTITUDE:
            level, quat = ControlLevel.ATTITUDE, _normalised(message.q)
        if quat is None:
            return "q is no attitude"
        return self._accept(
            Setpoint(
                level=level,
                quat_wxyz=swap_quat_enu_flu_ned_frd(quat),
                angular_rate_flu_radps=swap_flu_frd(rates),
                thrust=max(0.0, min(1.0, message.thrust)),
            )
        )

    def _ned_from_heading(self, vector: Vector3) -> Vector3:
        """Return a forward-right-down vector in NED, rotated by the heading alone.

        A free horizontal axis stays free only if the other is free too: rotation mixes both.
        """
        forward, right, down = vector
        if math.isnan(forward) and math.isnan(right):
            return (math.nan, math.nan, down)
        yaw = self._view.rpy_rad[2]
        forward, right = _or_zero(forward), _or_zero(right)
        return (
            forward * math.cos(yaw) - right * math.sin(yaw),
            forward * math.sin(yaw) + right * math.cos(yaw),
            down,
        )


def _numbers(frames: Iterable[int]) -> str:
    return ", ".join(map(str, sorted(frames)))


def _masked(vector: Vector3, mask: int) -> Vector3:
    """Return the vector with NaN on axes that the mask ignores."""
    if mask & 7 == 7:
        return NAN3
    x, y, z = vector
    nan = math.nan
    return (nan if mask & 1 else x, nan if mask & 2 else y, nan if mask & 4 else z)


def _is_usable(vectors: Sequence[Vector3]) -> bool:
    """Return true if any field is given and none is out of range; NaN is free."""
    is_wanted = False
    for vector, limit in zip(vectors, _LIMITS, strict=True):
        for value in vector:
            # NaN compares false and passes as free.
            if abs(value) > limit:
                return False
            is_wanted = is_wanted or not math.isnan(value)
    return is_wanted


def _or_zero(value: float) -> float:
    return 0.0 if math.isnan(value) else value


def _normalised(quat: Sequence[float]) -> Quaternion | None:
    norm = math.hypot(*quat)
    # Too short a quaternion has no direction that could be scaled up.
    if not 1e-3 < norm < math.inf:
        return None
    w, x, y, z = (value / norm for value in quat)
    return (w, x, y, z)
