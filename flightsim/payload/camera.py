"""Camera of the gimbal: takes photographs and films, and keeps them on its card.

A client may ask for pictures in a run that keeps none. They are then counted and reported with time
and place, but nothing is rendered, since rendering is what costs time. A photograph bears the place
and the attitude that the vehicle takes itself for, as a real one does; the true ones stand in the
file beside it.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from enum import Enum, unique
from math import isfinite
from pathlib import Path

from flightsim.autopilot.autopilot import Autopilot
from flightsim.autopilot.results import ACCEPTED, CommandResult, Reply, denied, rejected
from flightsim.frames import LocalFrame
from flightsim.payload.card import Card, CardFullError
from flightsim.payload.lens import SIZES_PX, Lens
from flightsim.payload.photograph import Photograph, jpeg, sidecar
from flightsim.payload.shutter import Shutter
from flightsim.payload.video import FRAME_US, Film, has_encoder
from flightsim.plant import Plant

_LOG = logging.getLogger(__name__)
_MOST_REMEMBERED = 1000  # photographs that a client may still ask about
_FILM_RESERVE_BYTES = 1 << 20
"""Room on the card that a film leaves free, so that its last part and its index still fit."""


@unique
class CameraMode(Enum):
    """Mode that the camera is set to; it takes photographs and films in either mode."""

    PHOTO = "photo"
    VIDEO = "video"


class Camera:
    """Camera that takes photographs and films through the lens; `update` once every 20 ms.

    Attributes:
        mode: Mode that it is set to, which clients only read back.
        shutter: Times at which photographs are taken.
        card: Memory card for photographs and films.
        n_taken: Number of photographs taken in this run.
        listeners: Functions called with each photograph.
    """

    def __init__(
        self, plant: Plant, autopilot: Autopilot, frame: LocalFrame, lens: Lens, card: Card
    ) -> None:
        """Switch a camera on.

        Args:
            plant: Vehicle that carries it.
            autopilot: Autopilot, for the height above home.
            frame: Local frame of the scene.
            lens: Lens that renders the pictures.
            card: Card for the pictures; without a folder nothing is rendered for them.
        """
        self._plant = plant
        self._autopilot = autopilot
        self._frame = frame
        self._lens = lens
        self.card = card
        self.shutter = Shutter()
        self.mode = CameraMode.PHOTO
        self.n_taken = 0
        self.listeners: list[Callable[[Photograph], None]] = []
        self._photographs: deque[Photograph] = deque(maxlen=_MOST_REMEMBERED)
        self._film: Film | None = None
        self._filming_since_us: int | None = None

    def photograph(self, index: int) -> Photograph | None:
        """Return a photograph by its number.

        Args:
            index: Number in this run, from 0.

        Returns:
            The photograph; None if it was not taken, or a thousand were taken since.
        """
        return next((p for p in self._photographs if p.index == index), None)

    @property
    def can_film(self) -> bool:
        """True if a film can begin on this machine: without a folder it needs no encoder."""
        return self.card.folder is None or has_encoder()

    @property
    def filmed_us(self) -> int | None:
        """Time since the present film began, in simulated microseconds; None without a film."""
        began_us = self._filming_since_us
        return None if began_us is None else self._plant.time_us - began_us

    def start_film(self) -> Reply:
        """Begin to film.

        Returns:
            Acceptance; a rejection while a film runs or the card is full, a denial without an
            encoder, and a failure if the file cannot be written.
        """
        if self._filming_since_us is not None:
            return rejected("the camera is filming already")
        if not self.can_film:
            return denied("films need PyAV: pip install 'aeroscene[video]'")
        path = self.card.new_path("VID", ".mp4")
        if path is not None:
            # A film that ends at once for want of room would report a success first.
            if self.card.free_bytes <= _FILM_RESERVE_BYTES:
                return rejected(f"{self.card.folder} is full")
            try:
                self._film = Film(path, SIZES_PX["video"])
            except OSError as error:
                return Reply(CommandResult.FAILED, f"no film: {error}")
        self._filming_since_us = self._plant.time_us
        return ACCEPTED

    def stop_film(self) -> None:
        """End the film, if there is one; only then can its file be played."""
        self._filming_since_us = None
        # Forgotten first, so that a failure to close it is not met a second time.
        film, self._film = self._film, None
        if film is not None:
            try:
                self.card.used_bytes += film.close()
            except OSError as error:
                _LOG.warning("a film is lost: %s", error)

    def update(self) -> None:
        """Take the photograph and the frame of the film that are due at this tick."""
        now_us = self._plant.time_us
        if self.shutter.is_due(now_us, self._plant.estimate.position_enu_m):
            self._take(now_us)
        if self._film is not None and self._filming_since_us is not None:
            self._expose(self._film, now_us - self._filming_since_us)

    def close(self) -> None:
        """End the film, if there is one."""
        self.stop_film()

    def _expose(self, film: Film, since_us: int) -> None:
        """Add the frame that is due to the film, which ends if the card has no room for it."""
        if since_us % FRAME_US:
            return
        try:
            self.card.require(film.n_bytes + _FILM_RESERVE_BYTES)
            film.add(self._lens.render("video").rgb)
        except OSError as error:
            _LOG.warning("the film ends: %s", error)
            self.stop_film()

    def _take(self, now_us: int) -> None:
        aim = self._lens.aim_est()
        # An estimate that is not finite has no latitude.
        if not all(map(isfinite, (*aim.position_enu_m, *aim.quat_wxyz))):
            _LOG.warning("no picture: the vehicle does not know where it is")
            return
        place = self._frame.geodetic_from_enu(aim.position_enu_m)
        home = self._autopilot.home
        # Without a home yet, heights count from the scene's origin.
        home_m = self._frame.origin.altitude_m if home is None else home.geodetic.altitude_m
        photograph = Photograph(
            index=self.n_taken,
            time_us=now_us,
            place=place,
            height_m=place.altitude_m - home_m,
            aim=aim,
        )
        self.n_taken += 1
        path = self.card.new_path("IMG", ".jpg")
        if path is not None:
            photograph = self._keep(replace(photograph, name=path.name), path)
        self._photographs.append(photograph)
        for listener in self.listeners:
            listener(photograph)

    def _keep(self, photograph: Photograph, path: Path) -> Photograph:
        """Render and write a photograph with its JSON file.

        Returns:
            The photograph as it came out: without a name and not sound if it could not be written.
        """
        frame = self._lens.render("photo")
        try:
            self.card.write(path, jpeg(photograph, frame.rgb))
            pose = sidecar(photograph, frame, self._lens.aim_true())
            self.card.write(path.with_suffix(".json"), pose)
        except OSError as error:
            # Each further picture of the series would fail alike.
            if isinstance(error, CardFullError):
                self.shutter.stop()
                self.shutter.distance_m = 0.0
            _LOG.warning("picture %s is lost: %s", photograph.name, error)
            return replace(photograph, name="", is_sound=False)
        return photograph
