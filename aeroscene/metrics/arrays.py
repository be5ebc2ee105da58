"""A scene as arrays, unpacked once, so that every figure can compute on all objects at once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.landform import level
from aeroscene.scene import Scene
from aeroscene.scene.catalogue import CATALOGUE

NO_PARENT = -1

N_CATEGORIES = len(CATALOGUE)

IS_COARSE: Bool[np.ndarray, " categories"] = np.array(
    [CATALOGUE[number].level == "coarse" for number in sorted(CATALOGUE)]
)
"""True for coarse categories, by the category's id less one."""


@dataclass(frozen=True, eq=False)
class SceneArrays:
    """The objects of a scene, one row each, in the scene's order: parents before children.

    Figures rely on that order: one pass over the rows meets every parent before its children.
    """

    scene_id: str
    category: Int[np.ndarray, " n"]
    """Category id less one."""
    parent: Int[np.ndarray, " n"]
    """Row of the parent; `NO_PARENT` for a root."""
    centre_enu_m: Float[np.ndarray, "n 3"]
    quat_wxyz: Float[np.ndarray, "n 4"]
    size_m: Float[np.ndarray, "n 3"]
    """Full extents along the box's own axes."""
    extent_enu_m: Float[np.ndarray, "2 3"]
    """Lower and upper corner of the flight volume."""

    @property
    def n_objects(self) -> int:
        """Number of objects."""
        return len(self.category)

    @cached_property
    def is_coarse(self) -> Bool[np.ndarray, " n"]:
        """True for objects of coarse categories."""
        return IS_COARSE[self.category]

    @cached_property
    def yaw_rad(self) -> Float[np.ndarray, " n"]:
        """Heading of each box's x axis, counter-clockwise from east."""
        w, x, y, z = self.quat_wxyz.T
        return np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))

    @cached_property
    def is_ancestor(self) -> Bool[np.ndarray, "n n"]:
        """True if the row's object is the column's parent, the parent's parent, and so on."""
        result = np.zeros((self.n_objects, self.n_objects), dtype=bool)
        for row, parent in enumerate(self.parent.tolist()):
            if parent != NO_PARENT:
                # The parent's column is complete already: its ancestors are the child's, too.
                result[:, row] = result[:, parent]
                result[parent, row] = True
        return result

    @cached_property
    def region(self) -> Int[np.ndarray, " n"]:
        """Row of the nearest coarse ancestor; `NO_PARENT` if there is none."""
        result = np.full(self.n_objects, NO_PARENT)
        for row, parent in enumerate(self.parent.tolist()):
            if parent != NO_PARENT:
                result[row] = parent if self.is_coarse[parent] else result[parent]
        return result


def scene_arrays(scene: Scene) -> SceneArrays:
    """Unpack a scene as it lies on flat ground.

    The relief of the ground is removed first, because it is no part of the layout: otherwise equal
    layouts on different hills would differ.
    """
    objects = level(scene).objects
    row_of = {obj.id: row for row, obj in enumerate(objects)}
    parents = (obj.parent_id for obj in objects)
    return SceneArrays(
        scene_id=scene.scene_id,
        category=np.array([obj.category_id - 1 for obj in objects], dtype=int),
        parent=np.array([NO_PARENT if p is None else row_of[p] for p in parents], dtype=int),
        centre_enu_m=np.array([obj.bbox.p for obj in objects], dtype=float).reshape(-1, 3),
        quat_wxyz=np.array([obj.bbox.q for obj in objects], dtype=float).reshape(-1, 4),
        size_m=np.array([obj.bbox.s for obj in objects], dtype=float).reshape(-1, 3),
        extent_enu_m=np.array([scene.extent_min_enu_m, scene.extent_max_enu_m]),
    )
