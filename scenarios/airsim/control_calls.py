"""Calls that command a vehicle: API control, arming and every move."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from autonomy.types import Quaternion, Vector3
from flightsim.frames import Geodetic, swap_enu_ned, swap_flu_frd, swap_quat_enu_flu_ned_frd
from scenarios.airsim import tasks
from scenarios.airsim.craft import Craft
from scenarios.airsim.flyer import Task
from scenarios.airsim.frames import quat_enu_flu
from scenarios.airsim.guidance import FORWARD_ONLY, Facing
from scenarios.airsim.messages import Pose, RCData, Vector3r, YawMode
from scenarios.airsim.methods import Later, RpcError

Find = Callable[[str], Craft]
_DEFAULT_YAW = YawMode()


class ControlCalls:
    """Methods by their names in AirSim, each for the vehicle that it names."""

    def __init__(self, find: Find) -> None:
        """Command the vehicles that `find` knows by name."""
        self._find = find

    @property
    def functions(self) -> Mapping[str, Callable[..., object]]:
        """All methods."""
        return {
            "enableApiControl": self.enable,
            "isApiControlEnabled": self.is_enabled,
            "armDisarm": self.arm,
            "takeoff": self.take_off,
            "land": self.land,
            "goHome": self.go_home,
            "hover": self.hover,
            "cancelLastTask": self.cancel,
            "moveByVelocity": self.velocity,
            "moveByVelocityZ": self.velocity_z,
            "moveByVelocityBodyFrame": self.velocity_body,
            "moveByVelocityZBodyFrame": self.velocity_z_body,
            "moveOnPath": self.on_path,
            "moveToPosition": self.to_position,
            "moveToGPS": self.to_gps,
            "moveToZ": self.to_z,
            "rotateToYaw": self.rotate_to,
            "rotateByYawRate": self.rotate_by,
            "moveByRollPitchYawZ": self.roll_pitch_yaw_z,
            "moveByRollPitchYawThrottle": self.roll_pitch_yaw_throttle,
            "moveByRollPitchYawrateZ": self.roll_pitch_yaw_rate_z,
            "moveByRollPitchYawrateThrottle": self.roll_pitch_yaw_rate_throttle,
            "moveByAngleRatesZ": self.rates_z,
            "moveByAngleRatesThrottle": self.rates_throttle,
            "moveByManual": self.manual,
            "moveByRC": self.hold_sticks,
            "simSetVehiclePose": self.put,
        }

    def enable(self, is_enabled: bool, vehicle_name: str = "") -> None:
        """Take or return API control."""
        self._find(vehicle_name).flyer.enable(is_enabled=is_enabled)

    def is_enabled(self, vehicle_name: str = "") -> bool:
        """Return True if a client has API control."""
        return self._find(vehicle_name).flyer.is_enabled

    def arm(self, arm: bool, vehicle_name: str = "") -> Later:
        """Arm or disarm."""
        return self._find(vehicle_name).flyer.arm(is_armed=arm)

    def take_off(self, timeout_sec: float = 20.0, vehicle_name: str = "") -> Later:
        """Climb by three metres."""
        return self._start(vehicle_name, tasks.take_off, timeout_sec)

    def land(self, timeout_sec: float = 60.0, vehicle_name: str = "") -> Later:
        """Land here."""
        return self._start(vehicle_name, tasks.land, timeout_sec)

    def go_home(self, timeout_sec: float = math.inf, vehicle_name: str = "") -> Later:
        """Return to the start and land."""
        return self._start(vehicle_name, tasks.go_home, timeout_sec)

    def hover(self, vehicle_name: str = "") -> Later:
        """Come to rest."""
        return self._start(vehicle_name, tasks.hover, math.inf)

    def cancel(self, vehicle_name: str = "") -> None:
        """End the present move."""
        self._find(vehicle_name).flyer.cancel()

    def velocity(
        self,
        vx: float,
        vy: float,
        vz: float,
        duration: float,
        drivetrain: int = 0,
        yaw_mode: YawMode = _DEFAULT_YAW,
        vehicle_name: str = "",
    ) -> Later:
        """Fly at a velocity of the world."""
        craft, velocity = self._find(vehicle_name), _velocity(vx, vy, vz)
        move = tasks.move_by_velocity(
            craft.flyer, velocity, _duration(duration), _facing(drivetrain, yaw_mode)
        )
        return craft.flyer.start(move)

    def velocity_z(
        self,
        vx: float,
        vy: float,
        z: float,
        duration: float,
        drivetrain: int = 0,
        yaw_mode: YawMode = _DEFAULT_YAW,
        vehicle_name: str = "",
    ) -> Later:
        """The same at a height."""
        craft = self._find(vehicle_name)
        move = tasks.move_by_velocity(
            craft.flyer,
            _velocity(vx, vy, 0.0),
            _duration(duration),
            _facing(drivetrain, yaw_mode),
            _height(craft, z),
        )
        return craft.flyer.start(move)

    def velocity_body(
        self,
        vx: float,
        vy: float,
        vz: float,
        duration: float,
        drivetrain: int = 0,
        yaw_mode: YawMode = _DEFAULT_YAW,
        vehicle_name: str = "",
    ) -> Later:
        """Fly at a velocity forwards, to the right and down."""
        craft = self._find(vehicle_name)
        _ = _velocity(vx, vy, vz)
        move = tasks.move_in_heading(
            craft.flyer, vx, vy, -vz, _duration(duration), _facing(drivetrain, yaw_mode)
        )
        return craft.flyer.start(move)

    def velocity_z_body(
        self,
        vx: float,
        vy: float,
        z: float,
        duration: float,
        drivetrain: int = 0,
        yaw_mode: YawMode = _DEFAULT_YAW,
        vehicle_name: str = "",
    ) -> Later:
        """The same at a height."""
        craft = self._find(vehicle_name)
        _ = _velocity(vx, vy, 0.0)
        move = tasks.move_in_heading(
            craft.flyer,
            vx,
            vy,
            0.0,
            _duration(duration),
            _facing(drivetrain, yaw_mode),
            _height(craft, z),
        )
        return craft.flyer.start(move)

    def on_path(
        self,
        path: list[Vector3r],
        velocity: float,
        timeout_sec: float = math.inf,
        drivetrain: int = 0,
        yaw_mode: YawMode = _DEFAULT_YAW,
        lookahead: float = -1.0,
        adaptive_lookahead: float = 1.0,
        vehicle_name: str = "",
    ) -> Later:
        """Fly through points."""
        _ = lookahead, adaptive_lookahead  # Our reference needs none.
        craft = self._find(vehicle_name)
        if drivetrain == FORWARD_ONLY and yaw_mode.is_rate:
            raise RpcError("yaw_mode is a rate; valid with ForwardOnly: YawMode(False, degrees)")
        points = [craft.scene_enu_m(point) for point in path]
        move = tasks.move_on_path(
            craft.flyer, points, _speed(velocity), _facing(drivetrain, yaw_mode)
        )
        return craft.flyer.start(move, _timeout(timeout_sec))

    def to_position(
        self,
        x: float,
        y: float,
        z: float,
        velocity: float,
        timeout_sec: float = math.inf,
        drivetrain: int = 0,
        yaw_mode: YawMode = _DEFAULT_YAW,
        lookahead: float = -1.0,
        adaptive_lookahead: float = 1.0,
        vehicle_name: str = "",
    ) -> Later:
        """Fly to a point."""
        _ = lookahead, adaptive_lookahead
        craft = self._find(vehicle_name)
        return self._move_to(
            craft,
            craft.scene_enu_m(Vector3r(x, y, z)),
            velocity,
            timeout_sec,
            _facing(drivetrain, yaw_mode),
        )

    def to_gps(
        self,
        latitude: float,
        longitude: float,
        altitude: float,
        velocity: float,
        timeout_sec: float = math.inf,
        drivetrain: int = 0,
        yaw_mode: YawMode = _DEFAULT_YAW,
        lookahead: float = -1.0,
        adaptive_lookahead: float = 1.0,
        vehicle_name: str = "",
    ) -> Later:
        """Fly to a place on the earth."""
        _ = lookahead, adaptive_lookahead
        craft = self._find(vehicle_name)
        place = Geodetic(latitude, longitude, altitude)
        goal = craft.vehicle.frame.enu_from_geodetic(place)
        _require_near(goal)
        facing = _facing(drivetrain, yaw_mode)
        return self._move_to(craft, goal, velocity, timeout_sec, facing)

    def to_z(
        self,
        z: float,
        velocity: float,
        timeout_sec: float = math.inf,
        yaw_mode: YawMode = _DEFAULT_YAW,
        lookahead: float = -1.0,
        adaptive_lookahead: float = 1.0,
        vehicle_name: str = "",
    ) -> Later:
        """Climb or descend to a height."""
        _ = lookahead, adaptive_lookahead
        craft, facing = self._find(vehicle_name), Facing(mode=yaw_mode)
        height_m = _height(craft, z)
        speed = _speed(velocity)

        def move() -> Task:
            yield from craft.flyer.engage()
            x, y, _ = craft.flyer.guidance.position_enu_m
            goals = [(x, y, height_m)]
            return (yield from tasks.move_on_path(craft.flyer, goals, speed, facing))

        return craft.flyer.start(move(), _timeout(timeout_sec))

    def rotate_to(
        self,
        yaw: float,
        timeout_sec: float = math.inf,
        margin: float = 5.0,
        vehicle_name: str = "",
    ) -> Later:
        """Turn to a heading in degrees."""
        craft = self._find(vehicle_name)
        move = tasks.rotate_to(craft.flyer, _finite(yaw, "yaw"), _finite(margin, "margin"))
        return craft.flyer.start(move, _timeout(timeout_sec))

    def rotate_by(self, yaw_rate: float, duration: float, vehicle_name: str = "") -> Later:
        """Turn at a rate in degrees/s."""
        craft = self._find(vehicle_name)
        move = tasks.rotate_by(craft.flyer, _finite(yaw_rate, "yaw_rate"), _duration(duration))
        return craft.flyer.start(move)

    def roll_pitch_yaw_z(
        self,
        roll: float,
        pitch: float,
        yaw: float,
        z: float,
        duration: float,
        vehicle_name: str = "",
    ) -> Later:
        """Hold an attitude at a height."""
        quat = _quat(roll, pitch, yaw)
        return self._point(vehicle_name, quat, (0.0, 0.0, 0.0), None, duration, z=z)

    def roll_pitch_yaw_throttle(
        self,
        roll: float,
        pitch: float,
        yaw: float,
        throttle: float,
        duration: float,
        vehicle_name: str = "",
    ) -> Later:
        """Hold an attitude with a thrust."""
        quat = _quat(roll, pitch, yaw)
        return self._point(vehicle_name, quat, (0.0, 0.0, 0.0), throttle, duration)

    def roll_pitch_yaw_rate_z(
        self,
        roll: float,
        pitch: float,
        yaw_rate: float,
        z: float,
        duration: float,
        vehicle_name: str = "",
    ) -> Later:
        """Hold roll and pitch at a height, and turn."""
        quat = _level_quat(roll, pitch)
        rate = -_finite(yaw_rate, "yaw_rate")
        return self._point(
            vehicle_name, quat, (0.0, 0.0, rate), None, duration, z=z, yaw_rate_radps=rate
        )

    def roll_pitch_yaw_rate_throttle(
        self,
        roll: float,
        pitch: float,
        yaw_rate: float,
        throttle: float,
        duration: float,
        vehicle_name: str = "",
    ) -> Later:
        """Hold roll and pitch with a thrust, and turn."""
        quat = _level_quat(roll, pitch)
        rate = -_finite(yaw_rate, "yaw_rate")
        return self._point(
            vehicle_name, quat, (0.0, 0.0, rate), throttle, duration, yaw_rate_radps=rate
        )

    def rates_z(
        self,
        roll_rate: float,
        pitch_rate: float,
        yaw_rate: float,
        z: float,
        duration: float,
        vehicle_name: str = "",
    ) -> Later:
        """Turn at angular rates at a height."""
        rates = _rates(roll_rate, pitch_rate, yaw_rate)
        return self._point(vehicle_name, None, rates, None, duration, z=z)

    def rates_throttle(
        self,
        roll_rate: float,
        pitch_rate: float,
        yaw_rate: float,
        throttle: float,
        duration: float,
        vehicle_name: str = "",
    ) -> Later:
        """Turn at angular rates with a thrust."""
        rates = _rates(roll_rate, pitch_rate, yaw_rate)
        return self._point(vehicle_name, None, rates, throttle, duration)

    def manual(
        self,
        vx_max: float,
        vy_max: float,
        z_min: float,
        duration: float,
        drivetrain: int = 0,
        yaw_mode: YawMode = _DEFAULT_YAW,
        vehicle_name: str = "",
    ) -> Later:
        """Fly as the sticks say that moveByRC holds."""
        _ = drivetrain, yaw_mode  # The yaw stick turns the vehicle.
        craft = self._find(vehicle_name)
        fastest = (_finite(vx_max, "vx_max"), _finite(vy_max, "vy_max"))
        move = tasks.move_by_sticks(
            craft.flyer, fastest, _height(craft, z_min), _duration(duration)
        )
        return craft.flyer.start(move)

    def hold_sticks(self, rc_data: RCData, vehicle_name: str = "") -> None:
        """Hold the sticks of a radio."""
        sticks = (rc_data.pitch, rc_data.roll, rc_data.yaw)
        if not (all(abs(each) <= 1.0 for each in sticks) and 0.0 <= rc_data.throttle <= 1.0):
            raise RpcError("rc_data is not valid; valid: sticks of -1 to 1, throttle of 0 to 1")
        self._find(vehicle_name).flyer.sticks = rc_data

    def put(self, pose: Pose, ignore_collision: bool, vehicle_name: str = "") -> None:
        """Put the vehicle elsewhere."""
        _ = ignore_collision  # A pose inside of something is refused in either case.
        craft = self._find(vehicle_name)
        quat_wxyz = quat_enu_flu(pose.orientation)
        craft.flyer.put(craft.scene_enu_m(pose.position), quat_wxyz)

    # --- shared ---

    def _start(self, name: str, task: Callable[..., Task], timeout_s: float) -> Later:
        flyer = self._find(name).flyer
        return flyer.start(task(flyer), _timeout(timeout_s))

    def _move_to(
        self, craft: Craft, goal: Vector3, velocity: float, timeout_sec: float, facing: Facing
    ) -> Later:
        move = tasks.move_on_path(craft.flyer, [goal], _speed(velocity), facing)
        return craft.flyer.start(move, _timeout(timeout_sec))

    def _point(
        self,
        name: str,
        quat: Quaternion | None,
        rates: Vector3,
        throttle: float | None,
        duration: float,
        *,
        z: float = 0.0,
        yaw_rate_radps: float | None = None,
    ) -> Later:
        craft = self._find(name)
        if throttle is not None and not 0.0 <= throttle <= 1.0:
            raise RpcError(f"throttle {throttle} is not valid; valid: 0 to 1")
        move = tasks.point(
            craft.flyer,
            quat,
            rates,
            throttle,
            _duration(duration),
            height_m=_height(craft, z),
            hover_thrust=craft.vehicle.airframe.quadrotor.hover_thrust_fraction,
            yaw_rate_radps=yaw_rate_radps,
        )
        return craft.flyer.start(move)


def _facing(drivetrain: int, mode: YawMode) -> Facing:
    _finite(mode.yaw_or_rate, "yaw_mode")
    if drivetrain not in (0, FORWARD_ONLY):
        raise RpcError(f"drivetrain {drivetrain} is unknown; valid: 0, 1")
    return Facing(mode=mode, drivetrain=drivetrain)


def _velocity(vx: float, vy: float, vz: float) -> Vector3:
    for name, value in (("vx", vx), ("vy", vy), ("vz", vz)):
        _finite(value, name)
    return swap_enu_ned((vx, vy, vz))


def _height(craft: Craft, z: float) -> float:
    return craft.origin_enu_m[2] - _finite(z, "z")


def _require_near(position_enu_m: Vector3) -> None:
    if not all(abs(c) < 1e5 for c in position_enu_m):
        raise RpcError("the place is farther than 100 km away; valid: one within the scene")


def _finite(value: float, name: str) -> float:
    if not abs(value) <= 1e6:
        raise RpcError(f"{name} {value} is not valid; valid: a number up to 1,000,000")
    return value


def _speed(velocity: float) -> float:
    if not 0.0 < velocity < math.inf:
        raise RpcError(f"velocity {velocity} is not valid; valid: above 0 m/s")
    return velocity


def _duration(duration: float) -> float:
    if math.isnan(duration):
        raise RpcError("duration is not a number; valid: seconds")
    return duration


def _timeout(timeout_s: float) -> float:
    if math.isnan(timeout_s):
        raise RpcError("timeout_sec is not a number; valid: seconds")
    return max(timeout_s, 0.0)


def _quat(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Attitude from FLU to ENU of angles in forward-right-down, from north."""
    for name, value in (("roll", roll), ("pitch", pitch), ("yaw", yaw)):
        _finite(value, name)
    cr, sr = math.cos(0.5 * roll), math.sin(0.5 * roll)
    cp, sp = math.cos(0.5 * pitch), math.sin(0.5 * pitch)
    cy, sy = math.cos(0.5 * yaw), math.sin(0.5 * yaw)
    frd = (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )
    return swap_quat_enu_flu_ned_frd(frd)


def _level_quat(roll: float, pitch: float) -> Quaternion:
    """The same for a nose to the east, whose yaw in the scene is zero."""
    return _quat(roll, pitch, 0.5 * math.pi)


def _rates(roll_rate: float, pitch_rate: float, yaw_rate: float) -> Vector3:
    rates = (roll_rate, pitch_rate, yaw_rate)
    if not all(abs(rate) <= 50.0 for rate in rates):
        raise RpcError(f"angular rates {rates} are not valid; valid: up to 50 rad/s each")
    return swap_flu_frd(rates)
