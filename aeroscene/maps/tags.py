"""Numbers, sizes and colours in the notations of maps."""

from __future__ import annotations

import math
import re

from aeroscene.maps.document import Tags
from aeroscene.solids.shapes.materials import MATERIALS, WALL_COLOURS

_LENGTH = re.compile(
    r"\s*(?P<number>[0-9]{1,6}(?:[.,][0-9]{1,6})?)\s*(?P<unit>m|metres?|meters?|km|cm|ft|feet|')?\s*"
)
_FEET = re.compile(r"\s*([0-9]{1,4})\s*'\s*(?:([0-9]{1,2}(?:\.[0-9]+)?)\s*(?:\"|''))?\s*")
_UNITS_M = {"km": 1000.0, "cm": 0.01, "ft": 0.3048, "feet": 0.3048, "'": 0.3048}
_COMPASS = (
    "N",
    "NNE",
    "NE",
    "ENE",
    "E",
    "ESE",
    "SE",
    "SSE",
    "S",
    "SSW",
    "SW",
    "WSW",
    "W",
    "WNW",
    "NW",
    "NNW",
)
_HEX = re.compile(r"#([0-9a-fA-F]{6}|[0-9a-fA-F]{3})")
_NAMED_RGB = {
    "white": (1.0, 1.0, 1.0),
    "black": (0.1, 0.1, 0.1),
    "gray": (0.5, 0.5, 0.5),
    "grey": (0.5, 0.5, 0.5),
    "silver": (0.75, 0.75, 0.75),
    "red": (0.7, 0.2, 0.15),
    "maroon": (0.5, 0.1, 0.1),
    "brown": (0.5, 0.3, 0.2),
    "yellow": (0.9, 0.8, 0.4),
    "beige": (0.96, 0.94, 0.86),
    "orange": (0.9, 0.6, 0.3),
    "blue": (0.3, 0.4, 0.7),
    "green": (0.4, 0.6, 0.4),
    "pink": (0.9, 0.7, 0.7),
    "cream": (0.96, 0.93, 0.8),
}


def length_m(tags: Tags, key: str, low: float, high: float) -> float | None:
    """A length in metres; None if it is missing, unreadable or implausible.

    Args:
        tags: Tags of a feature.
        key: Key of the length.
        low: Least plausible value, m.
        high: Greatest plausible value, m.

    Returns:
        The length. Metres are assumed without a unit, as in OpenStreetMap; `5'7"` is read as feet
        and inches.
    """
    text = tags.get(key, "")
    if feet := _FEET.fullmatch(text):
        found = (float(feet[1]) + float(feet[2] or 0.0) / 12.0) * 0.3048
    elif match := _LENGTH.fullmatch(text):
        found = float(match["number"].replace(",", ".")) * _UNITS_M.get(match["unit"] or "m", 1.0)
    else:
        return None
    return found if low <= found <= high else None


def number(tags: Tags, key: str, low: float, high: float) -> float | None:
    """A plain number, such as a number of storeys; the first of a list such as `3;4`.

    None if it is missing, unreadable, or outside of `low` to `high`.
    """
    text = tags.get(key, "").split(";")[0].strip().replace(",", ".")
    try:
        found = float(text)
    except ValueError:
        return None
    return found if math.isfinite(found) and low <= found <= high else None


def heading_rad(tags: Tags, key: str = "direction") -> float | None:
    """Read a compass direction, or degrees clockwise from north.

    Args:
        tags: Tags of a feature.
        key: Key of the direction.

    Returns:
        Angle from east, rad, counter-clockwise; None if the direction is missing or unreadable.
    """
    text = tags.get(key, "").strip()
    if text in _COMPASS:
        degrees = 22.5 * _COMPASS.index(text)
    else:
        found = number(tags, key, 0.0, 360.0)
        if found is None:
            return None
        degrees = found
    return math.radians(90.0 - degrees)


def _rgb(text: str) -> tuple[float, float, float] | None:
    if text in _NAMED_RGB:
        return _NAMED_RGB[text]
    match = _HEX.fullmatch(text)
    if match is None:
        return None
    # Three digits are each written twice.
    digits = match[1] if len(match[1]) == 6 else "".join(2 * digit for digit in match[1])
    red, green, blue = (int(digits[i : i + 2], 16) / 255 for i in (0, 2, 4))
    return red, green, blue


def wall_colour(tags: Tags) -> str | None:
    """Find our nearest colour of walls for `building:colour` and `building:material`.

    Returns:
        Name of the colour, or "brick"; None if the map states no colour that can be read.
    """
    if tags.get("building:material") == "brick":
        return "brick"
    rgb = _rgb(tags.get("building:colour", tags.get("building:color", "")).lower())
    if rgb is None:
        return None
    materials = {name: MATERIALS[f"plaster_{name}"].rgba for name in WALL_COLOURS}
    materials["brick"] = MATERIALS["brick"].rgba
    return min(materials, key=lambda name: math.dist(materials[name][:3], rgb))


def tiles(tags: Tags) -> str | None:
    """Find our roof tiles for `roof:colour` and `roof:material`: red ones or slate.

    Returns:
        Name of the tiles; None if the map states neither.
    """
    material = tags.get("roof:material", "")
    if material in {"slate", "metal", "tar_paper", "concrete", "zinc", "copper"}:
        return "roof_slate"
    rgb = _rgb(tags.get("roof:colour", tags.get("roof:color", "")).lower())
    if rgb is not None:
        # Red if the red channel dominates clearly.
        return "roof_red" if rgb[0] > 1.25 * max(rgb[1], rgb[2]) else "roof_slate"
    return "roof_red" if material == "roof_tiles" else None
