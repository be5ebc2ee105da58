"""Stick modes: acro, manual (stabilized), altitude and position."""

from __future__ import annotations

from math import cos, hypot, pi, radians, sin, tan

from autonomy.model.quadrotor import GRAVITY_MPS2
from autonomy.types import IDLE, NAN3, ControlLevel, Quaternion, Setpoint, Vector3
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.modes import Mode
from flightsim.autopilot.streams import Sticks, with_dead_zone
from flightsim.autopilot.trajectory import VelocityMotion
from flightsim.autopilot.vehicle import TICK_S

# Throttle beyond which stick-guided modes climb and sink. Between them the vehicle holds its
# height.
_RISE_THROTTLE = 0.6
_SINK_THROTTLE = 0.4
_RAISED_THROTTLE = 0.05  # throttle that counts as up in modes that pass it on as thrust
_YAW_ACCELERATION_RADPS2 = 2.0 * pi  # full yaw rate within a fraction of a second


class Manual:
    """Sticks command tilt, or rates in acro mode, and collective thrust.

    Nothing is held: without sticks the vehicle drifts with the wind, and its height follows the
    throttle. The middle of the throttle is the hover thrust.
    """

    is_landing = False
    may_rest = False

    def __init__(self, flight: FlightContext, *, is_acro: bool) -> None:
        """Prepare to fly by the sticks.

        Args:
            flight: Shared state, with the sticks.
            is_acro: True lets pitch and roll command rates; else they command tilt.
        """
        self._flight = flight
        self._is_acro = is_acro
        self.next_mode: Mode | None = None

    def ready_to_lift(self) -> bool:
        """Return true if the throttle is up.

        5% is the least, so that a stick that is not quite at its end does not lift the vehicle.
        """
        return _sticks(self._flight).throttle > _RAISED_THROTTLE

    def start(self) -> None:
        """Keep the present heading."""
        self._flight.heading.reset(self._flight.vehicle.yaw_rad)

    def update(self) -> Setpoint:
        """Return the attitude or the rates that the sticks command, with their thrust.

        On the ground with the throttle down the rotors idle.
        """
        flight = self._flight
        flight.target_enu_m = None
        sticks = _sticks(self._flight)
        if flight.vehicle.is_landed and sticks.throttle <= _RAISED_THROTTLE:
            return IDLE
        p = flight.parameters
        thrust = _thrust(sticks.throttle, flight.vehicle.hover_thrust_fraction)
        if self._is_acro:
            return Setpoint(
                level=ControlLevel.RATE,
                angular_rate_flu_radps=(
                    sticks.roll * radians(p["MC_ACRO_R_MAX"]),
                    sticks.pitch * radians(p["MC_ACRO_P_MAX"]),
                    -sticks.yaw * radians(p["MC_ACRO_Y_MAX"]),
                ),
                thrust=thrust,
            )
        rate_radps = _yaw_rate(flight, sticks)
        flight.heading.step_rate(rate_radps, TICK_S, _YAW_ACCELERATION_RADPS2)
        tilt_max_rad = radians(p["MPC_MAN_TILT_MAX"])
        return Setpoint(
            level=ControlLevel.ATTITUDE,
            quat_wxyz=tilted(
                sticks.pitch * tilt_max_rad,
                sticks.roll * tilt_max_rad,
                flight.heading.yaw_rad,
                tilt_max_rad,
            ),
            angular_rate_flu_radps=(0.0, 0.0, flight.heading.yaw_rate_radps),
            thrust=thrust,
        )


