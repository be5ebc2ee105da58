"""Moving obstacle in one depth image: its edges, and its centre for a given size.

A camera sees the near side only, so the mean of the seen points is not the centre: it would wander
as the view changes. Seen from the eye, horizontally, an obstacle's near edge is known along the
line of sight, and its left and right edges across, unless the image's border or something nearer
cuts them off. The centre lies half the obstacle's size behind the near edge; frames from other
sides show that size.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from autonomy.jit import kernel
from autonomy.perception.depth_image import DepthImage
from autonomy.perception.foreground import Foreground

LEAST_HALF_M = 0.15
"""Least half extent of an obstacle: nothing that matters is thinner."""
_USUAL_HALF_M = 0.3
"""Greatest assumed half depth behind the near side, which is otherwise half the width."""
# Percentiles instead of extremes, because a few pixels at the border of a blob may be wrong.
_NEAR_PERCENT, _FAR_PERCENT = 10.0, 90.0
_EDGE_PERCENT = 2.0
# Share of a spread that lies between these percentiles, for points even over it.
_SPREAD_SHARE = 0.8
_NORMAL_SPREAD = 2.56  # width between them of a normal error, in standard deviations
_BESIDE_PX = 5
_SIDES = ((1, -1), (1, 1), (0, -1), (0, 1))
"""Left, right, up and down: axis of the pixel's place, and sign of the step."""
# Distance, and standard deviations of depth, by which a pixel beside a blob must lie behind it to
# show the background.
_BEHIND_M = 0.2
_BEHIND_SIGMAS = 4.0
# Standard deviations of a seen edge and of a centre whose edges are both unseen.
_SURFACE_SIGMA_M, _UNSEEN_SIGMA_M = 0.06, 0.5
# Shares of half the size: wander of the seen part of the near side, and of an unseen edge.
_UNSEEN_SHARE, _CUT_SHARE = 0.08, 0.15
_ROUNDNESS = 1.5  # 1 is a box, 2 an ellipse
_STEEP = 1.0  # tangent of the view's angle from which lower parts may be hidden
_MOST_HIDDEN_BELOW_M = 2.0


@dataclass(frozen=True, kw_only=True, slots=True)
class Footprint:
    """Half extents of an upright obstacle."""

    along_m: float
    across_m: float
    up_m: float
    yaw_rad: float
    """Heading of `along`, counter-clockwise from east."""

    def reach_m(self, x: float, y: float) -> float:
        """Reach towards a horizontal unit direction, between that of the box and of the ellipse.

        People are nearly ellipses, cars nearly boxes whose corners few points show.
        """
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        along = self.along_m * abs(c * x + s * y)
        across = self.across_m * abs(c * y - s * x)
        return (along**_ROUNDNESS + across**_ROUNDNESS) ** (1.0 / _ROUNDNESS)


