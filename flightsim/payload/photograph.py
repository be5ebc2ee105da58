"""Photograph: the time, place and direction of a picture, and the files that keep them."""

from __future__ import annotations

import io
import json
import math
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np

from flightsim.cameras import RgbdFrame
from flightsim.environment.date import EPOCH_US
from flightsim.frames import Geodetic
from flightsim.payload.lens import FOCAL_LENGTH_MM, Aim

# Pillow's scale, which ends at 95.
_JPEG_QUALITY = 92


@dataclass(frozen=True, kw_only=True, slots=True)
class Photograph:
    """Picture that was taken; positions and attitudes are the vehicle's estimates."""

    index: int
    """Number in this run, from 0."""
    time_us: int
    place: Geodetic
    """Place of the camera."""
    height_m: float
    """Height of the camera above home."""
    aim: Aim
    name: str = ""
    """Name of its file; empty if it is not kept."""
    is_sound: bool = True
    """True if it was taken without a fault, and written if it was to be kept."""


def jpeg(photograph: Photograph, rgb: np.ndarray) -> bytes:
    """Return the JPEG of a picture, with time, place, direction and focal length as Exif.

    Args:
        photograph: Facts about the picture.
        rgb: Colours, uint8 (height, width, 3).
    """
    from PIL import ExifTags, Image

    tags, gps = ExifTags.Base, ExifTags.GPS
    at = _moment(photograph)
    place = photograph.place
    exif = Image.Exif()
    exif[tags.Make], exif[tags.Model] = "AeroScene", "Gimbal camera"
    exif[tags.DateTime] = at.strftime("%Y:%m:%d %H:%M:%S")
    exif.get_ifd(ExifTags.IFD.Exif).update(
        {tags.DateTimeOriginal: exif[tags.DateTime], tags.FocalLength: FOCAL_LENGTH_MM}
    )
    exif.get_ifd(ExifTags.IFD.GPSInfo).update(
        {
            gps.GPSLatitudeRef: "N" if place.latitude_deg >= 0.0 else "S",
            gps.GPSLatitude: _sexagesimal(place.latitude_deg),
            gps.GPSLongitudeRef: "E" if place.longitude_deg >= 0.0 else "W",
            gps.GPSLongitude: _sexagesimal(place.longitude_deg),
            # Exif has no signs: the altitude's reference says whether it lies below the sea.
            gps.GPSAltitudeRef: b"\0" if place.altitude_m >= 0.0 else b"\1",
            gps.GPSAltitude: abs(place.altitude_m),
            gps.GPSImgDirectionRef: "T",  # true north
            gps.GPSImgDirection: _heading_deg(photograph.aim),
            gps.GPSDateStamp: at.strftime("%Y:%m:%d"),
            gps.GPSTimeStamp: (float(at.hour), float(at.minute), at.second + at.microsecond * 1e-6),
        }
    )
    file = io.BytesIO()
    Image.fromarray(rgb).save(file, "JPEG", quality=_JPEG_QUALITY, exif=exif)
    return file.getvalue()


def sidecar(photograph: Photograph, frame: RgbdFrame, true: Aim) -> bytes:
    """Return the JSON beside a picture: its pose as estimated and as it was, and its lens.

    Args:
        photograph: Facts about the picture.
        frame: Rendered picture, for the focal lengths and the principal point in pixels.
        true: True place and attitude of the camera.
    """
    place = photograph.place
    plain: dict[str, Any] = {
        "file": photograph.name,
        "index": photograph.index,
        "time_s": photograph.time_us * 1e-6,
        "time_utc": _moment(photograph).isoformat(),
        "latitude_deg": round(place.latitude_deg, 7),
        "longitude_deg": round(place.longitude_deg, 7),
        "altitude_m": round(place.altitude_m, 3),
        "height_above_home_m": round(photograph.height_m, 3),
        "heading_deg": round(_heading_deg(photograph.aim), 3),
        "position_enu_m_est": _rounded(photograph.aim.position_enu_m),
        "quat_wxyz_est": _rounded(photograph.aim.quat_wxyz),
        "position_enu_m_true": _rounded(true.position_enu_m),
        "quat_wxyz_true": _rounded(true.quat_wxyz),
        **{name: getattr(frame, name) for name in ("fx", "fy", "cx", "cy")},
    }
    return (json.dumps(plain, indent=1) + "\n").encode()


def _moment(photograph: Photograph) -> datetime:
    return datetime(1970, 1, 1, tzinfo=UTC) + timedelta(microseconds=EPOCH_US + photograph.time_us)


def _heading_deg(aim: Aim) -> float:
    """Return the direction of the optical axis, clockwise from north.

    A camera that looks straight down has no such direction; the one of the top of its picture is
    taken, which is the limit of the others.
    """
    w, x, y, z = aim.quat_wxyz
    # Without roll, the left axis is level whatever the pitch.
    east, north = 2 * (x * y - w * z), 1 - 2 * (x * x + z * z)
    return math.degrees(math.atan2(north, -east)) % 360.0


def _sexagesimal(angle_deg: float) -> tuple[float, float, float]:
    minutes, seconds = divmod(abs(angle_deg) * 3600.0, 60.0)
    return (minutes // 60.0, minutes % 60.0, seconds)


def _rounded(values: tuple[float, ...]) -> list[float]:
    return [round(value, 6) for value in values]
