"""AirSim's moves as tasks of a `Flyer`; each returns what the call answers."""

from __future__ import annotations

import math
from collections.abc import Sequence

from autonomy.types import Quaternion, Vector3
from flightsim.frames import swap_yaw_enu_ned
from scenarios.airsim.flyer import Flyer, Task
from scenarios.airsim.guidance import (
    FASTEST_UP_MPS,
    FASTEST_XY_MPS,
    TICK_S,
    Facing,
    legs_through,
)
from scenarios.airsim.messages import YawMode

TAKEOFF_M, TAKEOFF_MPS = 3.0, 1.0
_NEAR_M = 0.5
_STILL_MPS = 0.3
_HEIGHT_GAIN, _CLIMB_GAIN = 2.0, 2.5
_GRAVITY_MPS2 = 9.81
_STICK_DPS = 60.0
"""Rate of turn of a yaw stick that is held all the way."""


def take_off(flyer: Flyer) -> Task:
    """Climb by three metres and hold."""
    yield from flyer.engage()
    x, y, z = flyer.guidance.position_enu_m
    yield from _reach(flyer, (x, y, z + TAKEOFF_M), TAKEOFF_MPS, Facing())
    return True


def land(flyer: Flyer) -> Task:
    """Let the autopilot land, until it stands with its rotors off or idle."""
    if flyer.is_landed:
        return True
    yield from flyer.hand_over(flyer.client.habits.land_here)
    while not flyer.is_landed:
        yield
    return True


def go_home(flyer: Flyer) -> Task:
    """Let the autopilot return and land."""
    if flyer.is_landed:
        return True
    yield from flyer.hand_over(flyer.client.habits.return_home)
    while not flyer.is_landed:
        yield
    return True


def hover(flyer: Flyer) -> Task:
    """Come to rest."""
    if flyer.is_landed and not flyer.is_armed:
        return True
    yield from flyer.engage()
    flyer.guidance.stop()
    while not (flyer.guidance.is_at_rest and flyer.speed_mps < _STILL_MPS):
        _stand(flyer, Facing())
        yield
    return True


def move_on_path(
    flyer: Flyer, points_enu_m: Sequence[Vector3], speed_mps: float, facing: Facing
) -> Task:
    """Fly along lines through points, and stop at the last."""
    yield from flyer.engage()
    guidance = flyer.guidance
    for leg in legs_through(guidance.position_enu_m, points_enu_m, speed_mps):
        start_enu_m = leg.start_enu_m
        while True:
            guidance.fly_to(
                leg.goal_enu_m,
                speed_mps,
                line_start_enu_m=start_enu_m,
                exit_speed_mps=leg.exit_speed_mps,
            )
            if (yield from _fly_leg(flyer, leg.goal_enu_m, leg.radius_m, facing)):
                break
            start_enu_m = None
    return True


def _reach(flyer: Flyer, goal_enu_m: Vector3, speed_mps: float, facing: Facing) -> Task:
    while True:
        flyer.guidance.fly_to(goal_enu_m, speed_mps)
        if (yield from _fly_leg(flyer, goal_enu_m, 0.0, facing)):
            return True


def _fly_leg(flyer: Flyer, goal_enu_m: Vector3, radius_m: float, facing: Facing) -> Task:
    """Fly a line; False if the reference had to return to the vehicle, and the line begins anew."""
    guidance = flyer.guidance
    while True:
        guidance.step_path()
        if flyer.follow(facing):
            return False
        yield
        if math.dist(guidance.position_enu_m, goal_enu_m) <= radius_m:
            return True
        is_there = math.dist(flyer.position_enu_m, goal_enu_m) < _NEAR_M
        if guidance.is_at_rest and is_there and flyer.speed_mps < _STILL_MPS:
            return True


def move_by_velocity(
    flyer: Flyer,
    velocity_enu_mps: Vector3,
    duration_s: float,
    facing: Facing,
    height_m: float | None = None,
) -> Task:
    """Fly at a velocity for some time, at a height if one is given."""
    if duration_s <= 0.0:
        return True
    yield from flyer.engage()
    for _ in range(_ticks(duration_s)):
        flyer.guidance.step_velocity(velocity_enu_mps, height_m)
        flyer.follow(facing)
        yield
    return True


def move_in_heading(
    flyer: Flyer,
    forward_mps: float,
    right_mps: float,
    up_mps: float,
    duration_s: float,
    facing: Facing,
    height_m: float | None = None,
) -> Task:
    """The same with a velocity along the heading that the vehicle has at the beginning."""
    yield from flyer.engage()
    yaw = flyer.yaw_rad
    east = forward_mps * math.cos(yaw) + right_mps * math.sin(yaw)
    north = forward_mps * math.sin(yaw) - right_mps * math.cos(yaw)
    return (yield from move_by_velocity(flyer, (east, north, up_mps), duration_s, facing, height_m))


