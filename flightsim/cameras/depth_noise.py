"""Errors of a stereo depth camera: noise that grows with the square of range.

A stereo camera measures disparity, d = f b / z. Its error is about the same in pixels everywhere,
so depth errs by z^2 / (f b) times that: 6 cm at 4 m for a RealSense D435. Matching windows
correlate neighbouring errors, disparity is quantised, and borders of objects wander sideways.
Surfaces that only one imager sees, or that are seen at a grazing angle, have no depth. A few pixels
are matched with something else altogether.

Source: Grunnet-Jepsen, Sweetser and Woodfill, "Best-known methods for tuning Intel RealSense D400
depth cameras" (RMS error = z^2 subpixel / (f b), subpixel 0.08 px); lateral noise after Nguyen,
Izadi and Lovell 2012, eq. (1).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal, TypeVar

import numpy as np
from jaxtyping import Float

from autonomy.jit import kernel
from flightsim.cameras.view import PosedDepth
from flightsim.draws import generator

_Frame = TypeVar("_Frame", bound=PosedDepth)


class DepthNoiseError(ValueError):
    """The settings of a depth camera are invalid."""


@dataclass(frozen=True, kw_only=True, slots=True)
class DepthNoiseCfg:
    """A stereo pair, whose depth image is subsampled to the size of the frame."""

    baseline_m: float
    focal_px: float
    """Focal length of the imagers, not of the frame."""
    disparity_sigma_px: float = 0.08
    disparity_step_px: float = 1.0 / 32
    """Resolution of disparity: five fractional bits."""
    window_px: int = 3
    """Correlation length of the errors in frame pixels."""
    lateral_sigma_px: float = 0.5
    """Frame pixels by which borders wander; Nguyen: 0.8 for a camera of twice the resolution."""
    grazing_rad: float = math.radians(80.0)
    """Angle of incidence beyond which nothing is measured."""
    dropout_share: float = 0.002
    """Share of pixels without depth at random."""
    mismatch_share: float = 0.0005
    """Share of pixels with the depth of some other disparity."""
    min_range_m: float = 0.28
    max_range_m: float = 10.0

    def __post_init__(self) -> None:
        """Refuse settings that measure nothing.

        Raises:
            DepthNoiseError: Naming the setting, its value and the valid values.
        """
        for name in ("baseline_m", "focal_px", "disparity_step_px", "max_range_m"):
            if not getattr(self, name) > 0:
                raise DepthNoiseError(f"{name} {getattr(self, name)} is not valid; valid: above 0")
        if self.window_px < 1 or self.window_px % 2 == 0:
            raise DepthNoiseError(
                f"window_px {self.window_px} is not valid; valid: an odd number from 1"
            )

    def sigma_m(self, depth_m: float) -> float:
        """Return the standard deviation of depth at a given depth, without quantisation, m.

        Depth is focal length times baseline over disparity, so an error of the disparity counts by
        the square of the depth.

        Args:
            depth_m: True depth.
        """
        return depth_m**2 * self.disparity_sigma_px / (self.focal_px * self.baseline_m)


# Intel RealSense D400 data sheet: baseline 50 mm, 848 x 480 over about 90 degrees.
D435 = DepthNoiseCfg(baseline_m=0.050, focal_px=424.0)
# The same with a baseline of 95 mm; least range 0.52 m.
D455 = replace(D435, baseline_m=0.095, min_range_m=0.52)
DEPTH_CAMERAS: Mapping[str, DepthNoiseCfg] = MappingProxyType({"d435": D435, "d455": D455})


class DepthNoise:
    """Errors of the depth cameras in one run.

    Each frame has its own random stream, by camera and time, independent of other cameras. A camera
    more, or an image less, therefore changes no other image.
    """

    def __init__(self, cfg: DepthNoiseCfg, seed: int, scene_id: str) -> None:
        self._cfg = cfg
        self._seed = seed
        self._scene_id = scene_id

    def frame(self, frame: _Frame) -> _Frame:
        """Return the frame with depth as the camera measures it.

        Args:
            frame: Frame with exact depth; equal frames of a run get equal errors.
        """
        stream = generator(self._seed, self._scene_id, "depth", frame.camera, frame.time_us)
        measured = measured_depth(frame.depth_m, frame.fx, self._cfg, stream)
        return replace(frame, depth_m=measured)


def depth_noise(
    camera: Literal["exact", "d435", "d455"], seed: int, scene_id: str
) -> DepthNoise | None:
    """Return the errors of a depth camera by its name, None for the exact one.

    Args:
        camera: Name of the camera.
        seed: Seed of the run.
        scene_id: Name of the scene.

    Raises:
        DepthNoiseError: If there is no such camera.
    """
    if camera == "exact":
        return None
    if camera not in DEPTH_CAMERAS:
        valid = ", ".join(["exact", *DEPTH_CAMERAS])
        raise DepthNoiseError(f"depth camera {camera!r} is unknown; valid: {valid}")
    return DepthNoise(DEPTH_CAMERAS[camera], seed, scene_id)


def measured_depth(
    depth_m: Float[np.ndarray, "height width"],
    focal_px: float,
    cfg: DepthNoiseCfg,
    rng: np.random.Generator,
) -> Float[np.ndarray, "height width"]:
    """Return the depth that a camera measures, inf for pixels without a measurement.

    Args:
        depth_m: True depth along the optical axis, inf for the sky.
        focal_px: Focal length of the frame.
        cfg: Settings of the camera.
        rng: Random stream of its errors.
    """
    shape = depth_m.shape
    chance, other = rng.random((2, *shape), dtype=np.float32)
    aside = rng.standard_normal((2, *shape), dtype=np.float32) * np.float32(cfg.lateral_sigma_px)
    numbers = (
        cfg.baseline_m * cfg.focal_px,
        cfg.disparity_sigma_px,
        cfg.disparity_step_px,
        cfg.baseline_m * focal_px,
        # Depth changes by tan(angle) / f of itself from pixel to pixel on a surface at that angle.
        math.tan(cfg.grazing_rad) / focal_px,
        cfg.dropout_share,
        cfg.mismatch_share,
        cfg.min_range_m,
        cfg.max_range_m,
    )
    true = np.ascontiguousarray(depth_m, dtype=np.float32)
    errors = _alike(rng, shape, cfg.window_px)
    return measure(true, errors, aside, chance, other, np.array(numbers))


def _alike(
    rng: np.random.Generator, shape: tuple[int, ...], window: int
) -> Float[np.ndarray, "height width"]:
    """Normal numbers of unit variance, correlated over a square window."""
    import cv2

    height, width = shape
    margin = window // 2
    fine = rng.standard_normal((height + 2 * margin, width + 2 * margin), dtype=np.float32)
    sums = cv2.boxFilter(fine, -1, (window, window), normalize=False)
    # A sum over window^2 numbers has the deviation `window`.
    return np.ascontiguousarray(sums[margin : margin + height, margin : margin + width]) / window


@kernel
def measure(
    depth: Float[np.ndarray, "h w"],
    errors: Float[np.ndarray, "h w"],
    aside: Float[np.ndarray, "2 h w"],
    chance: Float[np.ndarray, "h w"],
    other: Float[np.ndarray, "h w"],
    numbers: Float[np.ndarray, " 9"],
) -> Float[np.ndarray, "h w"]:
    """Return depth from the disparity of each pixel with its error.

    Args:
        depth: True depth, m.
        errors: Errors of disparity, in standard deviations.
        aside: Rows and columns by which each pixel is displaced.
        chance: Uniform numbers; select dropouts and mismatches.
        other: Uniform numbers; depth of a mismatch.
        numbers: Focal length times baseline of the imagers (px m), sigma and step of disparity
            (px), focal length of the frame times baseline (px m), largest change of depth over
            depth and pixel, shares of dropouts and mismatches, least and largest range (m).
    """
    scale, sigma, step, frame_scale = numbers[0], numbers[1], numbers[2], numbers[3]
    steepest, dropout, mismatch = numbers[4], numbers[5], numbers[6]
    nearest, farthest = numbers[7], numbers[8]
    rows, columns = depth.shape
    measured = np.full((rows, columns), np.float32(np.inf))
    for v in range(rows):
        # From the right: a nearer surface is shifted farther to the left in the right imager. A
        # pixel is hidden there if a surface to its right here lies to its left there.
        shadow_end = np.inf
        for u in range(columns - 1, -1, -1):
            true = depth[v, u]
            column_right = u - frame_scale / true if true > 0.0 else np.inf
            is_shadowed = column_right > shadow_end + 0.5
            shadow_end = min(shadow_end, column_right)
            row = min(max(round(v + aside[0, v, u]), 0), rows - 1)
            column = min(max(round(u + aside[1, v, u]), 0), columns - 1)
            z = depth[row, column]
            if is_shadowed or not 0.0 < z < np.inf or chance[v, u] < dropout:
                continue
            if _steepness(depth, row, column) > steepest * z:
                continue
            disparity = scale / z + sigma * errors[v, u]
            if chance[v, u] > 1.0 - mismatch:
                disparity = scale / (nearest + other[v, u] * (farthest - nearest))
            disparity = step * round(disparity / step)
            if scale / farthest <= disparity <= scale / nearest:
                measured[v, u] = scale / disparity
    return measured


@kernel
def _steepness(depth: Float[np.ndarray, "h w"], row: int, column: int) -> float:
    """Smaller change of depth per pixel to either side, the larger of both directions.

    An edge is steep on one side only, and stays; a grazing surface is steep on both.
    """
    z = depth[row, column]
    steepness = 0.0
    for down, right in ((1, 0), (0, 1)):
        before = depth[max(row - down, 0), max(column - right, 0)]
        after = depth[min(row + down, depth.shape[0] - 1), min(column + right, depth.shape[1] - 1)]
        steepness = max(steepness, min(abs(after - z), abs(z - before)))
    return steepness
