"""Solid obstacles: boxes, cylinders, ellipsoids and convex hulls, and the distance to them.

All are convex, because a separating plane then exists for every point outside; other shapes are
given as several of them. They come as arrays, so that planning knows no scene.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from autonomy.planning.solids import Solids, distances_to_solids


class Shape(IntEnum):
    """Shape of an obstacle, which determines the meaning of its local extents."""

    BOX = 0
    CYLINDER = 1
    """Cylinder about its local z; the first extent is the diameter."""
    ELLIPSOID = 2
    HULL = 3
    """Intersection of half-spaces."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Obstacles:
    """Solids in ENU.

    Arrays have one row per solid. Hulls keep their faces in one shared array, because their numbers
    differ.
    """

    center_enu_m: Float[np.ndarray, "n 3"]
    quat_wxyz: Float[np.ndarray, "n 4"]
    """Rotations from local axes to the world, unit quaternions."""
    size_m: Float[np.ndarray, "n 3"]
    """Full local extents."""
    shape: Int[np.ndarray, " n"]
    faces: Float[np.ndarray, "m 4"] = field(default_factory=lambda: np.zeros((0, 4)))
    """Faces of hulls: outward unit normal n and offset d, local; x is beyond where n.x > d."""
    faces_end: Int[np.ndarray, " n"]
    """One past the last face of each obstacle; the first one is where the faces of the obstacle
    before end."""

    @classmethod
    def boxes(
        cls,
        center_enu_m: Float[np.ndarray, "n 3"],
        quat_wxyz: Float[np.ndarray, "n 4"],
        size_m: Float[np.ndarray, "n 3"],
    ) -> Obstacles:
        """Create oriented boxes."""
        n = len(center_enu_m)
        return cls(
            center_enu_m=np.asarray(center_enu_m, dtype=float).reshape(n, 3),
            quat_wxyz=np.asarray(quat_wxyz, dtype=float).reshape(n, 4),
            size_m=np.asarray(size_m, dtype=float).reshape(n, 3),
            shape=np.full(n, int(Shape.BOX)),
            faces_end=np.zeros(n, dtype=np.int64),
        )

    def __len__(self) -> int:
        return len(self.center_enu_m)

    @cached_property
    def solids(self) -> Solids:
        """The obstacles as arrays for kernels."""
        return Solids(
            self.center_enu_m,
            rotation_matrices(self.quat_wxyz),
            self.size_m / 2,
            self.shape,
            self.faces,
            self.faces_end,
        )

    def signed_distance(
        self, points_enu_m: Float[np.ndarray, "k 3"]
    ) -> tuple[Float[np.ndarray, " k"], Int[np.ndarray, " k"]]:
        """Distance from each point to the nearest obstacle, negative inside, and its index.

        Without obstacles the distance is infinite and the index -1.
        """
        points = np.ascontiguousarray(points_enu_m, dtype=float)
        return distances_to_solids(points, self.solids)


def join(groups: Sequence[Obstacles]) -> Obstacles:
    """Return all obstacles of several groups as one, in order."""
    ends, offset = [], 0
    for group in groups:
        ends.append(group.faces_end + offset)
        offset += len(group.faces)
    return Obstacles(
        center_enu_m=np.concatenate([group.center_enu_m for group in groups]),
        quat_wxyz=np.concatenate([group.quat_wxyz for group in groups]),
        size_m=np.concatenate([group.size_m for group in groups]),
        shape=np.concatenate([group.shape for group in groups]),
        faces=np.concatenate([group.faces for group in groups]),
        faces_end=np.concatenate(ends),
    )


def rotation_matrices(quat_wxyz: Float[np.ndarray, "n 4"]) -> Float[np.ndarray, "n 3 3"]:
    """Rotation matrices from local axes to the world, of unit quaternions."""
    w, x, y, z = quat_wxyz.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.ascontiguousarray(np.moveaxis(np.array(rows), -1, 0))
