"""Openings: they fit into their walls, and let a drone pass if the wall is large enough."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from aeroscene.feasibility.boxes import Boxes, strangers
from aeroscene.feasibility.layout import Layout
from aeroscene.feasibility.place_search import TOUCH_M
from aeroscene.feasibility.places import find_place
from aeroscene.scene import AttributeValue, OrientedBox
from aeroscene.scene.catalogue import WALLS

_JAMB_M = 0.15
"""Least width of wall beside an opening."""
_LEAST_DOOR_M = (1.65, 2.2)
"""Width and height through which a drone flies with some margin: an Iris takes 1.6 m."""
_CORPUS_DOOR_M = 1.5
"""Width of the doors of the corpus' partitions, which stay as they are."""
_LINTEL_M = 0.05
_SAME_M = 1e-4
"""Difference up to which lengths are equal in documents."""
_APRON_M = 1.3
"""Depth of the air that stays free on either side, as in curation."""
_LEAST_APRON_M = 0.3
"""The same in a room that is too small: a step, which real bedrooms leave before their bed."""
_SILL_M = 0.1
"""Height below which an object before a door is not in the way."""


def door_air(layout: Layout) -> Boxes:
    """Give the air before and behind each door of a wall, which furniture has to leave free."""
    return _boxes_of(list(_airs(layout).values()))


def yield_to_furniture(layout: Layout) -> None:
    """Give doors less air if a room has no place for the furniture in it.

    A bed in the doorway of a small bedroom stays: its door keeps the air down to the bed, but never
    less than a step.
    """
    air, n = _airs(layout), len(layout.boxes)
    # Obstacles have the rows behind those of the objects.
    walls, obstacles = list(air), _boxes_of(list(air.values()))
    pairs = layout.overlaps(TOUCH_M, obstacles).pairs
    found = [(row, walls[other - n]) for row, other in pairs.tolist() if row < n <= other]
    for row, wall in found:
        # Furniture that finds a place elsewhere moves there instead.
        if not layout.is_fine[row] or find_place(layout, row, int(layout.host[row]), obstacles):
            continue
        clear_m = max(_clear_m(layout, row, wall), _LEAST_APRON_M)
        layout.apron_m[wall] = min(layout.apron_m.get(wall, _APRON_M), clear_m)


def _airs(layout: Layout) -> dict[int, OrientedBox]:
    """The air about the door of each wall that has one, by row."""
    return {
        row: air
        for row in layout.rows(WALLS)
        if (
            air := air_of(
                layout.box(row),
                layout.attributes.get(row, layout.objects[row].attributes),
                layout.apron_m.get(row, _APRON_M),
            )
        )
    }


def _boxes_of(air: Sequence[OrientedBox]) -> Boxes:
    return strangers(
        np.array([box.p for box in air]).reshape(-1, 3),
        np.array([box.s for box in air]).reshape(-1, 3) / 2,
        np.array([box.yaw_rad for box in air]),
    )


def _clear_m(layout: Layout, row: int, wall: int) -> float:
    """Distance of an object from the middle of a wall, across the wall, m."""
    boxes = layout.boxes
    across = boxes.frame(wall)[0]
    offset_m = float(across @ (boxes.centre_m[row, :2] - boxes.centre_m[wall, :2]))
    reach_m = float(np.abs(boxes.frame(row) @ across) @ boxes.half_m[row, :2])
    return abs(offset_m) - reach_m


def air_of(
    wall: OrientedBox, openings: Mapping[str, AttributeValue], apron_m: float = _APRON_M
) -> OrientedBox | None:
    """Box of air before and behind the door of a wall.

    Args:
        wall: Box of the wall, which runs along its own y.
        openings: Attributes of the wall.
        apron_m: Depth of the air on either side.

    Returns:
        The box, or None for a wall without a door.
    """
    width = openings.get("door_m", 0.0)
    if not isinstance(width, int | float) or width <= 0:
        return None
    offset_m, yaw_rad = float(openings.get("door_offset_m", 0.0)), wall.yaw_rad
    x = wall.p[0] - math.sin(yaw_rad) * offset_m
    y = wall.p[1] + math.cos(yaw_rad) * offset_m
    # The air begins above thresholds and carpets.
    height_m = _LEAST_DOOR_M[1] - _SILL_M
    z = wall.p[2] - wall.s[2] / 2 + _SILL_M + height_m / 2
    # A tenth of a metre at both sides of the door.
    return OrientedBox((x, y, z), wall.q, (2 * apron_m, float(width) + 0.2, height_m))


def fit_openings(layout: Layout) -> None:
    """Clamp doors and windows to the walls in their present sizes.

    A wall that is too short for its opening loses it; a door that a model drew is widened for a
    drone.
    """
    for row in layout.rows(WALLS):
        own = layout.objects[row].attributes
        _, length, height = (2 * layout.boxes.half_m[row]).tolist()
        fitted = dict(own)
        for name in ("door", "window"):
            _fit(fitted, name, length, height)
        # What fits now may differ from what fitted at an earlier stage.
        layout.attributes.pop(row, None)
        if fitted != dict(own):
            layout.attributes[row] = fitted


def _fit(
    attributes: dict[str, AttributeValue], name: str, length_m: float, height_m: float
) -> None:
    width = attributes.get(f"{name}_m")
    if not isinstance(width, int | float) or width <= 0:
        return
    widest = length_m - 2 * _JAMB_M
    # Doors of a model are widened to a drone; those of the corpus are not.
    is_ours = name == "door" and abs(float(width) - _CORPUS_DOOR_M) > _SAME_M
    least = _LEAST_DOOR_M[0] if is_ours else 0.0
    fitted = min(max(float(width), least), widest)
    # A wall without room for an opening loses it.
    if fitted <= 0:
        for key in ("m", "offset_m", "height_m", "sill_m"):
            attributes.pop(f"{name}_{key}", None)
        return
    reach = (length_m - fitted) / 2 - _JAMB_M / 2
    offset = float(attributes.get(f"{name}_offset_m", 0.0))
    _set(attributes, f"{name}_m", fitted)
    _set(attributes, f"{name}_offset_m", min(max(offset, -reach), reach))
    _fit_head(attributes, name, height_m)


def _fit_head(attributes: dict[str, AttributeValue], name: str, height_m: float) -> None:
    head = attributes.get(f"{name}_height_m")
    if not isinstance(head, int | float):
        return
    least = _LEAST_DOOR_M[1] if name == "door" else 0.0
    fitted = min(max(float(head), least), height_m - _LINTEL_M)
    _set(attributes, f"{name}_height_m", fitted)


def _set(attributes: dict[str, AttributeValue], key: str, value: float) -> None:
    """Write a length if it has changed by more than documents can show."""
    old = attributes.get(key)
    if not isinstance(old, int | float) or abs(float(old) - value) > _SAME_M:
        attributes[key] = round(value, 4)
