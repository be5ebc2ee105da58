"""A scene seen from above: outlines of its objects, and the heights between which each stands.

Checks of places ask the same few questions of the same objects. A view computes each answer once,
for all objects, and on first use.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from jaxtyping import Bool, Float, Int

from aeroscene.landform import level
from aeroscene.metrics.arrays import SceneArrays, scene_arrays
from aeroscene.relations import Unit, scene_relations
from aeroscene.scene import AttributeValue, Scene
from aeroscene.scene.box import box_corners, rotation_matrix
from aeroscene.scene.catalogue import ROOMS, SHELLS, category_id


@dataclass(frozen=True, eq=False)
class TopView:
    """The objects of a scene, one row each, in the scene's order."""

    scene: Scene

    @cached_property
    def arrays(self) -> SceneArrays:
        """Boxes, categories and parents."""
        return scene_arrays(self.scene)

    @cached_property
    def use(self) -> tuple[AttributeValue | None, ...]:
        """Use of each room; None for other objects, and if the scene does not state it."""
        return tuple(obj.attributes.get("use") for obj in self.scene.objects)

    @cached_property
    def units(self) -> tuple[Unit, ...]:
        """Relations of the fine objects to their hosts."""
        return scene_relations(level(self.scene))

    def rows(self, categories: Collection[str]) -> Int[np.ndarray, " k"]:
        """Rows of the objects of some categories."""
        numbers = [category_id(name) - 1 for name in categories]
        return np.flatnonzero(np.isin(self.arrays.category, numbers))

    def is_in(self, categories: Collection[str]) -> Bool[np.ndarray, " n"]:
        """True for objects with an ancestor of one of these categories."""
        return np.any(self.arrays.is_ancestor[self.rows(categories)], axis=0)

    def is_on(self, categories: Collection[str]) -> Bool[np.ndarray, " n"]:
        """True for objects whose parent has one of these categories."""
        # Rows are never negative, so a root's `NO_PARENT` is none of them.
        return np.isin(self.arrays.parent, self.rows(categories))

    @cached_property
    def is_outdoors(self) -> Bool[np.ndarray, " n"]:
        """True for objects that are neither part nor content of a building or room."""
        return np.logical_not(self.is_in(SHELLS | ROOMS))

    @cached_property
    def centre_m(self) -> Float[np.ndarray, "n 2"]:
        """Centres, east and north."""
        return self.arrays.centre_enu_m[:, :2]

    @cached_property
    def forward(self) -> Float[np.ndarray, "n 2"]:
        """Unit vectors along each box's x axis, the side that an object shows to its user."""
        yaw_rad = self.arrays.yaw_rad
        return np.stack([np.cos(yaw_rad), np.sin(yaw_rad)], axis=1)

    @cached_property
    def leftward(self) -> Float[np.ndarray, "n 2"]:
        """Unit vectors along each box's y axis."""
        return np.stack([-self.forward[:, 1], self.forward[:, 0]], axis=1)

    @cached_property
    def outline(self) -> np.ndarray:
        """Outlines of the objects as polygons, seen from above."""
        arrays = self.arrays
        corners = box_corners(arrays.centre_enu_m, arrays.quat_wxyz, arrays.size_m)[..., :2]
        # A box seen from above is the hull of its eight corners, tilted or not.
        return np.asarray(shapely.convex_hull(shapely.linestrings(corners)))

    @cached_property
    def base_m(self) -> Float[np.ndarray, " n"]:
        """Heights of the undersides."""
        return self.arrays.centre_enu_m[:, 2] - self._half_height_m

    @cached_property
    def top_m(self) -> Float[np.ndarray, " n"]:
        """Heights of the upper sides."""
        return self.arrays.centre_enu_m[:, 2] + self._half_height_m

    @cached_property
    def _half_height_m(self) -> Float[np.ndarray, " n"]:
        upward = np.abs(rotation_matrix(self.arrays.quat_wxyz)[:, 2])
        # Tilted boxes reach higher than half of their own height.
        return (upward * self.arrays.size_m).sum(axis=1) / 2

    def shared_height_m(
        self, first: Int[np.ndarray, "*k"], second: Int[np.ndarray, "*k"]
    ) -> Float[np.ndarray, "*k"]:
        """Height that pairs of objects have in common, m; negative for a gap between them.

        Args:
            first: Rows of the first objects.
            second: Rows of the second objects.
        """
        top_m = np.minimum(self.top_m[first], self.top_m[second])
        return top_m - np.maximum(self.base_m[first], self.base_m[second])

    def face(self, rows: Int[np.ndarray, " k"], axis: int, sign: int) -> Float[np.ndarray, "k 2 2"]:
        """Ends of an upright face of boxes, seen from above.

        Args:
            rows: Rows of the objects.
            axis: 0 for a face across x, 1 for a face across y.
            sign: 1 or -1, the side of the box.
        """
        own = (self.forward[rows], self.leftward[rows])
        half_m = self.arrays.size_m[rows] / 2
        middle_m = self.centre_m[rows] + sign * half_m[:, axis, None] * own[axis]
        reach_m = half_m[:, 1 - axis, None] * own[1 - axis]
        return np.stack([middle_m - reach_m, middle_m + reach_m], axis=1)


def near_pairs(
    first: shapely.Geometry | np.ndarray, second: shapely.Geometry | np.ndarray, apart_m: float
) -> tuple[Int[np.ndarray, " k"], Int[np.ndarray, " k"]]:
    """Find the pairs of two lists of geometries that are at most so far apart.

    Args:
        first: One list.
        second: The other.
        apart_m: Greatest distance.

    Returns:
        Indices into the first and into the second list, pair by pair.
    """
    # `query` gives indices of its argument first, then those of the tree.
    index, other = shapely.STRtree(np.asarray(second)).query(
        first, predicate="dwithin", distance=apart_m
    )
    return index, other


def union(outlines: np.ndarray) -> shapely.Geometry:
    """Join outlines to one geometry, which is prepared for many queries."""
    whole = shapely.union_all(outlines)
    # Prepared geometries keep an index of their edges.
    shapely.prepare(whole)
    return whole
