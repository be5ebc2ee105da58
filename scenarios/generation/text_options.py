"""Options of `aeroscene generate` that are texts: outline of a site, landing areas, a region."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aeroscene.corpus.districts.request import SIDE_M as DISTRICT_SIDE_M
from aeroscene.files import read_bounded
from aeroscene.files.bounds import MOST_JSON_BYTES, excess
from aeroscene.learning.wishes import AREAS, OUTLINE_M, AreaCounts, RequestError
from aeroscene.ranges import Range
from aeroscene.scene import SceneError

if TYPE_CHECKING:
    from aeroscene.feasibility.region import Region

SIDE_M = Range(OUTLINE_M.low, DISTRICT_SIDE_M.high, OUTLINE_M.unit)
"""A side of a site that the model draws, or of a district."""
_CLASSES = ("small", "medium", "large")


class GenerateError(SceneError):
    """A request cannot be fulfilled; the message says in one line what would be valid."""


def asked_areas(text: str) -> int | AreaCounts:
    """Parse the numbers of landing areas that a user asks for.

    Args:
        text: A number for all, or counts of classes such as `small=20,large=2`.

    Returns:
        A number for all, or counts by class; a class that the text does not name is left open.

    Raises:
        SceneError: If the text is neither, or a number is out of its range.
    """
    # Signs are let through, so that -5 is refused as out of range and not as malformed.
    if text.strip().lstrip("+-").isdecimal():
        AREAS.require("areas", int(text), RequestError)
        return int(text)
    counts: dict[str, int] = {}
    for part in text.split(","):
        name, _, count = (side.strip() for side in part.partition("="))
        if name not in _CLASSES or name in counts or not count.isdecimal():
            raise GenerateError(
                f"areas is {text!r}; valid: a number, or counts of classes, each once, such as "
                "small=20,medium=5,large=2"
            )
        counts[name] = int(count)
    return AreaCounts(**counts)


def outline_sides_m(text: str) -> tuple[float, float]:
    """Parse the sides of the site that a user asks for.

    Args:
        text: `EAST,NORTH` in metres, or the path of a JSON file with corners.

    Returns:
        Extent to the east and to the north, m. Corners are replaced by their bounding rectangle.

    Raises:
        SceneError: If the text is neither, or a side is out of its range.
    """
    valid = "EAST,NORTH in metres such as 60,45, or a JSON file with [[x, y], ...]"
    parts = text.split(",")
    try:
        sides = [float(part) for part in parts]
    except ValueError:
        sides = _bounding_sides_m(Path(text), valid)
    if len(sides) != 2 or not all(math.isfinite(side) and side > 0 for side in sides):
        raise GenerateError(f"outline is {text!r}; valid: {valid}")
    for side in sides:
        SIDE_M.require("outline", side, RequestError)
    return sides[0], sides[1]


def asked_region(text: str) -> Region:
    """Parse the region of a scene that a user asks for.

    Args:
        text: `X0,Y0,X1,Y1` in metres, ENU, and optionally `Z0,Z1` behind that.

    Returns:
        The region; without heights it reaches from minus to plus infinity.

    Raises:
        SceneError: If the text is no region.
    """
    from aeroscene.feasibility.region import Region

    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in {4, 6}:
        raise GenerateError(
            f"region is {text!r}; valid: X0,Y0,X1,Y1 in metres such as -10,0,5,12.5, with Z0,Z1 "
            "behind that where it ends at a height"
        )
    x0, y0, x1, y1, z0, z1 = (*numbers, -math.inf, math.inf)[:6]
    return Region(low_enu_m=(x0, y0, z0), high_enu_m=(x1, y1, z1))


def _bounding_sides_m(path: Path, valid: str) -> list[float]:
    try:
        corners = _bounded_json(path)
        columns = list(zip(*((float(x), float(y)) for x, y in corners), strict=True))
    except OSError as error:
        reason = (error.strerror or type(error).__name__).lower()
        raise GenerateError(
            f"outline {str(path)!r} cannot be read ({reason}); valid: {valid}"
        ) from None
    except (ValueError, TypeError, RecursionError, OverflowError) as error:
        raise GenerateError(
            f"outline {str(path)!r} is no list of corners ({error}); valid: {valid}"
        ) from None
    return [max(column) - min(column) for column in columns]


def _bounded_json(path: Path) -> Any:
    # The file may be anybody's: its size and nesting are bounded before it is parsed.
    data = read_bounded(path, MOST_JSON_BYTES)
    if (fault := excess(data)) is not None:
        raise ValueError(f"it {fault}")
    return json.loads(data)