@dataclass(frozen=True, kw_only=True, eq=False)
class Sighting:
    """Evidence of one image for one obstacle."""

    points_enu_m: Float[np.ndarray, "n 3"]
    forward: Float[np.ndarray, " 2"]
    """Horizontal unit direction of sight; left of it is 90 degrees counter-clockwise."""
    near_m: float
    """Distance of the near edge along `forward` from the origin."""
    right_m: float
    """Right edge. Like `left_m` it is measured to the left of `forward` from the origin."""
    left_m: float
    bottom_m: float
    top_m: float
    is_cut: tuple[bool, bool, bool, bool]
    """True for the sides on which the image ends before the obstacle does: left, right, top,
    bottom."""
    depth_sigma_m: float

    def spread_m(self, yaw_rad: float) -> tuple[float, float]:
        """Spread of the points along a heading and across it, without their noise, m."""
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        x, y = self.forward.tolist()
        noises = (
            _NORMAL_SPREAD * self.depth_sigma_m * abs(c * x + s * y),
            (_NORMAL_SPREAD * self.depth_sigma_m * abs(c * y - s * x)),
        )
        seen = spreads(self.points_enu_m, c, s, _NEAR_PERCENT, _FAR_PERCENT)
        along_m, across_m = (
            math.sqrt(max(spread**2 - noise**2, 0.0)) / _SPREAD_SHARE
            for spread, noise in zip(seen, noises, strict=True)
        )
        return along_m, across_m

    def footprint(self, yaw_rad: float) -> Footprint:
        """Least footprint that the sighting shows, turned to a heading."""
        along, across = self.spread_m(yaw_rad)
        unseen = max(min((self.left_m - self.right_m) / 2, _USUAL_HALF_M), LEAST_HALF_M)
        return Footprint(
            along_m=max(along / 2, unseen),
            across_m=max(across / 2, unseen),
            up_m=max((self.top_m - self.bottom_m) / 2, LEAST_HALF_M / 2),
            yaw_rad=yaw_rad,
        )

    def centre(self, size: Footprint) -> tuple[Float[np.ndarray, " 3"], Float[np.ndarray, "3 3"]]:
        """Centre, with its covariance, of an obstacle of some size that causes this sighting."""
        x, y = self.forward.tolist()
        reach, half = size.reach_m(x, y), size.reach_m(-y, x)
        is_left, is_right, is_top, is_bottom = self.is_cut
        aside, aside_sigma = _between(self.right_m, self.left_m, half, (is_right, is_left))
        up, up_sigma = _between(self.bottom_m, self.top_m, size.up_m, (is_bottom, is_top))
        ahead_sigma = _SURFACE_SIGMA_M + 0.5 * self.depth_sigma_m + _UNSEEN_SHARE * reach
        ahead = self.near_m + reach
        along, across = ahead_sigma**2, aside_sigma**2
        # Off-diagonal part of a diagonal covariance that is turned to the line of sight.
        mixed = x * y * (along - across)
        covariance = [
            [along * x * x + across * y * y, mixed, 0.0],
            [mixed, along * y * y + across * x * x, 0.0],
            [0.0, 0.0, up_sigma**2],
        ]
        return np.array([ahead * x - aside * y, ahead * y + aside * x, up]), np.array(covariance)


def _between(
    low: float, high: float, half: float, is_cut: tuple[bool, bool]
) -> tuple[float, float]:
    """Middle of two edges of which either may be unknown, and its standard deviation.

    If one edge is cut, the middle is half an extent off the seen edge even if more than that is in
    view. A track that learns a larger size then moves its centre and does not take a part that
    comes into view for motion.
    """
    is_low_cut, is_high_cut = is_cut
    if is_low_cut == is_high_cut:
        sigma = _UNSEEN_SIGMA_M if is_low_cut else _SURFACE_SIGMA_M
        return (low + high) / 2, sigma
    return high - half if is_low_cut else low + half, _SURFACE_SIGMA_M + _CUT_SHARE * half


