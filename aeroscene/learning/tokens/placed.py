"""How an object hangs on what it is attached to: its parent, or the site."""

from __future__ import annotations

import math
from collections import Counter
from typing import NamedTuple

from aeroscene.scene import Scene, SceneObject

SITE = ""
"""Category of the site, which is no object."""
ATTACHED_M = 0.011
"""Undersides nearer than this to a height are at it."""
_ALIGNED_RAD = math.radians(0.5)
_QUARTER_RAD = math.pi / 2


class Placed(NamedTuple):
    """An object with what it is attached to."""

    obj: SceneObject
    parent: SceneObject | None
    site_yaw_rad: float

    @property
    def category(self) -> str:
        """Category of the parent."""
        return SITE if self.parent is None else self.parent.category

    @property
    def rise_m(self) -> float:
        """Height of the underside above the parent's."""
        return underside_m(self.obj) - underside_m(self.parent)

    @property
    def is_on_top(self) -> bool:
        """Whether it stands on the upper face of its parent."""
        parent = self.parent
        if parent is None:
            return False
        return abs(self.rise_m - parent.bbox.s[2]) < ATTACHED_M

    @property
    def is_aligned(self) -> bool:
        """Whether its heading is a multiple of a quarter turn to the parent's."""
        yaw = self.site_yaw_rad if self.parent is None else self.parent.bbox.yaw_rad
        turn = math.remainder(self.obj.bbox.yaw_rad - yaw, _QUARTER_RAD)
        return abs(turn) < _ALIGNED_RAD


def placed_objects(scene: Scene) -> list[Placed]:
    """All objects of a scene."""
    by_id, yaw = scene.object_by_id, site_yaw(scene)
    return [
        Placed(obj, None if obj.parent_id is None else by_id[obj.parent_id], yaw)
        for obj in scene.objects
    ]


def site_yaw(scene: Scene) -> float:
    """Heading of the ground plan, from -45 to 45 degrees: that of most of what stands on it."""
    headings = Counter(
        round(math.remainder(obj.bbox.yaw_rad, _QUARTER_RAD), 4)
        for obj in scene.objects
        if obj.parent_id is None
    )
    if not headings:
        return 0.0
    return min(headings.items(), key=lambda item: (-item[1], abs(item[0]), item[0]))[0]


def underside_m(obj: SceneObject | None) -> float:
    """Height of the lower face of an upright box; that of the site is the ground."""
    return 0.0 if obj is None else obj.bbox.p[2] - obj.bbox.s[2] / 2
