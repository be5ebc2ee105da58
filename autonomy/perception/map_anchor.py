"""Offset and yaw of the frame of the estimate in the map, corrected by depth images.

    symbol   name                                        unit
    x        offset o (3) and yaw a of the anchor        m, rad
    P        its covariance
    q        position by the estimate, ENU               m

    in the map: q + o, and every direction turned by a about the vertical

A receiver of metre grade wanders and odometry drifts; the view of a known map does not. The
autopilot's filter is not ours to change, so the companion keeps the difference itself. x is a
random walk. Each depth image is registered with the map (`registration.py`) and fused as a
measurement of only those directions that it determines: over a level roof that is the height, along
a wall everything but the position along it.

Source: Bar-Shalom, Li and Kirubarajan 2001, "Estimation with applications to tracking and
navigation", section 5.2 (Kalman filter); Zhang, Kaess and Singh 2016, "On degeneracy of
optimization-based state estimation problems" (directions left alone).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from autonomy.perception.anchor_fix import AnchorFix
from autonomy.perception.depth_image import DepthImage
from autonomy.perception.leaps import Leaps
from autonomy.perception.level_fix import level_fix
from autonomy.perception.map_anchor_cfg import MapAnchorCfg
from autonomy.perception.match import Match, Matcher
from autonomy.rotation import wrap_angle
from autonomy.types import FlatReference, Quaternion, Vector3

_BARE_RECEIVER = MapAnchorCfg()
_LONGEST_PAUSE_S = 60.0  # beyond it the walk's variance grows no further
_LONGEST_STEP_S = 0.5
"""Longest time over which two velocities give the distance flown."""
_HEIGHT_TO_ACROSS = 1.5
"""Ratio of a receiver's vertical deviation to the horizontal one. Height is worse because of the
ionosphere and because no satellites are below."""


class MapAnchor:
    """Ties the estimate of a vehicle to a map, given or seen so far.

    Attributes:
        fix: Result of the latest image, None before the first.
    """

    def __init__(self, matcher: Matcher, cfg: MapAnchorCfg = _BARE_RECEIVER) -> None:
        """Start without an image, from the deviations that the estimate claims.

        Args:
            matcher: Matches images with the map.
            cfg: Error of the estimate.
        """
        self._cfg = cfg
        self._matcher = matcher
        self._claimed_m = (math.nan, math.nan)
        self._x = np.zeros(4)
        self._covariance = self._claimed_covariance()
        self._leaps = Leaps()
        self._in_use = np.zeros(4)
        self._rate = np.zeros(4)
        self._placed_m = np.zeros(3)
        self._followed: tuple[float, Vector3, Vector3] | None = None
        self._time_s: float | None = None
        self._used_at_s: float | None = None
        self.fix: AnchorFix | None = None

    @property
    def sigma_m(self) -> float:
        """Standard deviation of the offset, in the worst horizontal direction, m."""
        return math.sqrt(float(np.linalg.eigvalsh(self._covariance[:2, :2])[-1]))

    @property
    def offset_enu_m(self) -> Vector3:
        """Offset that is added at present to a position of the estimate, m."""
        east, north, up, _ = self._in_use.tolist()
        return east, north, up

    def claim(
        self, horizontal_m: float, vertical_m: float = math.inf, *, is_adrift: bool = False
    ) -> None:
        """Adopt the standard deviations that the autopilot claims for each axis of its estimate.

        A better estimate drifts less between images and needs a smaller search.

        Args:
            horizontal_m: Deviation of each horizontal axis; infinity counts as a bare receiver's.
            vertical_m: Deviation of the height; infinity stands for 1.5 times the horizontal one.
            is_adrift: True while nothing measures the position; the offset's deviation then grows
                by as much as the claim does.
        """
        if (horizontal_m, vertical_m) == self._claimed_m:
            return
        if is_adrift and horizontal_m > self._claimed_m[0]:
            # Drift is one motion, not a walk: deviations add up, each axis's share of them.
            more_m = (horizontal_m - self._claimed_m[0]) / math.sqrt(2.0)
            sigma_m = np.sqrt(self._covariance.diagonal()[:2])
            more = (sigma_m + more_m) ** 2 - sigma_m**2
            self._covariance = self._covariance + np.diag([*more, 0.0, 0.0])
        self._claimed_m = (horizontal_m, vertical_m)
        if not math.isfinite(vertical_m):
            vertical_m = _HEIGHT_TO_ACROSS * horizontal_m
        self._cfg = self._cfg.for_accuracy(horizontal_m, vertical_m)
        if self._time_s is None:
            self._covariance = self._claimed_covariance()

    def stand_at(
        self, time_s: float, position_est_m: Vector3, position_map_m: Vector3, sigma_m: float = 0.1
    ) -> None:
        """Fuse the known position of the vehicle in the map, such as the pad that it starts from.

        The offset in use jumps there, because nothing flies yet. `sigma_m` holds for each axis.
        """
        self._let_drift(time_s)
        there = np.subtract(position_map_m, position_est_m)
        self._fuse(there, np.eye(4)[:, :3], np.full(3, sigma_m**2))
        self._placed_m = self._x[:3].copy()
        self._in_use, self._rate = self._x.copy(), np.zeros(4)
        self._used_at_s = time_s

    def follow(self, time_s: float, position_est_m: Vector3, velocity_est_mps: Vector3) -> None:
        """Add to the offset the part of the position's motion that goes beyond the velocity.

        Fixes of a poor receiver draw the position along, while the velocity is that of odometry.
        """
        before, self._followed = self._followed, (time_s, position_est_m, velocity_est_mps)
        if before is None or not 0.0 < time_s - before[0] <= _LONGEST_STEP_S:
            return
        velocity = self.vector_to_map(velocity_est_mps)
        way = np.add(velocity, self.vector_to_map(before[2])) / 2 * (time_s - before[0])
        beyond = self._cfg.share_beyond * (way - np.subtract(position_est_m, before[1]))
        self._x[:3] += beyond
        self._in_use[:3] += beyond

    def update(self, time_s: float, image: DepthImage) -> AnchorFix:
        """Register a depth image, posed by the estimate, with the map, and fuse the result.

        An image that the map explains badly is matched again with a wider search. If that finds a
        far place, a second image must confirm it.
        """
        self._let_drift(time_s)
        match = self._matcher.match(image, self._x, self._covariance)
        # The wider search is undone if its result is refused.
        before, is_leap = self._covariance, False
        if match.is_doubtful:
            self._doubt()
            match = self._matcher.match(image, self._x, self._covariance)
            searched_wider = self._cfg.doubt_m > 0.0
            is_leap = searched_wider and self._leaps.is_first(time_s, match, self._x, before)
        else:
            self._leaps.see(match)
        reason = "another place, by one image alone" if is_leap else self._objection(match)
        level = None
        if reason is not None:
            self._covariance = before
        else:
            variances = self._variances(match)
            level = level_fix(match, variances, self._x, before)
            self._fuse(match.measured, match.directions, variances)
        # Learn an image that fits, or that no known surface can judge; not one that contradicts the
        # map.
        if match.objection is not None or reason is None:
            self._matcher.learn(image, self._x)
        east, north, up, yaw = self._x.tolist()
        self.fix = AnchorFix(
            accepted=reason is None,
            reason=reason or f"{match.directions.shape[1]} directions seen",
            offset_enu_m=(east, north, up),
            yaw_rad=yaw,
            residual_m=match.residual_m,
            inlier_share=match.inlier_share,
            sigma_m=self.sigma_m,
            level=level,
        )
        return self.fix

    def rely(self, time_s: float, image: DepthImage) -> None:
        """Take the offset known at the start for still valid, and learn an image unmatched.

        Use it for an estimate that is better than the images of a map seen so far.
        """
        self._let_drift(time_s)
        h, v = self._cfg.horizontal_sigma_m**2, self._cfg.vertical_sigma_m**2
        self._fuse(self._placed_m, np.eye(4)[:, :3], np.array([h, h, v]))
        self._matcher.learn(image, self._x)

    def advance(self, time_s: float) -> None:
        """Slew the offset in use towards the fused one, because set points must not jump."""
        elapsed_s = 0.0 if self._used_at_s is None else max(time_s - self._used_at_s, 0.0)
        self._used_at_s = time_s
        if elapsed_s == 0.0:
            return
        lack = self._x - self._in_use
        lack[3] = wrap_angle(lack[3])
        step = lack * -math.expm1(-elapsed_s / self._cfg.slew_s)
        away_m, most_m = float(np.linalg.norm(step[:3])), self._cfg.slew_mps * elapsed_s
        if away_m > most_m:
            step *= most_m / away_m
        self._in_use = self._in_use + step
        self._rate = step / elapsed_s

    def to_map(self, position_est_m: Vector3, yaw_est_rad: float) -> tuple[Vector3, float]:
        """Position and yaw of the vehicle in the map, from those of the estimate."""
        return self._moved(position_est_m), wrap_angle(yaw_est_rad + float(self._in_use[3]))

    def attitude_to_map(self, quat_est_wxyz: Quaternion) -> Quaternion:
        """Attitude in the map, from that of the estimate."""
        half = 0.5 * float(self._in_use[3])
        c, s = math.cos(half), math.sin(half)
        w, x, y, z = quat_est_wxyz
        return c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w

    def vector_to_map(self, vector_est: Vector3) -> Vector3:
        """A velocity or another direction in the map, from that of the estimate."""
        return _turned(vector_est, float(self._in_use[3]))

    def image_to_map(self, image: DepthImage) -> DepthImage:
        """An image posed in the map, from one posed by the estimate."""
        yaw_rad = float(self._in_use[3])
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return image.posed(
            self._moved(image.position_enu_m), turn @ image.rotation_enu_from_optical
        )

    def to_estimate(self, reference: FlatReference) -> FlatReference:
        """A set point in the frame of the estimate, from one in the map.

        Its velocity includes that of the slewing offset, so that the vehicle follows it without
        lag.
        """
        back_rad = -float(self._in_use[3])
        x, y, z = reference.position_enu_m
        east, north, up = self.offset_enu_m
        vx, vy, vz = _turned(reference.velocity_enu_mps, back_rad)
        rates: list[float] = self._rate.tolist()
        return replace(
            reference,
            position_enu_m=(x - east, y - north, z - up),
            velocity_enu_mps=(vx - rates[0], vy - rates[1], vz - rates[2]),
            acceleration_enu_mps2=_turned(reference.acceleration_enu_mps2, back_rad),
            jerk_enu_mps3=_turned(reference.jerk_enu_mps3, back_rad),
            yaw_rad=wrap_angle(reference.yaw_rad + back_rad),
        )

    def _moved(self, position_est_m: Vector3) -> Vector3:
        x, y, z = position_est_m
        east, north, up = self.offset_enu_m
        return x + east, y + north, z + up

    def _claimed_covariance(self) -> Float[np.ndarray, "4 4"]:
        cfg = self._cfg
        h, v, yaw = cfg.horizontal_sigma_m, cfg.vertical_sigma_m, cfg.yaw_sigma_rad
        return np.diag([h * h, h * h, v * v, yaw * yaw])

    def _let_drift(self, time_s: float) -> None:
        """Add the random walk since the last call to the covariance."""
        elapsed_s = 0.0 if self._time_s is None else time_s - self._time_s
        self._time_s = time_s
        cfg = self._cfg
        h, v, yaw = cfg.horizontal_walk**2, cfg.vertical_walk**2, cfg.yaw_walk**2
        walk = np.diag([h, h, v, yaw]) * min(max(elapsed_s, 0.0), _LONGEST_PAUSE_S)
        self._covariance = self._covariance + walk

    def _objection(self, match: Match) -> str | None:
        """Reason to refuse a match, None if there is none."""
        if match.objection is not None:
            return match.objection
        least = self._cfg.least_inlier_share
        if match.inlier_share < least:
            return f"the map explains {match.inlier_share:.0%} of the points; wanted: {least:.0%}"
        return None

    def _doubt(self) -> None:
        """Widen the search, because the map explains an image less well than it should.

        Perhaps something merely moves there, so no more is doubted than the estimate claims.
        """
        doubt_m = min(self._cfg.doubt_m, self._cfg.horizontal_sigma_m)
        h, v = doubt_m**2, (0.5 * doubt_m) ** 2
        more = np.array([h, h, v, 0.0])
        self._covariance = self._covariance + np.diag(more)
        most = np.maximum(self._claimed_covariance().diagonal(), more)
        shrink = np.sqrt(np.minimum(most / self._covariance.diagonal(), 1.0))
        self._covariance *= np.outer(shrink, shrink)

    def _variances(self, match: Match) -> Float[np.ndarray, " k"]:
        """Variance of each measured direction, with a floor that no image can beat."""
        floor = np.where(match.is_angle, self._cfg.fix_yaw_sigma_rad**2, self._cfg.fix_sigma_m**2)
        return match.variances + floor

    def _fuse(
        self,
        measured: Float[np.ndarray, " k"],
        directions: Float[np.ndarray, "4 k"],
        variances: Float[np.ndarray, " k"],
    ) -> None:
        """Kalman update by values of `directions.T @ x`."""
        if not len(measured):
            return
        spread = self._covariance @ directions
        gain = spread @ np.linalg.inv(directions.T @ spread + np.diag(variances))
        # Rounding makes the two triangles differ; their mean stays symmetric.
        self._x = self._x + gain @ (measured - directions.T @ self._x)
        covariance = self._covariance - gain @ spread.T
        self._covariance = 0.5 * (covariance + covariance.T)


def _turned(vector: Vector3, angle_rad: float) -> Vector3:
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    x, y, z = vector
    return c * x - s * y, s * x + c * y, z
