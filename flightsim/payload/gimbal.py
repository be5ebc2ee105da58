"""Gimbal: holds a camera level and points it, at most so far and so fast."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import atan2, hypot, isfinite, radians

from autonomy.types import Vector3
from flightsim.autopilot.heading import wrap_angle

TICK_S = 0.02
_REACHED_RAD = 1e-9
_NEAREST_M = 0.1
"""Distance within which a target has no direction."""

Target = Callable[[], Vector3 | None]
"""Where to look at, in ENU; None where there is nothing at present."""


@dataclass(frozen=True, kw_only=True, slots=True)
class GimbalCfg:
    """Limits of a gimbal; about the vertical it turns without end, and roll is always level."""

    highest_pitch_down_rad: float = -radians(30.0)
    lowest_pitch_down_rad: float = radians(90.0)
    max_rate_radps: float = radians(60.0)
    """Greatest rate about either axis."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Pointing:
    """What a gimbal is told: angles to turn to or rates to turn at; None leaves an axis alone."""

    pitch_down_rad: float | None = None
    """Pitch below the horizon."""
    yaw_rad: float | None = None
    """Counter-clockwise from the vehicle's nose, or from east where the yaw is locked."""
    pitch_down_rate_radps: float | None = None
    """Rate at which to turn, or not to be exceeded on the way to an angle."""
    yaw_rate_radps: float | None = None
    is_yaw_locked: bool = False
    """Whether the yaw stays with the world, instead of following the vehicle."""


class Gimbal:
    """Two driven axes and a level one; `update` once every 20 ms.

    Attributes:
        pitch_down_rad: Present pitch below the horizon.
        yaw_rad: Present yaw, counter-clockwise from the vehicle's nose, -pi to pi.
        pitch_down_rate_radps: Present rate of the pitch.
        yaw_rate_radps: Present rate of the yaw.
        is_yaw_locked: Whether the yaw stays with the world.
    """

    def __init__(self, cfg: GimbalCfg | None = None) -> None:
        """Start level and straight ahead."""
        self.cfg = cfg or GimbalCfg()
        self.pitch_down_rad = self.yaw_rad = 0.0
        self.pitch_down_rate_radps = self.yaw_rate_radps = 0.0
        self.is_yaw_locked = False
        self._heading_rad = 0.0
        self._target: Target | None = None
        self._goal_pitch_rad = self._goal_yaw_rad = 0.0
        self._turning_pitch_radps = self._turning_yaw_radps = 0.0
        self._fastest_pitch_radps = self._fastest_yaw_radps = self.cfg.max_rate_radps
        self._is_resting = True

    def point(self, pointing: Pointing) -> None:
        """Turn to angles or at rates, and follow no target any more."""
        p, limit = pointing, self.cfg.max_rate_radps
        self._target = None
        self._is_resting = False
        self.is_yaw_locked = p.is_yaw_locked
        yaw_rad = self.yaw_rad + (self._heading_rad if p.is_yaw_locked else 0.0)
        self._goal_pitch_rad = self.pitch_down_rad if p.pitch_down_rad is None else p.pitch_down_rad
        self._goal_yaw_rad = yaw_rad if p.yaw_rad is None else p.yaw_rad
        self._turning_pitch_radps, self._fastest_pitch_radps = _rates(
            p.pitch_down_rate_radps, limit, has_goal=p.pitch_down_rad is not None
        )
        self._turning_yaw_radps, self._fastest_yaw_radps = _rates(
            p.yaw_rate_radps, limit, has_goal=p.yaw_rad is not None
        )

    def look_at(self, target: Target) -> None:
        """Follow a target until the gimbal is told something else."""
        self.point(Pointing())
        self._target = target

    def update(self, position_enu_m: Vector3, heading_rad: float) -> None:
        """Turn for one tick.

        Args:
            position_enu_m: Position of the vehicle as it knows it.
            heading_rad: Heading of the vehicle as it knows it, counter-clockwise from east.
        """
        if not isfinite(heading_rad):
            return
        self._heading_rad = heading_rad
        if self._is_resting:
            return
        if self._target is not None:
            self._aim(position_enu_m, self._target())
        cfg = self.cfg
        goal_rad = self._goal_pitch_rad + self._turning_pitch_radps * TICK_S
        goal_rad = max(cfg.highest_pitch_down_rad, min(cfg.lowest_pitch_down_rad, goal_rad))
        self._goal_pitch_rad = goal_rad
        self._goal_yaw_rad = wrap_angle(self._goal_yaw_rad + self._turning_yaw_radps * TICK_S)
        from_nose_rad = self._goal_yaw_rad - (heading_rad if self.is_yaw_locked else 0.0)
        pitch = _step(goal_rad - self.pitch_down_rad, self._fastest_pitch_radps)
        yaw = _step(wrap_angle(from_nose_rad - self.yaw_rad), self._fastest_yaw_radps)
        self.pitch_down_rad += pitch
        self.yaw_rad = wrap_angle(self.yaw_rad + yaw)
        self.pitch_down_rate_radps, self.yaw_rate_radps = pitch / TICK_S, yaw / TICK_S
        is_driven = self._target is not None or self.is_yaw_locked
        is_turning = self._turning_pitch_radps != 0.0 or self._turning_yaw_radps != 0.0
        is_there = abs(pitch) + abs(yaw) < _REACHED_RAD
        self._is_resting = is_there and not (is_driven or is_turning)

    def _aim(self, position_enu_m: Vector3, target_enu_m: Vector3 | None) -> None:
        if target_enu_m is None:
            return
        east, north, up = (b - a for a, b in zip(position_enu_m, target_enu_m, strict=True))
        level_m = hypot(east, north)
        if not isfinite(level_m + up) or level_m + abs(up) < _NEAREST_M:
            return
        self._goal_pitch_rad = -atan2(up, level_m)
        if level_m >= _NEAREST_M:
            self._goal_yaw_rad = wrap_angle(atan2(north, east) - self._heading_rad)


def _rates(rate_radps: float | None, limit_radps: float, *, has_goal: bool) -> tuple[float, float]:
    """Rate at which to turn without end, and the greatest rate on the way to a goal."""
    if rate_radps is None:
        return 0.0, limit_radps
    if not has_goal:
        return max(-limit_radps, min(limit_radps, rate_radps)), limit_radps
    return 0.0, min(abs(rate_radps), limit_radps) or limit_radps


def _step(way_rad: float, rate_radps: float) -> float:
    """Part of a way that one tick covers."""
    return max(-rate_radps * TICK_S, min(rate_radps * TICK_S, way_rad))
