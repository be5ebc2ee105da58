"""Footprints: the ground that objects cover, as polygons."""

from __future__ import annotations

import shapely

from aeroscene.scene.box import rotation_matrix
from aeroscene.scene.outline import outline_in_box
from aeroscene.scene.scene import SceneObject


def footprint(obj: SceneObject) -> shapely.Polygon:
    """Footprint of an object seen from above, ENU, m: its outline, or else the hull of its box.

    A tilted box casts the hull of all its eight corners. Objects with an `outline` are upright, so
    that turning the outline about the vertical is enough.
    """
    box = obj.bbox
    outline = outline_in_box(obj.attributes, box.s)
    if outline is None:
        hull = shapely.convex_hull(shapely.MultiPoint(box.corners()[:, :2]))
        assert isinstance(hull, shapely.Polygon)
        return hull
    turn = rotation_matrix(box.q)[:2, :2]
    return shapely.transform(outline, lambda points: points @ turn.T + box.p[:2])
