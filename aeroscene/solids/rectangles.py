"""Objects seen from above as rectangles, for models that know nothing else."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import shapely

from aeroscene.scene import SceneObject
from aeroscene.scene.box import rotation_matrix
from aeroscene.scene.outline import outline_in_box
from aeroscene.solids.shapes.convex import Ring, convex_pieces

Rectangle = tuple[tuple[float, float], float, tuple[float, float]]
"""Middle (ENU, m), heading of the first side (rad), lengths of both sides (m)."""


def rectangles_of(obj: SceneObject) -> Sequence[Rectangle]:
    """The box of an object, or one rectangle about each convex piece of its outline.

    A rectangle about a piece may cover more than the piece does, but never less.
    """
    box = obj.bbox
    outline = outline_in_box(obj.attributes, box.s)
    if outline is None:
        return [((box.p[0], box.p[1]), box.yaw_rad, (box.s[0], box.s[1]))]
    turn = rotation_matrix(box.q)[:2, :2]
    return [_about(np.asarray(ring) @ turn.T + box.p[:2]) for ring in convex_pieces(outline)]


def _about(points: np.ndarray | Ring) -> Rectangle:
    """The smallest rectangle about some points, in any direction."""
    around = shapely.oriented_envelope(shapely.MultiPoint(np.asarray(points)))
    (ax, ay), (bx, by), (cx, cy), *_ = shapely.get_coordinates(around).tolist()
    heading = math.atan2(by - ay, bx - ax)
    sides = (math.hypot(bx - ax, by - ay), math.hypot(cx - bx, cy - by))
    return ((ax + cx) / 2, (ay + cy) / 2), heading, sides
