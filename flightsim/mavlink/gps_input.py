"""GPS_INPUT: fixes of a client's receiver, true or forged, instead of the vehicle's own.

Tests of spoofing and of receivers in the loop send them. As long as fixes come, they replace the
simulated receiver; when they end, it returns if the vehicle has one to return to.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from autonomy.types import Vector3
from flightsim.autopilot.events import Severity
from flightsim.frames import Geodetic, swap_enu_ned
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler
from flightsim.mavlink.statustext import StatustextSender
from flightsim.mavlink.view import VehicleView
from flightsim.plant.external_aids import Fix, FixSource

_SILENCE_US = 2_000_000  # silence after which the client's fixes count as lost
_FARTHEST_M, _FASTEST_MPS = 1e5, 200.0
_LEAST_SIGMA = 0.01  # a better accuracy would make the filter follow each fix
_USUAL_SIGMA_M, _USUAL_SIGMA_MPS = (1.5, 2.5), 0.3
"""Accuracy of a fix that names none: horizontal, vertical and of the velocity."""
_NO_HEIGHT = mav.GPS_INPUT_IGNORE_FLAG_ALT
_NO_VELOCITY = mav.GPS_INPUT_IGNORE_FLAG_VEL_HORIZ | mav.GPS_INPUT_IGNORE_FLAG_VEL_VERT
_NO_LEVEL_SIGMA = mav.GPS_INPUT_IGNORE_FLAG_HORIZONTAL_ACCURACY
_NO_HEIGHT_SIGMA = mav.GPS_INPUT_IGNORE_FLAG_VERTICAL_ACCURACY
_NO_SPEED_SIGMA = mav.GPS_INPUT_IGNORE_FLAG_SPEED_ACCURACY
_UNKNOWN_SATELLITES = 255


class GpsInputService:
    """Passes fixes on to the vehicle's estimator.

    A fix that is incomplete or out of range is dropped whole, with a text that says why. Once fixes
    stop, the vehicle's own receiver comes back.
    """

    def __init__(self, view: VehicleView, statustext: StatustextSender, hint: str) -> None:
        """Serve a vehicle.

        Args:
            view: The vehicle.
            statustext: Texts for people.
            hint: How to let fixes be used, for a flight stack that does not by itself.
        """
        self._view = view
        self._statustext = statustext
        self._hint = hint
        self._heard_us = 0
        self._said: set[str] = set()
        self.handlers: Mapping[str, Handler] = {"GPS_INPUT": self._on_fix}

    def update(self) -> None:
        """Notice that no fixes come any more, and restore the vehicle's receiver."""
        aids = self._view.plant.external_aids
        if not self._said or self._view.time_us - self._heard_us <= _SILENCE_US:
            return
        self._said.clear()
        if not aids.is_fed_fixes:
            return
        # The texts above are forgotten: a stream that comes back is announced again.
        aids.lose_fix()
        if aids.fix_source is FixSource.EITHER:
            aids.end_fixes()
            self._statustext.broadcast(
                Severity.WARNING, "GPS_INPUT lost: the vehicle's receiver is back"
            )
        else:
            self._statustext.broadcast(Severity.WARNING, "GPS_INPUT lost: there is no GPS fix")

    def _on_fix(self, _: Channel, m: Message) -> None:
        self._heard_us = self._view.time_us
        aids = self._view.plant.external_aids
        if aids.fix_source not in {FixSource.EITHER, FixSource.CLIENT}:
            self._say_once(f"GPS_INPUT is not used: {self._hint}")
            return
        fix = self._fix(m)
        if isinstance(fix, str):
            self._say_once(f"GPS_INPUT refused: {fix}")
            return
        self._say_once("GPS_INPUT takes the place of the vehicle's GPS receiver")
        aids.feed_fix(fix)

    def _say_once(self, text: str) -> None:
        """Queue a text once for a stream of fixes."""
        if text not in self._said:
            self._said.add(text)
            self._statustext.broadcast(Severity.WARNING, text)

    def _fix(self, m: Message) -> Fix | str:
        """Return the fix of a message, or the description of its fault."""
        if m.gps_id != 0:
            return f"gps_id = {m.gps_id}; valid is 0, there is one receiver"
        latitude_deg, longitude_deg = 1e-7 * m.lat, 1e-7 * m.lon
        if not (abs(latitude_deg) <= 90.0 and abs(longitude_deg) <= 180.0):
            return f"latitude {latitude_deg:g}, longitude {longitude_deg:g} is off the globe"
        has_height = not m.ignore_flags & _NO_HEIGHT
        # A fix without a height keeps the present one, with an infinite deviation in
        # `_with_accuracy`.
        altitude_m = m.alt if has_height else self._view.place.altitude_m
        place = Geodetic(latitude_deg, longitude_deg, altitude_m)
        position_enu_m = self._view.frame.enu_from_geodetic(place)
        if not all(abs(c) <= _FARTHEST_M for c in position_enu_m):
            return f"it lies farther than {_FARTHEST_M / 1e3:g} km from the scene"
        velocity = None if m.ignore_flags & _NO_VELOCITY else swap_enu_ned((m.vn, m.ve, m.vd))
        if velocity is not None and not all(abs(c) <= _FASTEST_MPS for c in velocity):
            return f"velocity of {m.vn:g}, {m.ve:g}, {m.vd:g} m/s; valid are up to {_FASTEST_MPS:g}"
        return self._with_accuracy(m, position_enu_m, velocity, has_height=has_height)

    def _with_accuracy(
        self, m: Message, position_enu_m: Vector3, velocity: Vector3 | None, *, has_height: bool
    ) -> Fix:
        flags = m.ignore_flags
        level_m, height_m = _USUAL_SIGMA_M
        level_m = _sigma(m.horiz_accuracy, level_m, is_ignored=flags & _NO_LEVEL_SIGMA)
        height_m = _sigma(m.vert_accuracy, height_m, is_ignored=flags & _NO_HEIGHT_SIGMA)
        speed_mps = _sigma(m.speed_accuracy, _USUAL_SIGMA_MPS, is_ignored=flags & _NO_SPEED_SIGMA)
        n_satellites = m.satellites_visible
        return Fix(
            position_enu_m=position_enu_m,
            velocity_enu_mps=velocity,
            fix_type=m.fix_type,
            sigma_m=(level_m, height_m if has_height else math.inf),
            sigma_mps=speed_mps,
            n_satellites=0 if n_satellites == _UNKNOWN_SATELLITES else n_satellites,
            age_s=self._view.age_s(m.time_usec),
        )


def _sigma(value: float, usual: float, *, is_ignored: int) -> float:
    """Return the standard deviation that a message names, or the usual one."""
    is_given = not is_ignored and math.isfinite(value) and value > 0.0
    return max(value, _LEAST_SIGMA) if is_given else usual
