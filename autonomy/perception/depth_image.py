"""Depth images as points and as lines of sight.

A pixel says two things: a surface is at its end, and nothing stands before that.
`DepthImage.points_enu_m` uses the first, `steepest_sight` and `bound_hidden` the second. The noise
of depth is estimated from each image, so that no camera needs to be configured.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from autonomy.jit import kernel
from autonomy.types import Vector3

# Pixels farther apart than the windows of stereo matching, whose errors are alike.
_APART = 6
_EVERY_ROW = 20
# Median of |x| of a normal variable is 0.6745 sigma; a half second difference has sigma sqrt(1.5).
_SIGMA_PER_MEDIAN = 1.0 / (0.6745 * math.sqrt(1.5))
_TINY_M = 0.02
"""Width of a pixel below which a lone pixel is a wrong match and no object."""
_ALIKE_SHARE = 0.05
_ALIKE_SIGMAS = 6.0
"""Difference of two inverse depths, over the larger and over the noise, within which they agree."""


class Pixels(NamedTuple):
    """Depth image in the form for kernels; see `DepthImage`."""

    depth: np.ndarray
    fx: float
    fy: float
    cx: float
    cy: float
    eye: np.ndarray
    """Position of the camera, ENU, m, (3,)."""
    rotation: np.ndarray
    """Optical axes to ENU, (3, 3)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DepthImage:
    """A depth image and the pose at which the vehicle believes it was taken.

    Pixel (column u, row v) looks along ((u - cx) / fx, (v - cy) / fy, 1), optical frame: x right, y
    down, z forward; whole numbers are pixel centres.
    """

    depth_m: Float[np.ndarray, "height width"]
    """Depth along the optical axis; inf, NaN or 0 if nothing was measured."""
    fx: float
    fy: float
    cx: float
    cy: float
    position_enu_m: Vector3
    rotation_enu_from_optical: Float[np.ndarray, "3 3"]

    @cached_property
    def inverse_depth_sigma_pm(self) -> float:
        """Standard deviation of the inverse depth of a pixel, 1/m, estimated from the image itself.

        Inverse depth, or disparity, is linear over the image of a plane, so its second differences
        are noise. The median ignores borders. The error of depth is the square of the depth times
        this.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1.0 / self.depth_m[::_EVERY_ROW]
        # The sky has no differences either, but it is no measurement.
        inverse[~((inverse > 0.0) & (inverse < np.inf))] = np.nan
        curve = inverse[:, _APART:-_APART] - 0.5 * (
            inverse[:, : -2 * _APART] + inverse[:, 2 * _APART :]
        )
        is_seen = np.isfinite(curve)
        if not is_seen.any():
            return 0.0
        return float(np.median(np.abs(curve[is_seen]))) * _SIGMA_PER_MEDIAN

    def posed(
        self, position_enu_m: Vector3, rotation_enu_from_optical: Float[np.ndarray, "3 3"]
    ) -> DepthImage:
        """The same image as if it was taken from another pose; its noise stays known."""
        moved = replace(
            self,
            position_enu_m=position_enu_m,
            rotation_enu_from_optical=rotation_enu_from_optical,
        )
        name = "inverse_depth_sigma_pm"
        if name in vars(self):
            vars(moved)[name] = self.inverse_depth_sigma_pm
        return moved

    def without_lone_pixels(self) -> DepthImage:
        """The image without near single pixels that disagree with all their neighbours.

        A stereo camera matches a few pixels with something else altogether. From far away a thin
        pole may show in a single pixel, so only near pixels, less than 2 cm wide, are dropped.
        """
        lone = lone_pixels(self.pixels, self.inverse_depth_sigma_pm)
        if not lone.any():
            return self
        return replace(self, depth_m=np.where(lone, np.float32(np.inf), self.depth_m))

    def halved(self) -> DepthImage:
        """Image of every second pixel of every second row, for uses that need no detail."""
        return replace(
            self,
            depth_m=self.depth_m[::2, ::2],
            fx=self.fx / 2,
            fy=self.fy / 2,
            cx=self.cx / 2,
            cy=self.cy / 2,
        )

    @cached_property
    def pixels(self) -> Pixels:
        """Image in the form for kernels: depth in single precision, all else in double."""
        return Pixels(
            np.ascontiguousarray(self.depth_m, dtype=np.float32),
            *(float(self.fx), float(self.fy), float(self.cx), float(self.cy)),
            np.array(self.position_enu_m, dtype=float),
            np.ascontiguousarray(self.rotation_enu_from_optical, dtype=float),
        )

    def corners_enu_m(self, depth_m: float) -> Float[np.ndarray, "4 3"]:
        """Points at a depth that the corners of the image show.

        They bound the view, so that a search can skip everything outside of it.
        """
        height, width = self.depth_m.shape
        u, v = np.array([0, 0, width, width]), np.array([0, height, 0, height])
        rays = np.stack([(u - self.cx) / self.fx, (v - self.cy) / self.fy, np.ones(4)], axis=1)
        return depth_m * rays @ self.rotation_enu_from_optical.T + self.position_enu_m

    def points_enu_m(self) -> Float[np.ndarray, "n 3"]:
        """Point that each pixel with a measurement shows, row by row."""
        return sample(self.pixels, 1, math.inf)[0]


@kernel
def sample(
    pixels: Pixels, stride: int, farthest: float
) -> tuple[Float[np.ndarray, "n 3"], Int[np.ndarray, "n 2"], Float[np.ndarray, " n"]]:
    """Point in ENU, row and column, and depth of every pixel with a measurement.

    Args:
        pixels: The image.
        stride: Step between the sampled rows and columns.
        farthest: Greatest depth, m.
    """
    depth, fx, fy, cx, cy, eye, rotation = pixels
    most = (depth.shape[0] // stride + 1) * (depth.shape[1] // stride + 1)
    points, places = np.empty((most, 3)), np.empty((most, 2), dtype=np.int64)
    depths = np.empty(most)
    n = 0
    for v in range(0, depth.shape[0], stride):
        y = (v - cy) / fy
        for u in range(0, depth.shape[1], stride):
            d = depth[v, u]
            if 0.0 < d <= farthest and d < np.inf:
                x = (u - cx) / fx
                for i in range(3):
                    ray = rotation[i, 0] * x + rotation[i, 1] * y + rotation[i, 2]
                    points[n, i] = eye[i] + d * ray
                places[n, 0], places[n, 1] = v, u
                depths[n] = d
                n += 1
    return points[:n], places[:n], depths[:n]


@kernel
def lone_pixels(pixels: Pixels, inverse_sigma: float) -> Bool[np.ndarray, "h w"]:
    """Mark pixels with near neighbours of which none has about the same depth."""
    depth, farthest = pixels.depth, _TINY_M * pixels.fx
    rows, columns = depth.shape
    lone = np.zeros(depth.shape, dtype=np.bool_)
    for v in range(rows):
        for u in range(columns):
            d = depth[v, u]
            if not 0.0 < d < np.inf:
                continue
            # The nearest neighbour decides on "near": a wrong match itself may claim any depth.
            nearest, is_lone = np.inf, True
            for row in range(max(v - 1, 0), min(v + 2, rows)):
                for column in range(max(u - 1, 0), min(u + 2, columns)):
                    other = depth[row, column]
                    if (row == v and column == u) or not 0.0 < other < np.inf:
                        continue
                    nearest = min(nearest, other)
                    away = abs(1.0 / d - 1.0 / other)
                    alike = _ALIKE_SHARE / min(d, other)
                    is_lone = is_lone and away > max(alike, _ALIKE_SIGMAS * inverse_sigma)
            lone[v, u] = is_lone and nearest < farthest
    return lone


@kernel
def steepest_sight(
    points: Float[np.ndarray, "k 3"],
    eye: Float[np.ndarray, " 3"],
    pixel_rad: float,
    step: float,
    n_bearings: int,
    n_steps: int,
    inverse_sigma: float,
) -> Float[np.ndarray, "b s"]:
    """The steepest line of sight that reaches beyond each horizontal distance, per bearing.

    Entry (b, s) is the largest fall per metre of the lines in bearing b that end `s * step` or
    farther from the eye; -inf if none does. Nothing stands above such a line before its end, which
    is moved nearer by two standard deviations of its depth.

    Args:
        points: Ends of the lines.
        eye: Beginning of the lines.
        pixel_rad: Width of a pixel; a line stands for all directions within it.
        step: Step between distances, m.
        n_bearings: Number of bearings all around.
        n_steps: Number of distances; the last one stands for all beyond.
        inverse_sigma: Standard deviation of inverse depth, 1/m.
    """
    fall = np.full((n_bearings, n_steps), -np.inf)
    for k in range(len(points)):
        x, y = points[k, 0] - eye[0], points[k, 1] - eye[1]
        away = math.sqrt(x * x + y * y)
        if away == 0.0:
            continue
        drop = eye[2] - points[k, 2]
        surely = max(1.0 - 2.0 * inverse_sigma * (away + abs(drop)), 0.0)
        s = min(int(surely * away / step), n_steps - 1)
        # Half a pixel along the diamond: d(turn) = d(angle) * (away / (|x| + |y|))^2.
        half = min(0.5 * pixel_rad * max(drop, 0.0) * away / (abs(x) + abs(y)) ** 2, 2.0)
        turn = bearing(x, y)
        first = math.floor((turn - half) * 0.25 * n_bearings)
        last = math.floor((turn + half) * 0.25 * n_bearings)
        steepness = drop / away
        for b in range(first, last + 1):
            # Half a turn beyond either end at most.
            around = b + n_bearings if b < 0 else b - n_bearings if b >= n_bearings else b
            fall[around, s] = max(fall[around, s], steepness)
    # From far to near: a line that reaches far also passes over everything nearer.
    for b in range(n_bearings):
        for s in range(n_steps - 2, -1, -1):
            fall[b, s] = max(fall[b, s], fall[b, s + 1])
    return fall


@kernel
def bound_hidden(
    fall: Float[np.ndarray, "b s"],
    eye: Float[np.ndarray, " 3"],
    step: float,
    east: Float[np.ndarray, " n"],
    north: Float[np.ndarray, " n"],
) -> Float[np.ndarray, "n n"]:
    """Upper bound of the height of anything in each cell that blocks no line of sight, m.

    Cells are as wide as `step`; the bound is the height of the line over their far side. It is
    infinite beyond the lines.
    """
    bound = np.full((len(north), len(east)), np.inf)
    n_bearings, n_steps = fall.shape
    for row in range(len(north)):
        for column in range(len(east)):
            x, y = east[column] - eye[0], north[row] - eye[1]
            away = math.sqrt(x * x + y * y) + 0.5 * step
            s = int(away / step) + 1
            if s < n_steps:
                b = int(bearing(x, y) * 0.25 * n_bearings) % n_bearings
                bound[row, column] = eye[2] - away * fall[b, s]
    return bound


@kernel
def bearing(x: float, y: float) -> float:
    """Direction as a position on the rim of a diamond, 0 to 4 from east by north; no atan2."""
    across = abs(x) + abs(y)
    turn = y / across if across > 0.0 else 0.0
    if x < 0.0:
        return 2.0 - turn
    return turn + 4.0 if y < 0.0 else turn
