"""OpenGL contexts and offscreen buffers for the camera renderer, made at the time of use."""

from __future__ import annotations

import contextlib
import platform
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np


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
    """An offscreen buffer of one size, with the model uploaded to it."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        self._rect = mujoco.MjrRect(0, 0, width, height)
        self._shape = (height, width)
        with _buffer_size(model, width, height):
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

    def free(self) -> None:
        """Give its buffers back; its GL context must be current."""
        self._context.free()


@contextlib.contextmanager
def _buffer_size(model: mujoco.MjModel, width: int, height: int) -> Iterator[None]:
    """Have the model ask for a buffer of just the image's size while a context is made.

    Clearing a larger one costs milliseconds in software.
    """
    wanted: Any = model.vis.global_
    saved = (wanted.offwidth, wanted.offheight)
    wanted.offwidth, wanted.offheight = width, height
    try:
        yield
    finally:
        wanted.offwidth, wanted.offheight = saved
