"""Openings of walls fit into their walls, and let a drone through where a wall is large enough."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from aeroscene.feasibility.boxes import Boxes, strangers
from aeroscene.feasibility.layout import Layout
from aeroscene.scene import AttributeValue, OrientedBox

_JAMB_M = 0.15
"""Least wall beside an opening."""
_LEAST_DOOR_M = (1.65, 2.2)
"""Width and height that a drone flies through with some room to spare: an Iris takes 1.6 m."""
_CORPUS_DOOR_M = 1.5
"""Width of the doors of the corpus' partitions, which stay as they are."""
_LINTEL_M = 0.05
_SAME_M = 1e-4
"""Lengths that documents do not tell apart."""
_APRON_M = 1.3
"""Depth of the air that stays free on either side, as curation keeps it."""
_SILL_M = 0.1
"""Height below which an object before a door is not in the way."""


def door_air(layout: Layout) -> Boxes:
    """The air before and behind each door of a wall, which furniture leaves free."""
    found = [
        air
        for row, obj in enumerate(layout.objects)
        if obj.category == "wall"
        and layout.is_left[row]
        and (air := air_of(layout.box(row), layout.attributes.get(row, obj.attributes)))
    ]
    return strangers(
        np.array([air.p for air in found]).reshape(-1, 3),
        np.array([air.s for air in found]).reshape(-1, 3) / 2,
        np.array([air.yaw_rad for air in found]),
    )


def air_of(wall: OrientedBox, openings: Mapping[str, AttributeValue]) -> OrientedBox | None:
    """The air before and behind the door of a wall; None where it has none."""
    width = openings.get("door_m", 0.0)
    if not isinstance(width, int | float) or width <= 0:
        return None
    offset_m, yaw_rad = float(openings.get("door_offset_m", 0.0)), wall.yaw_rad
    x = wall.p[0] - math.sin(yaw_rad) * offset_m
    y = wall.p[1] + math.cos(yaw_rad) * offset_m
    height_m = _LEAST_DOOR_M[1] - _SILL_M
    z = wall.p[2] - wall.s[2] / 2 + _SILL_M + height_m / 2
    return OrientedBox((x, y, z), wall.q, (2 * _APRON_M, float(width) + 0.2, height_m))


def fit_openings(layout: Layout) -> None:
    """Clamp doors and windows to the walls as they have become."""
    for row, obj in enumerate(layout.objects):
        if obj.category != "wall" or not layout.is_left[row]:
            continue
        _, length, height = (2 * layout.boxes.half_m[row]).tolist()
        fitted = dict(obj.attributes)
        for name in ("door", "window"):
            _fit(fitted, name, length, height)
        layout.attributes.pop(row, None)
        if fitted != dict(obj.attributes):
            layout.attributes[row] = fitted


def _fit(
    attributes: dict[str, AttributeValue], name: str, length_m: float, height_m: float
) -> None:
    width = attributes.get(f"{name}_m")
    if not isinstance(width, int | float) or width <= 0:
        return
    widest = length_m - 2 * _JAMB_M
    is_ours = name == "door" and abs(float(width) - _CORPUS_DOOR_M) > _SAME_M
    least = _LEAST_DOOR_M[0] if is_ours else 0.0
    fitted = min(max(float(width), least), widest)
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
    """Write a length if it has changed by more than documents tell."""
    old = attributes.get(key)
    if not isinstance(old, int | float) or abs(float(old) - value) > _SAME_M:
        attributes[key] = round(value, 4)
