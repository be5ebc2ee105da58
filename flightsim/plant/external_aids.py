"""Fixes and poses from outside the plant, in the place of its own receiver and odometry.

If you test a receiver or an odometry of your own, your data reaches the filter through here. While
you feed one, the plant's own sensor of that kind measures nothing. Afterwards it starts again, as
after a loss of signal. A flight without such input is the same, bit for bit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum, unique
from typing import Any

import numpy as np

from autonomy.estimation.alignment import collect_fix
from autonomy.estimation.error_state import N_PAST
from autonomy.estimation.fusion import fuse_gnss
from autonomy.estimation.motion_capture import fuse_pose, fuse_velocity, restart_position
from autonomy.estimation.odometry import fuse_odometry
from autonomy.types import Vector3
from flightsim.sensors.failure import Failure
from flightsim.sensors.gnss import GNSS
from flightsim.sensors.mocap import MOCAP
from flightsim.sensors.vio import VIO

_GNSS_PATIENCE_S = 2.0
"""Age of the last accepted fix from which on satellites count as lost."""
_FIX_2D = 2
"""Least GPS_FIX_TYPE with a position."""
_MOST_REFUSED = 10
"""Consecutive poses beyond the gate after which the filter starts from the next one."""
_NEVER_TICKS = -(1 << 60)
"""Time under the sky of a receiver that hears nothing. It is far below zero because the plant
counts it up at every tick."""
_UNUSED = math.inf
"""Variance of an axis that the filter should not use."""
_UNKNOWN_VELOCITY_MPS = 1e3
"""Standard deviation of a velocity that a fix does not have."""
_OWN_FIX = ("fix_type", "reported_accuracy_m", "is_enabled")
"""Fields of the receiver that fixes from outside overwrite, and that are restored afterwards."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Fix:
    """A fix of a receiver, position and velocity in the scene's ENU frame."""

    position_enu_m: Vector3
    velocity_enu_mps: Vector3 | None
    """None if the receiver measures none."""
    fix_type: int
    """MAVLink's GPS_FIX_TYPE; below 2 there is no position."""
    sigma_m: tuple[float, float]
    """Horizontal (each axis) and vertical standard deviation; infinite for an axis to leave out."""
    sigma_mps: float
    """Standard deviation of each axis of the velocity."""
    n_satellites: int
    age_s: float = 0.0
    """Time since the fix was valid."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Pose:
    """A pose and its uncertainty; an infinite variance leaves its axes out."""

    position_enu_m: Vector3
    yaw_rad: float
    level_variance_m2: float = _UNUSED
    height_variance_m2: float = _UNUSED
    yaw_variance_rad2: float = _UNUSED
    is_relative: bool = False
    """True if its frame has an origin and a heading of its own."""
    age_s: float = 0.0
    """Time since the pose was valid."""


@unique
class FixSource(Enum):
    """Sources that fixes may come from."""

    EITHER = "either"
    """From outside as long as such fixes arrive, otherwise from the vehicle's receiver."""
    OWN = "own"
    CLIENT = "client"
    NONE = "none"


@unique
class PoseUse(Enum):
    """Outcome of feeding a pose."""

    FUSED = "fused"
    RESTARTED = "restarted"
    """The filter's position was set to the pose: it was the first of a source, or the last of many
    refused."""
    REFUSED = "refused"
    """The position lies beyond its gate, and nothing of the pose was used."""
    HEADING_REFUSED = "heading refused"
    """The position was used; the heading lies beyond its gate."""
    WAITING = "waiting"
    """The filter is not aligned yet."""


