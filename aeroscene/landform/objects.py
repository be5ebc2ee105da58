"""Objects on a relief, and back to flat ground.

The rise of an object follows from the relief, from the outlines seen from above and from the
hierarchy. None of these change when objects rise. The rise can therefore be computed again from the
raised scene, and `level` is the inverse of `on_relief`, without any record of the flat scene.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import shapely
from jaxtyping import Float

from aeroscene.scene import OrientedBox, Relief, Scene, SceneObject, Vector3
from aeroscene.scene.box import rotation_matrix
from aeroscene.scene.catalogue import COVERS, LEAFY
from aeroscene.scene.footprint import footprint

_TRUNK = 0.15
"""Share of the outline of a tree or bush that is its foot."""
_PROBES = np.array([(0, 0), (1, 1), (-1, 1), (-1, -1), (1, -1)], dtype=float)
"""Middle and corners of an outline, in halves of its sides."""
_DIGITS = 9
"""Decimals of heights: enough for a document's four, and few enough to drop the errors of a sum."""


def on_relief(scene: Scene, relief: Relief) -> Scene:
    """Set a scene on flat ground onto a relief, without areas.

    An object on the ground rises by the least height of the ground below its outline, as far as the
    ground is above the covers there. All objects that it carries rise with it. Trees and bushes
    stand on the ground at their trunks.

    Args:
        scene: Scene on flat ground.
        relief: Land that extends over the flight volume.
    """
    flat = replace(scene, interaction_areas=())
    return _moved(flat, relief, _Rises(flat, relief, is_raised=False), 1.0)


def level(scene: Scene) -> Scene:
    """Return a scene as it was before it was set onto its relief, without relief and areas.

    A scene without a relief is returned as it is, with its areas.

    Args:
        scene: Scene of `on_relief`; only for such scenes the result is exact.
    """
    if scene.relief is None:
        return scene
    raised = replace(scene, interaction_areas=())
    return _moved(raised, None, _Rises(raised, scene.relief, is_raised=True), -1.0)


def _moved(scene: Scene, relief: Relief | None, rises: _Rises, sign: float) -> Scene:
    objects = tuple(
        _lifted(obj, sign * rise_m)
        for obj, rise_m in zip(scene.objects, rises.of_objects_m, strict=True)
    )
    start = _above(scene.start_position_enu_m, sign * rises.of_start_m)
    return replace(scene, objects=objects, start_position_enu_m=start, relief=relief)


def _lifted(obj: SceneObject, rise_m: float) -> SceneObject:
    if rise_m == 0.0:
        return obj
    box = obj.bbox
    return replace(obj, bbox=OrientedBox(p=_above(box.p, rise_m), q=box.q, s=box.s))


def _above(place: Vector3, rise_m: float) -> Vector3:
    x, y, z = place
    return (x, y, round(z + rise_m, _DIGITS)) if rise_m else place


@dataclass(frozen=True, slots=True)
class _Cover:
    """A cover of the ground, with its height on the relief."""

    outline: shapely.Polygon
    top_m: float
    rise_m: float


class _Rises:
    """Rise of each object of a scene, whether or not it has risen already."""

    def __init__(self, scene: Scene, relief: Relief, *, is_raised: bool) -> None:
        self._scene, self._relief, self._is_raised = scene, relief, is_raised
        self._covers: dict[int, _Cover] = {}
        self._by_id: dict[int, float] = {}
        for obj in scene.objects:
            self._by_id[obj.id] = self._rise_m(obj)
            if obj.category in COVERS:
                self._covers[obj.id] = self._cover(obj, self._by_id[obj.id])
        self.of_objects_m = list(self._by_id.values())
        self.of_start_m = self._start_m()

    def _cover(self, obj: SceneObject, rise_m: float) -> _Cover:
        # A scene on its relief has its covers at their height already.
        top_m = obj.bbox.p[2] + obj.bbox.s[2] / 2 + (0.0 if self._is_raised else rise_m)
        return _Cover(footprint(obj), round(top_m, _DIGITS), rise_m)

    def _rise_m(self, obj: SceneObject) -> float:
        """Rise of an object whose parent's rise is known, m."""
        if obj.parent_id is None:
            return self._on_ground_m(standing_points(obj), self._under(obj))
        cover = self._covers.get(obj.parent_id)
        if cover is None:
            return self._by_id[obj.parent_id]
        return self._on_ground_m(standing_points(obj), [cover])

    def _start_m(self) -> float:
        for obj in self._scene.objects:
            if obj.attributes.get("is_start") is True:
                return self._by_id[obj.id]
        place = np.array([self._scene.start_position_enu_m[:2]])
        return self._on_ground_m(place, self._covers.values())

    def _under(self, obj: SceneObject) -> Iterable[_Cover]:
        """Covers on which an object without a parent may stand."""
        return () if obj.category in COVERS else self._covers.values()

    def _on_ground_m(self, probes: Float[np.ndarray, "k 2"], covers: Iterable[_Cover]) -> float:
        """Least rise at some points: of the ground, as far as it is above its covers, m."""
        ground_m = self._relief.height_m(*probes.T)
        if not ground_m.any():
            return 0.0
        rise_m, top_m = ground_m.copy(), np.full(len(probes), -np.inf)
        for cover in covers:
            is_on = shapely.intersects_xy(cover.outline, *probes.T) & (cover.top_m > top_m)
            top_m[is_on] = cover.top_m
            rise_m[is_on] = cover.rise_m + np.maximum(ground_m[is_on] - cover.top_m, 0.0)
        # Rounded as documents are, so that both directions give the same rise.
        return round(float(rise_m.min()), 4)


def standing_points(obj: SceneObject) -> Float[np.ndarray, "5 2"]:
    """East and north of the points at which an object meets the ground.

    They are middle and corners of its outline; of a tree or bush those of its foot.
    """
    box = obj.bbox
    half = (_TRUNK if obj.category in LEAFY else 1.0) * np.array(box.s[:2]) / 2
    turn = rotation_matrix(box.q)[:2, :2]
    return np.array(box.p[:2]) + (_PROBES * half) @ turn.T
