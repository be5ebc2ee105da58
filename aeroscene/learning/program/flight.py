"""The flight volume of a generated scene, and the place where flights start."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from aeroscene.corpus.curation.curate import HEADROOM_M
from aeroscene.scene import SceneObject, Vector3

_OPEN_SKY_M = 22.0
"""Least height of the flight volume under open sky."""


def extent_of(objects: Sequence[SceneObject], domain: str) -> tuple[Vector3, Vector3]:
    """Return the corners of the flight volume.

    Indoors it reaches up to the roof; outdoors it has headroom over everything, and at least
    `_OPEN_SKY_M`.

    Args:
        objects: Objects of the scene; without any the volume is a small box.
        domain: Domain of the scene.
    """
    corners = np.array([obj.bbox.corners() for obj in objects] or [[(-1, -1, 0), (1, 1, 0)]])
    low_m, high_m = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    top_m = max(float(high_m[2]), 1.0)
    if domain != "indoor":
        top_m = max(_OPEN_SKY_M, math.ceil(top_m + HEADROOM_M))
    # Rounded outwards to a centimetre, so that every object is inside.
    (x0, y0), (x1, y1) = np.floor(low_m[:2] * 100) / 100, np.ceil(high_m[:2] * 100) / 100
    return (float(x0), float(y0), 0.0), (float(x1), float(y1), round(top_m, 3))


def start_pad(objects: Sequence[SceneObject]) -> SceneObject | None:
    """Return the pad from which flights start; None if there is none."""
    return next((obj for obj in objects if obj.attributes.get("is_start")), None)


def top_of(obj: SceneObject) -> Vector3:
    """Return the middle of an object's upper face."""
    x, y, z = obj.bbox.p
    return x, y, round(z + obj.bbox.s[2] / 2, 4)


def yaw_inwards(start: Sequence[float]) -> float:
    """Return the heading from a place to the origin, rad."""
    return round(math.atan2(-start[1], -start[0]), 6)
