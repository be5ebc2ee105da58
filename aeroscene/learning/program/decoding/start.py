"""Where flights start in a decoded scene."""

from __future__ import annotations

import math
from collections.abc import Sequence

from aeroscene.scene import SceneObject, Vector3


def start_pad(objects: Sequence[SceneObject]) -> SceneObject | None:
    """The pad from which flights start; None where there is none."""
    return next((obj for obj in objects if obj.attributes.get("is_start")), None)


def top_of(obj: SceneObject) -> Vector3:
    """The middle of an object's upper face."""
    x, y, z = obj.bbox.p
    return x, y, round(z + obj.bbox.s[2] / 2, 4)


def yaw_inwards(start: Sequence[float]) -> float:
    """Heading from a place to the origin, rad."""
    return round(math.atan2(-start[1], -start[0]), 6)
