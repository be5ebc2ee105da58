"""Payload of a vehicle: a gimbal with a camera on it, which costs nothing until it is used."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from autonomy.types import yaw_of
from flightsim.autopilot.autopilot import Autopilot
from flightsim.frames import LocalFrame
from flightsim.payload.camera import Camera
from flightsim.payload.card import Card
from flightsim.payload.gimbal import Gimbal
from flightsim.payload.lens import SIZES_PX, Lens
from flightsim.payload.video import VideoStream
from flightsim.plant import Plant

VIDEO_PORT = 5600
"""UDP port at which ground stations expect video; instances count up from it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PayloadCfg:
    """Destinations of the pictures."""

    captures: Path | None = None
    """Folder for photographs and films; None keeps none."""
    video_port: int | None = None
    """UDP port of this machine to stream to; None streams nothing."""


class Payload:
    """Everything that a vehicle carries for its pictures; `update` once every 20 ms.

    Attributes:
        gimbal: Gimbal that turns the camera.
        lens: Lens that renders the pictures.
        camera: Camera that takes photographs and films.
        video: Stream to a port; None if none was asked for.
    """

    def __init__(
        self, plant: Plant, autopilot: Autopilot, frame: LocalFrame, cfg: PayloadCfg | None = None
    ) -> None:
        """Attach a payload to a vehicle.

        Args:
            plant: Vehicle that carries it.
            autopilot: Its autopilot, for the height above home.
            frame: Local frame of the scene.
            cfg: Destinations of the pictures; by default they are counted and not kept.

        Raises:
            OSError: If the folder for pictures cannot be made.
            VideoError: If there is no encoder for the stream.
        """
        cfg = cfg or PayloadCfg()
        self._plant = plant
        self.gimbal = Gimbal()
        self.lens = Lens(plant, self.gimbal)
        self.camera = Camera(plant, autopilot, frame, self.lens, Card(cfg.captures))
        self.video: VideoStream | None = None
        if cfg.video_port is not None:
            self.video = VideoStream(
                cfg.video_port, SIZES_PX["video"], lambda: self.lens.render("video").rgb
            )

    def prepare(self) -> None:
        """Open the renderers that photographs and the stream will need, before the flight begins.

        A renderer takes as long to open as a hundred pictures to render, which would halt the
        flight at the first one.
        """
        if self.camera.card.folder is not None:
            self.lens.open("photo")
        if self.video is not None:
            self.lens.open("video")

    def now_us(self) -> int:
        """Return the present time in microseconds."""
        return self._plant.time_us

    def update(self) -> None:
        """Turn the gimbal, and take, film and stream the pictures that are due at this tick.

        An error is raised once: it ends the pictures that were to come.
        """
        plant = self._plant
        state = plant.estimate
        # Before the pictures, so that they show this tick's angles.
        self.gimbal.update(state.position_enu_m, yaw_of(state.quat_wxyz))
        try:
            self.camera.update()
            if self.video is not None:
                self.video.update(plant.time_us)
        except Exception:
            self._stop()  # Else it would fail again at every tick.
            raise

    def close(self) -> None:
        """End film and stream, and release everything."""
        self.camera.close()
        if self.video is not None:
            self.video.close()
        self.lens.close()

    def _stop(self) -> None:
        self.camera.shutter.stop()
        self.camera.shutter.distance_m = 0.0
        self.camera.stop_film()
        if self.video is not None:
            self.video.is_running = False