def move_by_sticks(
    flyer: Flyer, fastest_mps: tuple[float, float], highest_m: float, duration_s: float
) -> Task:
    """Fly as the sticks of a radio say, for some time.

    Args:
        flyer: The vehicle.
        fastest_mps: Speed ahead and sideways at full sticks.
        highest_m: Height in the scene above which the throttle climbs no more.
        duration_s: Simulated time.
    """
    yield from flyer.engage()
    ahead_mps, aside_mps = (min(abs(speed), FASTEST_XY_MPS) for speed in fastest_mps)
    for _ in range(_ticks(duration_s)):
        sticks = flyer.sticks
        yaw = flyer.yaw_rad
        forward, right = ahead_mps * sticks.pitch, aside_mps * sticks.roll
        east = forward * math.cos(yaw) + right * math.sin(yaw)
        north = forward * math.sin(yaw) - right * math.cos(yaw)
        up_mps = (2.0 * sticks.throttle - 1.0) * FASTEST_UP_MPS if sticks.is_valid else 0.0
        if flyer.guidance.position_enu_m[2] >= highest_m:
            up_mps = min(up_mps, 0.0)
        flyer.guidance.step_velocity((east, north, up_mps))
        rate = YawMode(is_rate=True, yaw_or_rate=_STICK_DPS * sticks.yaw)
        flyer.follow(Facing(mode=rate))
        yield
    return True


def rotate_to(flyer: Flyer, heading_deg: float, margin_deg: float) -> Task:
    """Turn to a heading, clockwise from north, where the vehicle is."""
    yield from flyer.engage()
    facing = Facing(mode=YawMode(is_rate=False, yaw_or_rate=heading_deg))
    goal = swap_yaw_enu_ned(math.radians(heading_deg))
    flyer.guidance.stop()
    while True:
        off = math.remainder(flyer.yaw_rad - goal, 2.0 * math.pi)
        if abs(off) <= math.radians(max(margin_deg, 0.5)):
            return True
        _stand(flyer, facing)
        yield


def rotate_by(flyer: Flyer, rate_dps: float, duration_s: float) -> Task:
    """Turn at a rate where the vehicle is."""
    if duration_s <= 0.0:
        return True
    yield from flyer.engage()
    facing = Facing(mode=YawMode(is_rate=True, yaw_or_rate=rate_dps))
    flyer.guidance.stop()
    for _ in range(_ticks(duration_s)):
        _stand(flyer, facing)
        yield
    return True


def point(
    flyer: Flyer,
    attitude: Quaternion | None,
    rates_flu_radps: Vector3,
    thrust: float | None,
    duration_s: float,
    *,
    height_m: float = 0.0,
    hover_thrust: float = 0.0,
    yaw_rate_radps: float | None = None,
) -> Task:
    """Hold an attitude or angular rates for some time.

    Args:
        flyer: The vehicle.
        attitude: From FLU to ENU; None for rates alone.
        rates_flu_radps: Angular rates.
        thrust: Share of the greatest thrust; None keeps to a height.
        duration_s: Simulated time.
        height_m: Height to keep to.
        hover_thrust: Share of the greatest thrust at which the vehicle hovers.
        yaw_rate_radps: Rate, counter-clockwise, at which the heading of the attitude turns from
            the vehicle's own; None takes the attitude as it is.
    """
    if duration_s <= 0.0:
        return True
    yield from flyer.engage()
    yaw = flyer.yaw_rad
    for _ in range(_ticks(duration_s)):
        share = thrust
        if share is None:
            share = _thrust_for_height(flyer, height_m, hover_thrust)
        quat = attitude
        if attitude is not None and yaw_rate_radps is not None:
            yaw += yaw_rate_radps * TICK_S
            quat = _turned(attitude, yaw)
        flyer.point(quat, rates_flu_radps, min(max(share, 0.0), 1.0))
        yield
    return True


def _stand(flyer: Flyer, facing: Facing) -> None:
    """Keep to the place where the reference comes to rest, for one tick."""
    flyer.guidance.step_path()
    if flyer.follow(facing):
        flyer.guidance.stop()


def _turned(quat_wxyz: Quaternion, yaw_rad: float) -> Quaternion:
    """An attitude turned about the vertical."""
    w, x, y, z = quat_wxyz
    c, s = math.cos(0.5 * yaw_rad), math.sin(0.5 * yaw_rad)
    return (c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w)


def _thrust_for_height(flyer: Flyer, height_m: float, hover_thrust: float) -> float:
    telemetry = flyer.client.telemetry
    up_mps2 = _HEIGHT_GAIN * (height_m - telemetry.position_enu_m[2])
    up_mps2 -= _CLIMB_GAIN * telemetry.velocity_enu_mps[2]
    _, x, y, _ = telemetry.quat_wxyz
    tilt = max(1.0 - 2.0 * (x * x + y * y), 0.5)
    return hover_thrust * (1.0 + min(max(up_mps2, -4.0), 4.0) / _GRAVITY_MPS2) / tilt


def _ticks(duration_s: float) -> int:
    return round(min(duration_s, 1e9) / TICK_S)
