"""RGB-D cameras of the vehicle, rendered on request."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Self

import numpy as np

from flightsim.cameras.depth_noise import DepthNoise
from flightsim.cameras.optics import CameraMotion, Optics
from flightsim.cameras.renderer import CameraRenderer, open_camera_renderer
from flightsim.cameras.segmentation import Classes
from flightsim.cameras.view import PosedDepth, RgbdFrame
from flightsim.plant import Plant

WIDTH_PX, HEIGHT_PX = 320, 240
"""Size of an image, unless another one is asked for."""


class Cameras:
    """Renders frames on request and passes each to every listener once.

    Attributes:
        backend: "gl" or "raycast", depending on the machine.
    """

    def __init__(
        self,
        plant: Plant,
        *,
        width_px: int = WIDTH_PX,
        height_px: int = HEIGHT_PX,
        depth_noise: DepthNoise | None = None,
        segments: bool = False,
        optics: Optics | None = None,
        renderer: CameraRenderer | None = None,
    ) -> None:
        """Open a renderer.

        Args:
            plant: Plant of the vehicle and the world to render.
            width_px: Width of the images.
            height_px: Height of the images.
            depth_noise: Errors of depth; None measures it exactly.
            segments: True gives frames the object and the class of each pixel, exactly; they are
                drawn in a second pass.
            optics: Lens and sensor of the colours; None leaves them as they are drawn.
            renderer: Renderer of the same world to use, which stays open and has its own size; None
                opens one.

        Raises:
            CameraError: If the size is invalid.
        """
        self._plant = plant
        self._depth_noise = depth_noise
        self._optics = optics
        self._classes = Classes(plant.world) if segments else None
        self._is_ours = renderer is None
        self._renderer = renderer or open_camera_renderer(plant.world, width_px, height_px)
        self.backend = self._renderer.backend
        self._listeners: list[Callable[[RgbdFrame], None]] = []
        self._latest: dict[str, RgbdFrame] = {}
        self._latest_depth: dict[str, PosedDepth] = {}

    def listen(self, listener: Callable[[RgbdFrame], None]) -> None:
        """Pass every frame from now on to `listener`."""
        self._listeners.append(listener)

    def render(self, camera: str) -> RgbdFrame:
        """Return the present frame of a camera; repeated requests at one time render it once.

        Args:
            camera: Name of the camera.

        Raises:
            CameraError: If the vehicle has no such camera.
        """
        latest = self._latest.get(camera)
        if latest is not None and latest.time_us == self._plant.time_us:
            return latest
        frame = self._renderer.render(self._plant.data, camera, self._plant.time_us)
        # From exact depth, by which the shutter moves pixels.
        if self._optics is not None:
            frame = self._optics.frame(frame, CameraMotion.of(frame, self._plant.truth))
        # Errors of depth are added once to each frame, so that all listeners get the same image.
        if self._depth_noise is not None:
            frame = self._depth_noise.frame(frame)
        if self._classes is not None:
            ids = self.render_ids(camera)
            frame = replace(frame, instance_ids=ids, class_ids=self._classes.of(ids))
        self._latest[camera] = frame
        for listener in self._listeners:
            listener(frame)
        return frame

    def render_depth(self, camera: str) -> PosedDepth:
        """Return the depth of `render` to the bit.

        Colours are drawn only if somebody listens to frames: without them an image takes less time.

        Args:
            camera: Name of the camera.
        """
        if self._listeners:
            return self.render(camera)
        latest = self._latest_depth.get(camera)
        if latest is not None and latest.time_us == self._plant.time_us:
            return latest
        frame = self._renderer.render_depth(self._plant.data, camera, self._plant.time_us)
        if self._depth_noise is not None:
            frame = self._depth_noise.frame(frame)
        self._latest_depth[camera] = frame
        return frame

    def render_ids(self, camera: str) -> np.ndarray:
        """Return the object that `render` shows at each pixel, int32 (height, width).

        Ids of the scene's objects count from 0. Negative are the vehicle (-1), the bare ground
        (-2), the sky (-3), the surroundings of the site (-4), movers (-10 and below), other
        vehicles (-100 and below).

        Args:
            camera: Name of the camera.
        """
        return self._renderer.render_ids(self._plant.data, camera)

    def close(self) -> None:
        """Release the rendering context, unless the renderer was passed in."""
        if self._is_ours:
            self._renderer.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