class StickGuided:
    """Altitude and position mode: the throttle commands climb, centred sticks hold.

    A reference point moves with the sticks within the vehicle's limits. In position mode the
    vehicle follows it; in altitude mode it follows its height alone, and the sticks command tilt.
    """

    is_landing = False

    def __init__(self, flight: FlightContext, *, holds_position: bool) -> None:
        """Prepare to fly by the sticks.

        Args:
            flight: Shared state, with the sticks.
            holds_position: True for position mode, false for altitude mode.
        """
        self._flight = flight
        self._holds_position = holds_position
        self._motion = VelocityMotion()
        self.next_mode: Mode | None = None

    @property
    def may_rest(self) -> bool:
        """True if the throttle commands a descent."""
        return _sticks(self._flight).throttle < _SINK_THROTTLE

    def ready_to_lift(self) -> bool:
        """Return true if the throttle commands a climb."""
        return _sticks(self._flight).throttle > _RISE_THROTTLE

    def start(self) -> None:
        """Continue from the present reference, so that a change of mode does not jerk."""
        path = self._flight.path
        self._motion.reset(path.position_enu_m, path.velocity_enu_mps, path.acceleration_enu_mps2)
        self._flight.heading.reset(self._flight.heading.yaw_rad)

    def update(self) -> Setpoint:
        """Return the velocity, or tilt and climb, that the sticks command.

        In position mode reported obstacles slow it down (`CollisionPrevention`). A vehicle in
        altitude mode whose sticks fall silent holds its position, if it knows one.
        """
        flight = self._flight
        flight.target_enu_m = None
        sticks = _sticks(self._flight)
        dead_zone = flight.parameters["MPC_HOLD_DZ"]
        forward = with_dead_zone(sticks.pitch, dead_zone)
        right = with_dead_zone(sticks.roll, dead_zone)
        flight.heading.step_rate(_yaw_rate(flight, sticks), TICK_S, _YAW_ACCELERATION_RADPS2)
        east, north = _rotated(forward, -right, flight.heading.yaw_rad)
        limits = flight.limits.sticks
        climb = with_dead_zone(2.0 * sticks.throttle - 1.0, dead_zone)
        up_mps = climb * (limits.speed_up_mps if climb > 0.0 else limits.speed_down_mps)
        # A pilot whose sticks fall silent in altitude mode holds the position if there is one.
        is_piloted = flight.sticks.is_alive(flight.vehicle.time_us)
        if self._holds_position or (not is_piloted and flight.vehicle.is_position_ok):
            # Both sticks at full travel must not fly faster than one.
            speed = limits.speed_xy_mps / max(1.0, hypot(east, north))
            wished = (east * speed, north * speed)
            share = flight.collision_prevention.allowed_share(wished, flight.vehicle, limits)
            self._advance((share * wished[0], share * wished[1], up_mps), drifts=False)
            x, y, z = self._motion.axes
            return flight.follow((x.x, y.x, z.x), (x.v, y.v, z.v), (x.a, y.a, z.a))
        self._advance((0.0, 0.0, up_mps), drifts=True)
        return self._tilt(east, north)

    def _advance(self, velocity_enu_mps: Vector3, *, drifts: bool) -> None:
        """Move the reference and keep it near the vehicle, horizontally at it if that drifts."""
        vehicle, motion = self._flight.vehicle, self._motion
        motion.step(velocity_enu_mps, self._flight.limits.sticks, TICK_S)
        for i, axis in enumerate(motion.axes):
            here = vehicle.position_enu_m[i]
            if drifts and i < 2:
                axis.x, axis.v, axis.a = here, vehicle.velocity_enu_mps[i], 0.0
            # A reference that runs away from a blocked vehicle would make it dash off once it is
            # free.
            axis.x = min(max(axis.x, here - 1.0), here + 1.0)

    def _tilt(self, east: float, north: float) -> Setpoint:
        """Return a setpoint that levels or tilts the vehicle and holds or changes the height."""
        flight = self._flight
        x, y, z = self._motion.axes
        flight.path.reset((x.x, y.x, z.x), (x.v, y.v, z.v), (x.a, y.a, z.a))
        # A level acceleration of g tan(tilt) tilts the thrust by that angle.
        share = GRAVITY_MPS2 * tan(radians(flight.parameters["MPC_MAN_TILT_MAX"]))
        share /= max(1.0, hypot(east, north))
        return Setpoint(
            level=ControlLevel.TRAJECTORY,
            position_enu_m=(NAN3[0], NAN3[1], z.x),
            velocity_enu_mps=(NAN3[0], NAN3[1], z.v),
            acceleration_enu_mps2=(east * share, north * share, z.a),
            yaw_rad=flight.heading.yaw_rad,
            yaw_rate_radps=flight.heading.yaw_rate_radps,
        )


def tilted(pitch_rad: float, roll_rad: float, yaw_rad: float, tilt_max_rad: float) -> Quaternion:
    """Attitude (w, x, y, z; FLU to ENU) with a heading and with tilts forward and to the right.

    The tilt is about one horizontal axis, `tilt_max_rad` at most. Two tilts one after the other
    would exceed that limit with both sticks deflected.
    """
    angle = hypot(pitch_rad, roll_rad)
    half = 0.5 * min(angle, tilt_max_rad)
    # About body y for forward, about body x for right; both positive in FLU.
    k = sin(half) / angle if angle > 1e-9 else 0.0
    w, x, y = cos(half), roll_rad * k, pitch_rad * k
    c, s = cos(0.5 * yaw_rad), sin(0.5 * yaw_rad)
    # Product of the turn about z and the tilt.
    return (c * w, c * x - s * y, c * y + s * x, s * w)


def _sticks(flight: FlightContext) -> Sticks:
    return flight.sticks.current(flight.vehicle.time_us)


def _yaw_rate(flight: FlightContext, sticks: Sticks) -> float:
    p = flight.parameters
    return -with_dead_zone(sticks.yaw, p["MPC_HOLD_DZ"]) * radians(p["MPC_MAN_Y_MAX"])


def _thrust(throttle: float, hover: float) -> float:
    """Collective thrust, 0 to 1, with hover in the middle of the stick."""
    if throttle <= 0.5:
        return 2.0 * throttle * hover
    return hover + (2.0 * throttle - 1.0) * (1.0 - hover)


def _rotated(forward: float, left: float, yaw_rad: float) -> tuple[float, float]:
    c, s = cos(yaw_rad), sin(yaw_rad)
    return (c * forward - s * left, s * forward + c * left)
