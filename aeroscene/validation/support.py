"""Support of each object: the ground, or a solid of another object below its feet.

An object stands if the middle of its feet lies within the hull of the parts of its feet that
something meets from below, like a chair on its legs. Nearly all objects stand on one box, so that
case is tested first, for all objects at once.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import shapely
from jaxtyping import Bool, Float, Int
from shapely.geometry.base import BaseGeometry

from aeroscene.scene import Relief, Scene, SceneObject
from aeroscene.scene.box import box_corners
from aeroscene.scene.geometry import layer, penetration_depth
from aeroscene.scene.hanging import is_hung
from aeroscene.scene.relief import ground_m
from aeroscene.solids.outlines import outline_of
from aeroscene.solids.solids import Solids
from aeroscene.validation.columns import spans
from aeroscene.validation.findings import Finding

GAP_M = 0.02
"""Distance up to which feet stand on a surface below them."""
_FOOT_M = 0.03
"""Height above the lowest solid up to which a solid's underside counts as a foot."""
_MIDDLE_M = 0.02
"""Distance by which the middle of the feet may lie outside of their base."""
_N_ACROSS = 17
"""Number of points along each side of the feet at which the ground is compared with them."""
_SLACK_M = 1e-6
"""Rounding of a point on the border of a box, m."""
_UP = np.array([0.0, 0.0, 1.0])


def floating(scene: Scene, solids: Solids) -> Iterator[Finding]:
    """Find objects that stand on nothing and hang on nothing.

    Args:
        scene: Scene.
        solids: Its solids that collide.
    """
    if not scene.objects:
        return
    boxes = [obj.bbox for obj in scene.objects]
    corners = box_corners(*([getattr(box, name) for box in boxes] for name in "pqs"))
    bottoms_m = corners[..., 2].min(axis=1).tolist()
    # The lowest ground below any corner: a box on a slope stands with one corner.
    below_m = ground_m(scene.relief, corners[..., 0], corners[..., 1]).min(axis=1).tolist()
    row = {obj.id: number for number, obj in enumerate(scene.objects)}
    row_of_solid = np.array([row[i] for i in solids.object_id.tolist()], dtype=int)
    family = _family(scene, row)
    is_borne = _on_one_box(solids, row_of_solid, family, np.array(bottoms_m))
    for number, obj in enumerate(scene.objects):
        # On the ground, or on one box: no further test is needed.
        if bottoms_m[number] <= below_m[number] + GAP_M or is_borne[number]:
            continue
        own = np.flatnonzero(row_of_solid == number)
        if not len(own):
            continue
        # An object cannot be supported by its own children.
        is_other = ~family[number, row_of_solid]
        stand = _Stand(scene.relief, solids, own, is_other, bottoms_m[number])
        detail = stand.objection()
        if detail and not (_may_hang(obj) and _touches(solids, own, is_other)):
            yield Finding(
                kind="floating",
                scene_id=scene.scene_id,
                object_id=obj.id,
                detail=f"{obj.category} {obj.id} has its feet at {bottoms_m[number]:.2f} m, "
                f"{detail}",
            )


def _family(scene: Scene, row: Mapping[int, int]) -> Bool[np.ndarray, "n n"]:
    """True if an object (row) is, or is an ancestor of, another one (column)."""
    family = np.eye(len(row), dtype=bool)
    for number, obj in enumerate(scene.objects):
        for ancestor in scene.ancestors(obj.id):
            family[row[ancestor], number] = True
    return family


def _on_one_box(
    solids: Solids,
    owner: Int[np.ndarray, " s"],
    family: Bool[np.ndarray, "n n"],
    bottom_m: Float[np.ndarray, " n"],
) -> Bool[np.ndarray, " n"]:
    """Objects all of whose feet are on one upright box; most are, and need no polygons."""
    n = len(family)
    lowest_m = np.full(n, np.inf)
    np.minimum.at(lowest_m, owner, solids.low_m[:, 2])
    foot = np.flatnonzero(solids.low_m[:, 2] <= lowest_m[owner] + _FOOT_M)
    low, high = np.full((n, 2), np.inf), np.full((n, 2), -np.inf)
    np.minimum.at(low, owner[foot], solids.low_m[foot, :2])
    np.maximum.at(high, owner[foot], solids.high_m[foot, :2])
    box = np.flatnonzero(solids.is_box & solids.is_upright)
    meets = ~family[:, owner[box]]
    meets &= solids.low_m[box, 2] <= bottom_m[:, None] + GAP_M
    meets &= solids.high_m[box, 2] >= bottom_m[:, None] - GAP_M
    for axis in range(2):
        meets &= solids.low_m[box, axis] <= high[:, axis, None]
        meets &= solids.high_m[box, axis] >= low[:, axis, None]
    obj, under = np.nonzero(meets)
    under = box[under]
    is_borne = np.ones(len(obj), dtype=bool)
    # All four corners of the feet have to be on the box.
    for x, y in ((low, low), (low, high), (high, low), (high, high)):
        offset = np.stack([x[obj, 0], y[obj, 1]], axis=1) - solids.centre_m[under, :2]
        local = np.abs(np.einsum("ki,kia->ka", offset, solids.rotation[under, :2, :2]))
        is_borne &= (local <= solids.half_m[under, :2] + _SLACK_M).all(axis=1)
    found = np.zeros(n, dtype=bool)
    found[obj[is_borne]] = True
    return found


