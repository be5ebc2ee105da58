"""Outlines of objects that are not rectangles seen from above.

The attribute `outline` of an object holds a polygon as well-known text, such as `POLYGON ((-5 -4, 5
-4, 5 4, 0 4, 0 0, -5 0, -5 -4))`, with holes where the object has courtyards. Its coordinates are
metres in the frame of the object's box: x forwards, y to the left, the origin in the middle of the
box. The object is the prism over that polygon, as high as its box.

The text is an attribute, and not a field of the schema, so that programs which only know the
paper's boxes still read the file.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING

from aeroscene.files.bounds import MOST_POINTS
from aeroscene.scene.box import OrientedBox, Vector3
from aeroscene.scene.errors import SceneError, require

if TYPE_CHECKING:
    import shapely

OUTLINE = "outline"
"""Name of the attribute that holds the outline."""
_MOST_TEXT = 50 * MOST_POINTS
_SLACK_M = 0.01
"""Length by which rounded corners may lie outside the box."""
_VALID = f"the well-known text of one polygon inside the box, at most {MOST_POINTS} corners"


def outline_in_box(attributes: Mapping[str, object], size_m: Vector3) -> shapely.Polygon | None:
    """Outline of an object in the frame of its box, m; None for an object without one.

    Raises:
        SceneError: If the attribute is no valid polygon, or extends beyond the box.
    """
    text = attributes.get(OUTLINE)
    return None if text is None else _parsed(text, size_m)


# Reading, building and scoring ask for the same outline again and again, and parsing is slow.
@lru_cache(maxsize=4096)
def _parsed(text: object, size_m: Vector3) -> shapely.Polygon:
    polygon = _decoded(text)
    ok = polygon is not None and _is_sound(polygon, size_m)
    require(ok=ok, field_name=f"attributes.{OUTLINE}", value=text, valid=_VALID)
    assert polygon is not None
    return polygon


def _decoded(text: object) -> shapely.Polygon | None:
    # Start-up time: most scenes have no outlines.
    import numpy as np
    import shapely

    if not isinstance(text, str) or len(text) > _MOST_TEXT:
        return None
    try:
        with np.errstate(invalid="ignore"):
            shape = shapely.from_wkt(text)
    except (shapely.errors.GEOSException, UnicodeError, ValueError):
        return None
    return shape if isinstance(shape, shapely.Polygon) else None


def _is_sound(polygon: shapely.Polygon, size_m: Vector3) -> bool:
    import shapely

    if polygon.is_empty or shapely.get_num_coordinates(polygon) > MOST_POINTS:
        return False
    x0, y0, x1, y1 = polygon.bounds
    reach_x, reach_y = size_m[0] / 2 + _SLACK_M, size_m[1] / 2 + _SLACK_M
    # Comparisons with NaN are false, so that such corners are refused here.
    is_inside = -reach_x <= x0 <= x1 <= reach_x and -reach_y <= y0 <= y1 <= reach_y
    return is_inside and polygon.is_valid and polygon.area > 0


def require_outline(attributes: Mapping[str, object], box: OrientedBox) -> None:
    """Refuse an outline that is not a polygon within an upright box.

    Raises:
        SceneError: If the outline is invalid, or the box is tilted.
    """
    if OUTLINE in attributes:
        outline_in_box(attributes, box.s)
        if not box.is_upright:
            raise SceneError(
                f"bbox.q is {box.q}; valid: an upright box for an object with {OUTLINE}"
            )
