"""OpenGL contexts and offscreen buffers for the camera renderer, created when needed."""

from __future__ import annotations

import contextlib
import platform
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np


class GlUnavailableError(RuntimeError):
    """No OpenGL context can be created here."""


def new_gl_context(width: int, height: int) -> Any:
    """Create an offscreen OpenGL context; libraries load only now.

    Importing them earlier would make `import flightsim` fail on machines without OpenGL.

    Args:
        width: Width in pixels.
        height: Height in pixels.

    Raises:
        GlUnavailableError: With the message of the loader or driver.
    """
    try:
        if platform.system() == "Darwin":
            from mujoco.cgl import GLContext
        else:
            from mujoco.egl import GLContext
        context = GLContext(width, height)
        context.make_current()
    except Exception as error:  # loaders and drivers raise anything
        first_line = str(error).strip().split("\n")[0]
        raise GlUnavailableError(f"{type(error).__name__}: {first_line}") from error
    return context


class GlTarget:
    """An offscreen buffer of one size, with the model uploaded to it."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        self._rect = mujoco.MjrRect(0, 0, width, height)
        self._shape = (height, width)
        with _buffer_size(model, width, height):
            self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        # Raw buffer, 1 near and 0 far: the other mapping loses precision far away.
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR

    def read(self, scene: mujoco.MjvScene) -> tuple[np.ndarray, np.ndarray]:
        """Draw and read back rgb (h, w, 3) and the depth buffer (h, w), 1 near to 0 far."""
        rgb = np.empty((*self._shape, 3), dtype=np.uint8)
        depth = self._drawn(scene, rgb)
        return np.ascontiguousarray(rgb[::-1]), depth

    def read_depth(self, scene: mujoco.MjvScene) -> np.ndarray:
        """Draw and read back the depth buffer of `read` alone."""
        return self._drawn(scene, None)

    def _drawn(self, scene: mujoco.MjvScene, rgb: np.ndarray | None) -> np.ndarray:
        depth = np.empty(self._shape, dtype=np.float32)
        # Another target of the same GL context may have been drawn since.
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        mujoco.mjr_render(self._rect, scene, self._context)
        mujoco.mjr_readPixels(rgb, depth, self._rect, self._context)
        # OpenGL's first row is the bottom one.
        return np.ascontiguousarray(depth[::-1])

    def free(self) -> None:
        """Release its buffers; its GL context must be current."""
        self._context.free()


@contextlib.contextmanager
def _buffer_size(model: mujoco.MjModel, width: int, height: int) -> Iterator[None]:
    """Make the model request a buffer of exactly the image's size while a context is created.

    Clearing a larger one costs milliseconds in software.
    """
    wanted: Any = model.vis.global_
    saved = (wanted.offwidth, wanted.offheight)
    wanted.offwidth, wanted.offheight = width, height
    try:
        yield
    finally:
        wanted.offwidth, wanted.offheight = saved