def _may_hang(obj: SceneObject) -> bool:
    """Return true for hung objects, and for parts of a building that are held from the side."""
    return is_hung(obj) or (obj.is_coarse and obj.parent_id is not None)


def _touches(solids: Solids, own: Int[np.ndarray, " k"], is_other: np.ndarray) -> bool:
    """Return true if a solid of another object meets one of an object's own, each as its box."""
    quats = np.array([p.quat_wxyz for p in solids.primitives])
    for i in own:
        near = solids.near(solids.low_m[i] - GAP_M, solids.high_m[i] + GAP_M)
        near = near[is_other[near]]
        depth = penetration_depth(
            solids.centre_m[i],
            quats[i],
            2 * solids.half_m[i],
            solids.centre_m[near],
            quats[near],
            2 * solids.half_m[near],
        )
        if np.any(depth > -GAP_M):
            return True
    return False


class _Stand:
    """The feet of one object and the solids that may carry them."""

    def __init__(
        self,
        relief: Relief | None,
        solids: Solids,
        own: Int[np.ndarray, " k"],
        is_other: np.ndarray,
        bottom_m: float,
    ) -> None:
        self._relief = relief
        self._solids = solids
        self._bottom_m = bottom_m
        self._feet = own[solids.low_m[own, 2] <= solids.low_m[own, 2].min() + _FOOT_M]
        low = solids.low_m[self._feet].min(axis=0)
        high = solids.high_m[self._feet].max(axis=0)
        low[2], high[2] = bottom_m - GAP_M, bottom_m + GAP_M
        near = solids.near(low, high)
        self._bearers = near[is_other[near]]
        low[2] = 0.0 if relief is None else relief.min_m
        below = solids.near(low, high)
        self._below = below[is_other[below]]

    def objection(self) -> str | None:
        """Describe why the object does not stand; None if it does."""
        if self._is_balanced():
            return None
        feet = shapely.union_all([outline_of(self._solids.points(i)) for i in self._feet])
        borne = [self._bearing(i, feet) for i in self._bearers]
        if self._relief is not None:
            borne.append(self._bearing_ground(self._relief, feet))
        base = shapely.convex_hull(shapely.union_all(borne)) if borne else shapely.Point()
        if base.is_empty:
            return f"{self._gap_m(feet):.2f} m above what is below; valid: at most {GAP_M} m"
        off_m = base.distance(feet.centroid)
        if off_m <= _MIDDLE_M:
            return None
        return (
            f"with their middle {off_m:.2f} m beside what bears them; valid: at most {_MIDDLE_M} m"
        )

    def _is_balanced(self) -> bool:
        """Return true if a box carries the middle of a single upright foot."""
        s, foot = self._solids, self._feet[0]
        if len(self._feet) > 1 or s.is_mesh[foot] or not s.is_upright[foot]:
            return False
        near = self._bearers[s.is_box[self._bearers] & s.is_upright[self._bearers]]
        offset = s.centre_m[foot, None, :2] - s.centre_m[near, None, :2]
        local = np.abs(offset @ s.rotation[near, :2, :2])[:, 0]
        return bool((local <= s.half_m[near, :2] - _SLACK_M).all(axis=1).any())

    def _bearing(self, index: int, feet: BaseGeometry) -> BaseGeometry:
        """Part of the feet that a solid meets at their height."""
        low_m, high_m = self._bottom_m - GAP_M, self._bottom_m + GAP_M
        points = layer(self._solids.points(index), _UP, low_m, high_m)
        return shapely.intersection(outline_of(points), feet)

    def _bearing_ground(self, relief: Relief, feet: BaseGeometry) -> BaseGeometry:
        """Part of the feet that the ground meets: on a slope their uphill side."""
        x0, y0, x1, y1 = feet.bounds
        x, y = np.meshgrid(np.linspace(x0, x1, _N_ACROSS), np.linspace(y0, y1, _N_ACROSS))
        points = np.vstack([np.column_stack([x.ravel(), y.ravel()]), shapely.get_coordinates(feet)])
        points = points[relief.height_m(*points.T) >= self._bottom_m - GAP_M]
        return shapely.intersection(outline_of(points), feet)

    def _gap_m(self, feet: BaseGeometry) -> float:
        """Least height of the corners of the feet above the solids or the ground below them, m."""
        points = shapely.get_coordinates(feet)
        top_m = ground_m(self._relief, *points.T)
        for index in self._below:
            top_m = np.fmax(top_m, spans(self._solids, int(index), points)[:, 1])
        return float(self._bottom_m - top_m.max())
