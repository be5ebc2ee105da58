"""The vehicle's RGB-D cameras, rendered when somebody asks, at the rate they ask."""

from __future__ import annotations

from collections.abc import Callable
from typing import Self

import numpy as np

from flightsim.plant import Plant
from flightsim.sensors.cameras.depth_noise import DepthNoise
from flightsim.sensors.cameras.renderer import open_camera_renderer
from flightsim.sensors.cameras.view import RgbdFrame


class Cameras:
    """Renders frames for whoever asks and shows each to every listener once.

    Attributes:
        backend: "gl" or "raycast", whichever this machine can do.
    """

    def __init__(
        self,
        plant: Plant,
        *,
        width_px: int = 320,
        height_px: int = 240,
        depth_noise: DepthNoise | None = None,
    ) -> None:
        """Open a renderer.

        Args:
            plant: Whose vehicle carries the cameras, in whose world.
            width_px: Width of the images.
            height_px: Height of the images.
            depth_noise: Errors of depth; None measures it exactly.

        Raises:
            CameraError: If there is no such size.
        """
        self._plant = plant
        self._depth_noise = depth_noise
        self._renderer = open_camera_renderer(plant.world, width_px, height_px)
        self.backend = self._renderer.backend
        self._listeners: list[Callable[[RgbdFrame], None]] = []
        self._latest: dict[str, RgbdFrame] = {}

    def listen(self, listener: Callable[[RgbdFrame], None]) -> None:
        """Show every frame from now on to `listener`."""
        self._listeners.append(listener)

    def render(self, camera: str) -> RgbdFrame:
        """What the named camera sees now; asked twice at one time, it is rendered once."""
        latest = self._latest.get(camera)
        if latest is not None and latest.time_us == self._plant.time_us:
            return latest
        frame = self._renderer.render(self._plant.data, camera, self._plant.time_us)
        if self._depth_noise is not None:
            frame = self._depth_noise.frame(frame)
        self._latest[camera] = frame
        for listener in self._listeners:
            listener(frame)
        return frame

    def render_ids(self, camera: str) -> np.ndarray:
        """What `render` shows at each pixel: int32 (height, width) of ids of the scene's objects.

        Negative are the vehicle (-1), the bare ground (-2), the sky (-3), movers (-10 and below).
        """
        return self._renderer.render_ids(self._plant.data, camera)

    def close(self) -> None:
        """Free the rendering context."""
        self._renderer.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
