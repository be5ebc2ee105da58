"""Camera renderers, and the choice between them for this machine.

Two renderers give the same frames: OpenGL if a GL library loads, otherwise ray casting by Embree.
On-board cameras do not see their own vehicle (their mounts are assumed to be clear of it, and its
depth would mean nothing to a planner); free views do.
"""

from __future__ import annotations

import logging
import math
from typing import Literal, Protocol

import mujoco
import numpy as np

from autonomy.types import Vector3
from flightsim.cameras.view import (
    CameraError,
    PosedDepth,
    Quality,
    RgbdFrame,
    Viewpoint,
)
from flightsim.world import World

_log = logging.getLogger(__name__)

Backend = Literal["auto", "gl", "raycast"]
MAX_EDGE_PIXELS = 4096


class CameraRenderer(Protocol):
    """Renders frames of one size of one world."""

    backend: Literal["gl", "raycast"]
    reason: str
    """Reason for this backend."""

    def render(self, data: mujoco.MjData, camera_name: str, time_us: int) -> RgbdFrame:
        """Return the frame of an on-board camera at the positions in `data`, which is not changed.

        Args:
            data: State of the physics.
            camera_name: Name of the camera.
            time_us: Time of the frame.
        """
        ...

    def render_from(self, data: mujoco.MjData, view: Viewpoint, time_us: int) -> RgbdFrame:
        """Return the frame of an on-board camera that is held at a viewpoint.

        Args:
            data: State of the world.
            view: Place, attitude and field of view.
            time_us: Time of the frame.
        """
        ...

    def render_depth(self, data: mujoco.MjData, camera_name: str, time_us: int) -> PosedDepth:
        """Return the depth of `render` to the bit, in less time.

        Args:
            data: State of the world.
            camera_name: Name of a camera of the vehicle.
            time_us: Time of the frame.
        """
        ...

    def render_ids(self, data: mujoco.MjData, camera_name: str) -> np.ndarray:
        """Return object ids (height, width) int32 of the pixels of `render`.

        Args:
            data: State of the world.
            camera_name: Name of a camera of the vehicle.
        """
        ...

    def render_ids_from(self, data: mujoco.MjData, view: Viewpoint) -> np.ndarray:
        """Return object ids (height, width) int32 of the pixels of `render_from`."""
        ...

    def render_view(
        self,
        data: mujoco.MjData,
        eye_enu_m: Vector3,
        target_enu_m: Vector3,
        vertical_fov_rad: float = math.radians(50.0),
        quality: Quality = "fast",
    ) -> RgbdFrame:
        """Return a picture from anywhere, including the vehicle.

        Args:
            data: State of the physics.
            eye_enu_m: Position of the eye.
            target_enu_m: Point in the centre of the picture.
            vertical_fov_rad: Vertical field of view.
            quality: "fine" adds shadows and smooth edges.
        """
        ...

    def close(self) -> None:
        """Release the renderer's resources; it cannot render afterwards."""
        ...


def open_camera_renderer(
    world: World, width: int, height: int, backend: Backend = "auto"
) -> CameraRenderer:
    """Open a renderer for a world's cameras.

    Args:
        world: World to render.
        width: Width of the image in pixels.
        height: Height of the image in pixels.
        backend: "auto" takes OpenGL and falls back to ray casting if no GL library loads.

    Raises:
        CameraError: If size or backend are invalid, or "gl" is requested and does not load.
    """
    for name, value in (("width", width), ("height", height)):
        if not 1 <= value <= MAX_EDGE_PIXELS:
            raise CameraError(f"{name} {value} is not valid; valid: 1 to {MAX_EDGE_PIXELS} pixels")
    if backend not in ("auto", "gl", "raycast"):
        raise CameraError(f"backend {backend!r} is unknown; valid: auto, gl, raycast")
    if backend == "raycast":
        return _open_raycast(world, width, height, "asked for")
    # Imported here: these modules must not load where no OpenGL is needed.
    from flightsim.cameras.gl import GlCameraRenderer
    from flightsim.cameras.gl_target import GlUnavailableError

    try:
        return GlCameraRenderer(world, width, height)
    except GlUnavailableError as error:
        if backend == "gl":
            raise CameraError(
                f"backend 'gl' does not load here: {error}; valid: raycast"
            ) from error
        _log.info("cameras use ray casting: %s", error)
        return _open_raycast(world, width, height, f"no OpenGL: {error}")


def _open_raycast(world: World, width: int, height: int, reason: str) -> CameraRenderer:
    from flightsim.cameras.raycast import RaycastCameraRenderer

    return RaycastCameraRenderer(world, width, height, reason)
