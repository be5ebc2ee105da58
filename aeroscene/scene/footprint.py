"""The ground that an object covers."""

from __future__ import annotations

import shapely

from aeroscene.scene.box import rotation_matrix
from aeroscene.scene.outline import outline_in_box
from aeroscene.scene.scene import SceneObject


def footprint(obj: SceneObject) -> shapely.Polygon:
    """The ground that an object covers seen from above, ENU, m: its outline or that of its box."""
    box = obj.bbox
    outline = outline_in_box(obj.attributes, box.s)
    if outline is None:
        hull = shapely.convex_hull(shapely.MultiPoint(box.corners()[:, :2]))
        assert isinstance(hull, shapely.Polygon)
        return hull
    turn = rotation_matrix(box.q)[:2, :2]
    return shapely.transform(outline, lambda points: points @ turn.T + box.p[:2])
