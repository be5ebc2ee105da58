"""Exposure, gamma, blur, rolling shutter, distortion and noise of the colours of a camera.

A renderer draws all pixels of an image at one instant, through a pinhole, without noise. Everything
here is made from such an image and its exact depth. Only colours change: depth, labels and the pose
of a frame stay those of a pinhole at the instant in the middle of the exposure.

Motion blur and rolling shutter shift pixels by the image's velocity, which follows from depth and
from the motion of the camera (Longuet-Higgins and Prazdny 1980). The velocity counts as constant
within a frame, movers count as standing, and surfaces that were hidden at that instant are not
seen.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from jaxtyping import Float, UInt8

from aeroscene.ranges import Range
from autonomy.types import State
from flightsim.cameras.view import RgbdFrame
from flightsim.draws import generator

EXPOSURE_EV, GAMMA = Range(-6.0, 6.0, "EV"), Range(0.2, 5.0)
SHUTTER_MS, NOISE_LEVELS = Range(0.0, 50.0, "ms"), Range(0.0, 64.0, "levels of 255")
_MOST_K, _MOST_P = 1.0, 0.1
_MOST_BLUR_SAMPLES = 16
_SRGB_GAMMA = 2.2
"""Exponent between the levels of an image and light."""
_READ_SHARE = 0.1
"""Share of the noise's variance at mid-grey that does not depend on light."""


class OpticsError(ValueError):
    """The lens or the sensor of a camera is invalid."""


@dataclass(frozen=True, kw_only=True, slots=True)
class OpticsCfg:
    """Lens and sensor of a camera; by default colours stay as they are drawn."""

    exposure_ev: float = 0.0
    """Exposure: each unit doubles the light."""
    gamma: float = 1.0
    """Exponent whose inverse the levels get after the exposure; above 1 is brighter."""
    motion_blur_ms: float = 0.0
    """Time for which each pixel gathers light."""
    rolling_shutter_ms: float = 0.0
    """Time from the first row to the last."""
    distortion: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    """Coefficients k1, k2, p1, p2 of Brown and Conrady, as OpenCV has them."""
    noise_levels: float = 0.0
    """Standard deviation of mid-grey, in levels of 255."""

    @property
    def is_plain(self) -> bool:
        """True if colours stay as they are drawn."""
        return self == OpticsCfg()


def parse_distortion(text: str) -> tuple[float, float, float, float]:
    """Return k1, k2, p1 and p2 of a text such as "-0.2,0.05"; "none" and missing ones are zero.

    Raises:
        OpticsError: If it is something else.
    """
    parts = [] if text.strip().lower() == "none" else text.split(",")
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        numbers = [math.nan]
    bounds = (_MOST_K, _MOST_K, _MOST_P, _MOST_P)
    # "Not at most" instead of "above", so that NaN is refused too.
    if len(numbers) > 4 or not all(
        abs(number) <= most for number, most in zip(numbers, bounds, strict=False)
    ):
        raise OpticsError(
            f"camera-distortion {text!r} is not valid; valid: none, or K1[,K2[,P1[,P2]]] with "
            f"K1 and K2 of -{_MOST_K:g} to {_MOST_K:g}, P1 and P2 of -{_MOST_P:g} to {_MOST_P:g}"
        )
    k1, k2, p1, p2 = numbers + [0.0] * (4 - len(numbers))
    return k1, k2, p1, p2


@dataclass(frozen=True, kw_only=True, slots=True)
class CameraMotion:
    """Motion of a camera in its optical frame."""

    velocity_mps: Float[np.ndarray, " 3"]
    angular_rate_radps: Float[np.ndarray, " 3"]

    @classmethod
    def of(cls, frame: RgbdFrame, body: State) -> CameraMotion:
        """Return the motion of the camera of a frame, which is fixed to a body."""
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, np.array(body.quat_wxyz))
        rotation_enu_from_flu = rotation.reshape(3, 3)
        rate_enu = rotation_enu_from_flu @ np.array(body.angular_rate_flu_radps)
        arm_enu_m = np.array(frame.position_enu_m) - np.array(body.position_enu_m)
        velocity_enu = np.array(body.velocity_enu_mps) + np.cross(rate_enu, arm_enu_m)
        turn = frame.rotation_enu_from_optical.T
        return cls(velocity_mps=turn @ velocity_enu, angular_rate_radps=turn @ rate_enu)


