"""Gimbal: holds a camera level and points it, within limits of angle and rate.

A gimbal has a goal for each axis and turns towards it at no more than a greatest rate. Angles set
the goals, rates move them a little at every tick, and a target that is followed sets them from its
direction; so one law of motion serves all of these. Pitch is counted downwards from the horizon, as
a rotation about the left axis is positive in FLU.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import atan2, hypot, isfinite, radians

from autonomy.types import Vector3
from flightsim.autopilot.heading import wrap_angle

TICK_S = 0.02
_REACHED_RAD = 1e-9
"""Step below which an axis counts as having arrived."""
_NEAREST_M = 0.1
"""Distance within which a target has no direction."""

Target = Callable[[], Vector3 | None]
"""Function that returns the place to look at, in ENU, or None while there is none."""


@dataclass(frozen=True, kw_only=True, slots=True)
class GimbalCfg:
    """Limits of a gimbal; its yaw turns without end, and its roll is always level."""

    highest_pitch_down_rad: float = -radians(30.0)
    lowest_pitch_down_rad: float = radians(90.0)
    max_rate_radps: float = radians(60.0)
    """Greatest rate about either axis."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Pointing:
    """Command to a gimbal: angles to turn to or rates to turn at; None leaves an axis alone."""

    pitch_down_rad: float | None = None
    """Angle below the horizon to pitch to."""
    yaw_rad: float | None = None
    """Angle to yaw to, counter-clockwise from the vehicle's nose, or from east where it is locked.
    """
    pitch_down_rate_radps: float | None = None
    """Rate at which to turn, or the greatest rate on the way to an angle if one is given."""
    yaw_rate_radps: float | None = None
    is_yaw_locked: bool = False
    """True if the yaw stays with the world, instead of following the vehicle."""


class Gimbal:
    """Two driven axes and a level one; `update` once every 20 ms.

    Attributes:
        pitch_down_rad: Present pitch below the horizon.
        yaw_rad: Present yaw, counter-clockwise from the vehicle's nose, -pi to pi.
        pitch_down_rate_radps: Present rate of the pitch.
        yaw_rate_radps: Present rate of the yaw, relative to the vehicle.
        is_yaw_locked: True if the yaw stays with the world.
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
        """Turn to angles or at rates, and follow no target any more.

        Args:
            pointing: Angles and rates; those beyond the gimbal's limits are cut to them.
        """
        p, limit = pointing, self.cfg.max_rate_radps
        self._target = None
        self._is_resting = False
        self.is_yaw_locked = p.is_yaw_locked
        # The goal of a locked yaw counts from east, that of a free one from the nose.
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
        """Follow a target until the next command.

        Args:
            target: Called at every tick; while it returns None the gimbal rests.
        """
        self.point(Pointing())
        self._target = target

    def update(self, position_enu_m: Vector3, heading_rad: float) -> None:
        """Turn for one tick of 20 ms.

        Args:
            position_enu_m: Position of the vehicle by its own estimate.
            heading_rad: Heading of the vehicle by its own estimate, counter-clockwise from east; a
                value that is not finite leaves the gimbal as it is.
        """
        if not isfinite(heading_rad):
            return
        self._heading_rad = heading_rad
        # A gimbal that nobody uses costs next to nothing.
        if self._is_resting:
            return
        if self._target is not None:
            self._aim(position_enu_m, self._target())
        cfg = self.cfg
        goal_rad = self._goal_pitch_rad + self._turning_pitch_radps * TICK_S
        goal_rad = max(cfg.highest_pitch_down_rad, min(cfg.lowest_pitch_down_rad, goal_rad))
        # Cut at every tick, so a rate held at the end of the range does not wind the goal up.
        self._goal_pitch_rad = goal_rad
        self._goal_yaw_rad = wrap_angle(self._goal_yaw_rad + self._turning_yaw_radps * TICK_S)
        from_nose_rad = self._goal_yaw_rad - (heading_rad if self.is_yaw_locked else 0.0)
        pitch = _step(goal_rad - self.pitch_down_rad, self._fastest_pitch_radps)
        yaw = _step(wrap_angle(from_nose_rad - self.yaw_rad), self._fastest_yaw_radps)
        self.pitch_down_rad += pitch
        self.yaw_rad = wrap_angle(self.yaw_rad + yaw)
        self.pitch_down_rate_radps, self.yaw_rate_radps = pitch / TICK_S, yaw / TICK_S
        # A locked yaw turns against the vehicle, so it never rests.
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
        # Straight above or below there is no direction to yaw to; the yaw stays.
        if level_m >= _NEAREST_M:
            self._goal_yaw_rad = wrap_angle(atan2(north, east) - self._heading_rad)


def _rates(rate_radps: float | None, limit_radps: float, *, has_goal: bool) -> tuple[float, float]:
    """Return the rate at which to turn without end, and the greatest rate on the way to a goal.

    Args:
        rate_radps: Rate of the command; None if it has none.
        limit_radps: Greatest rate of the gimbal.
        has_goal: True if the command has an angle for this axis, whose rate then has no sign.
    """
    if rate_radps is None:
        return 0.0, limit_radps
    if not has_goal:
        return max(-limit_radps, min(limit_radps, rate_radps)), limit_radps
    # A rate of 0 beside an angle sets no limit; as one it would stop the axis.
    return 0.0, min(abs(rate_radps), limit_radps) or limit_radps


def _step(way_rad: float, rate_radps: float) -> float:
    """Return the part of an angle that one tick covers at a greatest rate."""
    return max(-rate_radps * TICK_S, min(rate_radps * TICK_S, way_rad))
