"""OpenGL contexts and offscreen buffers for the camera renderer, made at the time of use."""

from __future__ import annotations

import contextlib
import platform
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from flightsim.looks.drawing import FINE
from flightsim.sensors.camera import Quality, Viewpoint

_FINE_SAMPLES = 8
_FINE_SHADOW_SIZE = 8192
_MIN_SHADOW_RADIUS_M = 12.0
_MAX_SHADOW_RADIUS_M = 90.0


class GlUnavailableError(RuntimeError):
    """No OpenGL context can be made here."""


def new_gl_context(width: int, height: int) -> Any:
    """An offscreen OpenGL context; libraries load only now.

    Raises:
        GlUnavailableError: Saying what the loader or the driver said.
    """
    try:
        if platform.system() == "Darwin":
            from mujoco.cgl import GLContext  # noqa: PLC0415 - loads the GL library
        else:
            from mujoco.egl import GLContext  # noqa: PLC0415 - loads the GL library
        context = GLContext(width, height)
        context.make_current()
    except Exception as error:  # loaders and drivers raise what they like
        first_line = str(error).strip().split("\n")[0]
        raise GlUnavailableError(f"{type(error).__name__}: {first_line}") from error
    return context


class GlTarget:
    """An offscreen buffer of one size and quality, with the model uploaded to it."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int, quality: Quality) -> None:
        self._rect = mujoco.MjrRect(0, 0, width, height)
        self._shape = (height, width)
        with _context_settings(model, width, height, quality):
            self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        # The buffer as it is, 1 near and 0 far: the other mapping rounds distance away.
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR

    def read(self, scene: mujoco.MjvScene) -> tuple[np.ndarray, np.ndarray]:
        """Draw and read back: rgb (h, w, 3) and the depth buffer (h, w), 1 near to 0 far."""
        rgb = np.empty((*self._shape, 3), dtype=np.uint8)
        depth = np.empty(self._shape, dtype=np.float32)
        # Another target of the same GL context may have been drawn since.
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        mujoco.mjr_render(self._rect, scene, self._context)
        mujoco.mjr_readPixels(rgb, depth, self._rect, self._context)
        # OpenGL's first row is the bottom one.
        return np.ascontiguousarray(rgb[::-1]), np.ascontiguousarray(depth[::-1])

    def cast_shadows_around(
        self, scene: mujoco.MjvScene, focus_enu_m: np.ndarray, view: Viewpoint
    ) -> None:
        """Spend the sun's shadow map on what the view looks at, not on the whole scene."""
        distance_m = float(np.linalg.norm(focus_enu_m - view.position_enu_m))
        radius_m = min(max(1.5 * distance_m, _MIN_SHADOW_RADIUS_M), _MAX_SHADOW_RADIUS_M)
        self._context.shadowClip = radius_m
        for light in scene.lights[: scene.nlight]:
            if not light.headlight:
                light.pos[:] = focus_enu_m - 2 * radius_m * np.array(light.dir)

    def free(self) -> None:
        """Give its buffers back; its GL context must be current."""
        self._context.free()


@contextlib.contextmanager
def _context_settings(
    model: mujoco.MjModel, width: int, height: int, quality: Quality
) -> Iterator[None]:
    """MuJoCo takes a context's settings from the model; change them for its making only."""
    settings: list[tuple[Any, str, int]] = [
        # A buffer of just the image's size: clearing a larger one costs milliseconds in software.
        (model.vis.global_, "offwidth", width),
        (model.vis.global_, "offheight", height),
    ]
    if quality == "fine":
        detail = model.vis.quality
        settings += [
            (detail, "offsamples", _FINE_SAMPLES),
            (detail, "numslices", FINE.slices),
            (detail, "numstacks", FINE.stacks),
            (detail, "shadowsize", _FINE_SHADOW_SIZE),
        ]
    saved = [(owner, name, getattr(owner, name)) for owner, name, _ in settings]
    for owner, name, value in settings:
        setattr(owner, name, value)
    try:
        yield
    finally:
        for owner, name, value in saved:
            setattr(owner, name, value)