class Optics:
    """Lens and sensor of the cameras of one run.

    Each frame has its own random stream, by camera and time, so that a camera more changes no other
    image.
    """

    def __init__(self, cfg: OpticsCfg, seed: int, scene_id: str) -> None:
        self._cfg, self._seed, self._scene_id = cfg, seed, scene_id

    def frame(self, frame: RgbdFrame, motion: CameraMotion) -> RgbdFrame:
        """Return the frame with colours as the camera takes them.

        Args:
            frame: Frame with exact depth.
            motion: Motion of its camera.
        """
        cfg = self._cfg
        rgb = warped(frame, motion, cfg)
        if cfg.exposure_ev or cfg.gamma != 1.0:
            rgb = _levels(cfg.exposure_ev, cfg.gamma)[rgb]
        if cfg.noise_levels:
            rng = generator(self._seed, self._scene_id, "optics", frame.camera, frame.time_us)
            rgb = noisy(rgb, cfg.noise_levels, rng)
        return replace(frame, rgb=rgb)


def warped(frame: RgbdFrame, motion: CameraMotion, cfg: OpticsCfg) -> UInt8[np.ndarray, "h w 3"]:
    """Return the colours of a frame through the lens, and by the shutter.

    Args:
        frame: Frame with exact depth.
        motion: Motion of its camera.
        cfg: Lens and shutter.
    """
    has_lens, is_timed = any(cfg.distortion), cfg.motion_blur_ms or cfg.rolling_shutter_ms
    if not has_lens and not is_timed:
        return frame.rgb
    # Only cameras with a lens or a shutter need it.
    import cv2

    height, width = frame.depth_m.shape
    pinhole = (height, width, frame.fx, frame.fy, frame.cx, frame.cy)
    x, y = _lens_rays(pinhole, cfg.distortion)
    u = x * np.float32(frame.fx) + np.float32(frame.cx)
    v = y * np.float32(frame.fy) + np.float32(frame.cy)
    if not is_timed:
        return cv2.remap(frame.rgb, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    nearness = (1.0 / np.maximum(frame.depth_m, 1e-3)).astype(np.float32)
    if has_lens:
        nearness = cv2.remap(nearness, u, v, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)
    du, dv = image_velocity(x, y, nearness, motion)
    du, dv = du * np.float32(frame.fx), dv * np.float32(frame.fy)
    rows_s = 1e-3 * cfg.rolling_shutter_ms * (np.arange(height) / max(height - 1, 1) - 0.5)
    late_s = rows_s[:, None].astype(np.float32)
    blur_s = 1e-3 * cfg.motion_blur_ms
    farthest_px = blur_s * float(np.quantile(np.hypot(du, dv), 0.95))
    n = min(_MOST_BLUR_SAMPLES, 1 + math.ceil(farthest_px))
    total = np.zeros(frame.rgb.shape, dtype=np.float32)
    for at_s in blur_s * ((np.arange(n) + 0.5) / n - 0.5):
        s = late_s + np.float32(at_s)
        # A point that is here at the time s is at the middle of the exposure where it came from.
        total += cv2.remap(
            frame.rgb, u - s * du, v - s * dv, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
    return (total / n + 0.5).astype(np.uint8)


def image_velocity(
    x: Float[np.ndarray, "*p"],
    y: Float[np.ndarray, "*p"],
    nearness: Float[np.ndarray, "*p"],
    motion: CameraMotion,
) -> tuple[Float[np.ndarray, "*p"], Float[np.ndarray, "*p"]]:
    """Return the velocity of standing points in the image, in focal lengths a second.

    Args:
        x: Place of each point, to the right of the axis, in focal lengths.
        y: Place below the axis.
        nearness: Inverse of depth, 1/m; 0 for the sky.
        motion: Motion of the camera.
    """
    vx, vy, vz = motion.velocity_mps.astype(np.float32)
    wx, wy, wz = motion.angular_rate_radps.astype(np.float32)
    du = (x * vz - vx) * nearness + x * y * wx - (1 + x * x) * wy + y * wz
    dv = (y * vz - vy) * nearness + (1 + y * y) * wx - x * y * wy - x * wz
    return du, dv


def noisy(
    rgb: UInt8[np.ndarray, "h w 3"], noise_levels: float, rng: np.random.Generator
) -> UInt8[np.ndarray, "h w 3"]:
    """Return colours with the noise of a sensor: of reading, and of counting photons.

    Args:
        rgb: Colours.
        noise_levels: Standard deviation of mid-grey, in levels.
        rng: Random stream of the image.
    """
    light = rgb.astype(np.float32)
    # The number of photons varies by its root.
    sigma = noise_levels * np.sqrt(_READ_SHARE + (1.0 - _READ_SHARE) * light / 127.5)
    light += sigma * rng.standard_normal(rgb.shape, dtype=np.float32)
    return np.clip(light + 0.5, 0.0, 255.0).astype(np.uint8)


@functools.lru_cache(maxsize=8)
def _levels(exposure_ev: float, gamma: float) -> UInt8[np.ndarray, " 256"]:
    """Level that each level of an image becomes."""
    light = (np.arange(256) / 255.0) ** _SRGB_GAMMA * 2.0**exposure_ev
    return (255.0 * np.minimum(light, 1.0) ** (1.0 / _SRGB_GAMMA / gamma) + 0.5).astype(np.uint8)


@functools.lru_cache(maxsize=4)
def _lens_rays(
    pinhole: tuple[int, int, float, float, float, float],
    distortion: tuple[float, float, float, float],
) -> tuple[Float[np.ndarray, "h w"], Float[np.ndarray, "h w"]]:
    """Ray of each pixel behind the lens, in focal lengths of the drawn image.

    A lens that bends inwards would see beyond the drawn image. Its focal length then grows until
    the image has no empty border.
    """
    height, width, fx, fy, cx, cy = pinhole
    x, y = np.meshgrid((np.arange(width) - cx) / fx, (np.arange(height) - cy) / fy)
    if any(distortion):
        most_x, most_y = np.abs(x).max(), np.abs(y).max()
        bent_x, bent_y = x, y
        for share in np.linspace(1.0, 0.3, 71):
            bent_x, bent_y = undistorted(share * x, share * y, distortion)
            if np.abs(bent_x).max() <= most_x + 1e-9 and np.abs(bent_y).max() <= most_y + 1e-9:
                break
        x, y = bent_x, bent_y
    return x.astype(np.float32), y.astype(np.float32)


def undistorted(
    x: Float[np.ndarray, "*p"],
    y: Float[np.ndarray, "*p"],
    distortion: tuple[float, float, float, float],
) -> tuple[Float[np.ndarray, "*p"], Float[np.ndarray, "*p"]]:
    """Return where a pinhole sees what a lens shows at some places, by fixed-point iteration."""
    k1, k2, p1, p2 = distortion
    at_x, at_y = x, y
    for _ in range(20):
        squared = at_x * at_x + at_y * at_y
        radial = 1.0 + squared * (k1 + squared * k2)
        aside_x = 2 * p1 * at_x * at_y + p2 * (squared + 2 * at_x * at_x)
        aside_y = p1 * (squared + 2 * at_y * at_y) + 2 * p2 * at_x * at_y
        radial = np.maximum(radial, 0.1)
        at_x, at_y = (x - aside_x) / radial, (y - aside_y) / radial
    return at_x, at_y