def see(
    image: DepthImage, foreground: Foreground, blob: Int[np.ndarray, " k"], *, within_m: float
) -> Sighting:
    """Find the edges of a blob.

    Points nearer than `within_m` to the map are no foreground, so a blob that ends about so far
    above a surface is assumed to stand on it. The same holds up to 2 m above it if the lower parts
    are hidden, because the view is steep or the image ends.
    """
    points, pixels = foreground.points_enu_m[blob], foreground.pixels[blob]
    sight = np.median(points, axis=0) - image.pixels.eye
    away = max(math.hypot(sight[0], sight[1]), 1e-6)
    forward = sight[:2] / away
    depth_m = float(np.median(foreground.depth_m[blob]))
    depth_sigma_m = image.inverse_depth_sigma_pm * depth_m**2
    ahead = points[:, :2] @ forward
    aside = points[:, 1] * forward[0] - points[:, 0] * forward[1]
    right_m, left_m = between(aside, _EDGE_PERCENT, 100.0 - _EDGE_PERCENT)
    low_m, top_m = between(points[:, 2], _EDGE_PERCENT, 100.0 - _EDGE_PERCENT)
    half_px_m = foreground.stride_px * depth_m / image.fx / 2
    lowest = foreground.static_distance_m[blob][points[:, 2] <= low_m]
    below_m = float(np.median(lowest))
    behind_m = foreground.depth_m[blob] + _BEHIND_M
    nearer_m = foreground.depth_m[blob] - _BEHIND_M
    doubt_m = _BEHIND_SIGMAS * depth_sigma_m
    cut = (image.pixels.depth, pixels, behind_m + doubt_m)
    is_left, is_right, is_top = (goes_on(*cut, *side, _EDGE_PERCENT) for side in _SIDES[:3])
    is_bottom = goes_on(image.pixels.depth, pixels, nearer_m - doubt_m, *_SIDES[3], _EDGE_PERCENT)
    is_hidden = is_bottom or -sight[2] > _STEEP * away
    hidden_m = _MOST_HIDDEN_BELOW_M if is_hidden else 2.0 * within_m
    return Sighting(
        points_enu_m=points,
        forward=forward,
        # The near percentile of noisy points lies too near by this much.
        near_m=between(ahead, _NEAR_PERCENT, _FAR_PERCENT)[0] + _NORMAL_SPREAD / 2 * depth_sigma_m,
        right_m=right_m - half_px_m,
        left_m=left_m + half_px_m,
        bottom_m=low_m - (below_m if below_m < hidden_m else half_px_m),
        top_m=top_m + half_px_m,
        is_cut=(is_left, is_right, is_top, is_bottom and below_m >= hidden_m),
        depth_sigma_m=depth_sigma_m,
    )


@kernel
def between(
    values: Float[np.ndarray, " n"], low_percent: float, high_percent: float
) -> tuple[float, float]:
    """Two percentiles of some values, interpolated as by `np.percentile`, but much faster."""
    ordered = np.sort(values)
    return _percentile(ordered, low_percent), _percentile(ordered, high_percent)


@kernel
def _percentile(ordered: np.ndarray, percent: float) -> float:
    place = 0.01 * percent * (len(ordered) - 1)
    n = min(int(place), len(ordered) - 1)
    above = min(n + 1, len(ordered) - 1)
    return ordered[n] + (place - n) * (ordered[above] - ordered[n])


@kernel
def spreads(
    points: Float[np.ndarray, "n 3"], c: float, s: float, low_percent: float, high_percent: float
) -> tuple[float, float]:
    """Distances between two percentiles of points, along a horizontal direction and across it."""
    along = np.sort(c * points[:, 0] + s * points[:, 1])
    across = np.sort(c * points[:, 1] - s * points[:, 0])
    return (
        _percentile(along, high_percent) - _percentile(along, low_percent),
        _percentile(across, high_percent) - _percentile(across, low_percent),
    )


@kernel
def goes_on(
    depth: Float[np.ndarray, "h w"],
    pixels: Int[np.ndarray, "k 2"],
    behind: Float[np.ndarray, " k"],
    axis: int,
    sign: int,
    edge_percent: float,
) -> bool:
    """Return whether a blob may go on beyond its pixels to a side.

    It does not if most pixels beside its edge show something farther away than `behind`, or
    nothing.

    Args:
        depth: Depth image, m.
        pixels: Row and column of each sample of the blob.
        behind: Depth of what is behind each sample, m.
        axis: Column of `pixels` that changes towards the side.
        sign: 1 if it grows, -1 if it falls.
        edge_percent: Share of the samples that are its edge, or more if they are in line.
    """
    places = sign * pixels[:, axis]
    edge = _percentile(np.sort(places), 100.0 - edge_percent)
    n_edge, n_behind = 0, 0
    for n in range(len(pixels)):
        if places[n] < edge:
            continue
        n_edge += 1
        row, column = pixels[n, 0], pixels[n, 1]
        if axis == 0:
            row += sign * _BESIDE_PX
        else:
            column += sign * _BESIDE_PX
        if 0 <= row < depth.shape[0] and 0 <= column < depth.shape[1]:
            n_behind += not 0.0 < depth[row, column] < behind[n]
    return 2 * n_behind < n_edge