class ExternalAids:
    """Input of positions from outside to a plant's filter.

    Attributes:
        is_fed_fixes: True while fixes from outside take the receiver's place.
        is_fed_poses: True while poses from outside take the odometry's place.
    """

    def __init__(self, record: np.void, tick_us: int) -> None:
        """Feed the filter of a record of `PLANT_DTYPE`."""
        self._filter: Any = record["filter"]
        self._engine: np.void = record["engine"]
        self._gnss: np.void = record[GNSS.name]
        self._odometries: tuple[np.void, ...] = (record[VIO.name], record[MOCAP.name])
        self._tick_s = 1e-6 * tick_us
        self._own_fix: dict[str, Any] = {}
        self._is_absolute = False
        self._is_started = False
        self._n_refused = 0
        self.is_fed_fixes = self.is_fed_poses = False
        self._fix_source = FixSource.EITHER

    # --- fixes ---

    @property
    def fix_source(self) -> FixSource:
        """Source of fixes; a change takes effect at once."""
        return self._fix_source

    @fix_source.setter
    def fix_source(self, source: FixSource) -> None:
        if source is self._fix_source:
            return
        self._fix_source = source
        if source in {FixSource.CLIENT, FixSource.NONE}:
            self.begin_fixes()
            self.lose_fix()
        else:
            self.end_fixes()

    def begin_fixes(self) -> None:
        """Replace the receiver; there is no fix until one is fed."""
        if self.is_fed_fixes:
            return
        r = self._gnss
        self._own_fix = {name: np.copy(r[name]) for name in _OWN_FIX}
        self.is_fed_fixes = True
        r["is_replaced"], r["is_enabled"] = 1, 1
        self.lose_fix()

    def lose_fix(self) -> None:
        """Report no fix until the next one is fed."""
        self._gnss["under_sky_ticks"] = _NEVER_TICKS

    def end_fixes(self) -> None:
        """Give the receiver back its place; it searches for satellites again."""
        if not self.is_fed_fixes:
            return
        r = self._gnss
        for name, value in self._own_fix.items():
            r[name] = value
        r["is_replaced"] = 0
        r["settling_sigma_m"] = r["reacquired_sigma_m"]
        r["under_sky_ticks"] = 0
        self.is_fed_fixes = False

    def feed_fix(self, fix: Fix) -> None:
        """Use a fix in place of the receiver's, in its reading and in the filter.

        Args:
            fix: Fix from outside; one without a position counts as a lost one.
        """
        self.begin_fixes()
        r, f = self._gnss, self._filter
        if fix.fix_type < _FIX_2D or r["failure"][0] == Failure.OFF:
            self.lose_fix()
            return
        age_ticks = self._age_ticks(fix.age_s)
        velocity = fix.velocity_enu_mps or (0.0, 0.0, 0.0)
        level_m, height_m = fix.sigma_m
        r["tick"] = max(0, int(self._engine["tick"]) - age_ticks)
        r["position_enu_m"], r["velocity_enu_mps"] = fix.position_enu_m, velocity
        r["fix_type"], r["n_heard"] = fix.fix_type, fix.n_satellites
        r["reported_accuracy_m"] = [s if math.isfinite(s) else 0.0 for s in fix.sigma_m]
        r["dilution"], r["multipath_now_sigma_m"], r["is_float"] = 1.0, 0.0, 0
        r["settling_sigma_m"] = 0.0
        r["under_sky_ticks"] = r["reacquire_ticks"]
        sigma_m = np.array([level_m, level_m, height_m])
        sigma_m[~np.isfinite(sigma_m)] = _UNKNOWN_VELOCITY_MPS
        sigma_mps = fix.sigma_mps if fix.velocity_enu_mps else _UNKNOWN_VELOCITY_MPS
        position = np.array(fix.position_enu_m)
        if f["is_aligned"]:
            fuse_gnss(f, position, np.array(velocity), age_ticks, sigma_m, np.full(3, sigma_mps))
        else:
            collect_fix(f, position, sigma_m)

    # --- poses ---

    def begin_poses(self) -> None:
        """Replace the odometry; without satellites, fed poses are absolute positions."""
        if self.is_fed_poses:
            return
        self.is_fed_poses, self._is_started = True, False
        self._is_absolute = not self._has_satellites
        for r in self._odometries:
            r["is_replaced"] = 1
        self.expect_jump()

    def end_poses(self) -> None:
        """Let the vehicle's own odometry go on from the vehicle's present position."""
        if not self.is_fed_poses:
            return
        self.is_fed_poses = False
        for r in self._odometries:
            # No sample is under way: an old one must not arrive late.
            r["is_replaced"], r["tick"] = 0, -1
        self._filter["has_vio"] = 0

    def expect_jump(self) -> None:
        """Start anew with the next pose, because its source has restarted."""
        self._is_started = False
        self._filter["has_vio"] = 0

    def feed_pose(self, pose: Pose) -> PoseUse:
        """Let the filter use a pose instead of the odometry's.

        Args:
            pose: Pose from outside, relative to its own start or in the scene's frame.

        Returns:
            What the filter did with it; `PoseUse.WAITING` before it is aligned.
        """
        self.begin_poses()
        f = self._filter
        position = np.array(pose.position_enu_m)
        if not f["is_aligned"]:
            if not pose.is_relative:
                f["has_start"], f["start_enu_m"] = 1, position
            return PoseUse.WAITING
        age_ticks = self._age_ticks(pose.age_s)
        variances = (pose.level_variance_m2, pose.height_variance_m2, pose.yaw_variance_rad2)
        if pose.is_relative or not self._is_absolute:
            fuse_odometry(f, position, pose.yaw_rad, age_ticks, *variances)
            return PoseUse.FUSED
        return self._fuse_absolute(position, pose.yaw_rad, age_ticks, variances)

    def _fuse_absolute(
        self,
        position_enu_m: np.ndarray,
        yaw_rad: float,
        age_ticks: int,
        variances: tuple[float, float, float],
    ) -> PoseUse:
        """Fuse a pose in the world.

        A pose beyond the gate restarts the filter's position if it is the first of its source, or
        if many in a row were refused.
        """
        f = self._filter
        worst, yaw_ratio = fuse_pose(f, position_enu_m, yaw_rad, age_ticks, *variances)
        is_first, self._is_started = not self._is_started, True
        if worst <= 1.0:
            self._n_refused = 0
            return PoseUse.FUSED if yaw_ratio <= 1.0 else PoseUse.HEADING_REFUSED
        self._n_refused += 1
        if not is_first and self._n_refused < _MOST_REFUSED:
            return PoseUse.REFUSED
        self._n_refused = 0
        restart_position(f, position_enu_m, age_ticks, *variances[:2])
        return PoseUse.RESTARTED

    def feed_velocity(self, velocity_enu_mps: Vector3, variance: float, age_s: float) -> None:
        """Let the filter use a velocity; nothing happens before it is aligned.

        Args:
            velocity_enu_mps: Measured velocity.
            variance: Variance of each axis in m^2/s^2.
            age_s: Time since it was measured.
        """
        if self._filter["is_aligned"]:
            velocity = np.array(velocity_enu_mps)
            fuse_velocity(self._filter, velocity, self._age_ticks(age_s), variance)

    @property
    def _has_satellites(self) -> bool:
        f = self._filter
        age_s = self._tick_s * (int(f["tick"]) - int(f["last_gnss_tick"]))
        r = self._gnss
        is_on = r["is_enabled"] and r["failure"][0] != Failure.OFF and r["tick"] >= 0
        is_fixed = is_on and r["under_sky_ticks"] >= r["reacquire_ticks"]
        return bool(is_fixed and age_s < _GNSS_PATIENCE_S)

    def _age_ticks(self, age_s: float) -> int:
        # The filter remembers N_PAST ticks: an older measurement counts as that old.
        return max(0, min(N_PAST - 2, round(age_s / self._tick_s)))
