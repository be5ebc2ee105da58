"""The solids of a scene as arrays, for questions to all of them at once.

Landing areas, voxels and the planner ask which of thousands of solids are near a place, or how far
they extend along a direction. One numpy call answers that for all of them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import product

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.scene import Vector3
from aeroscene.scene.box import rotation_matrix
from aeroscene.solids.shapes import Primitive

_UPRIGHT = 1 - 1e-9
"""Least cosine of tilt of a solid that counts as upright."""
_ROUND = 16
"""Number of corners that stand for a circle."""
_RINGS = (-0.92, -0.7, -0.38, 0.0, 0.38, 0.7, 0.92)
"""Heights of the rings of points on a unit sphere."""


class Solids:
    """Primitives as arrays; row i of each belongs to `primitives[i]`.

    Attributes:
        primitives: The primitives.
        object_id: Object of each.
        centre_m: Centres, ENU.
        half_m: Half of the full local extents.
        rotation: Rotation matrices, local to world.
        is_box: True for boxes, whose faces are plane.
        is_round: True for cylinders and ellipsoids.
        is_cylinder: True for cylinders.
        is_mesh: True for convex hulls of points.
        is_upright: True if local z is vertical.
        low_m: Lower corners of the bounding boxes along the world's axes.
        high_m: Upper corners.
    """

    def __init__(self, primitives: Iterable[Primitive]) -> None:
        self.primitives = tuple(primitives)
        solids = self.primitives
        self.object_id: Int[np.ndarray, " n"] = np.array([p.object_id for p in solids], dtype=int)
        self.centre_m = np.array([p.position_enu_m for p in solids]).reshape(-1, 3)
        self.half_m = np.array([p.size_m for p in solids]).reshape(-1, 3) / 2
        quats = np.array([p.quat_wxyz for p in solids]).reshape(-1, 4)
        self.rotation: Float[np.ndarray, "n 3 3"] = rotation_matrix(quats)
        self.is_box: Bool[np.ndarray, " n"] = np.array([p.kind == "box" for p in solids], bool)
        self.is_round = np.array([p.kind in {"cylinder", "ellipsoid"} for p in solids], bool)
        self.is_cylinder = np.array([p.kind == "cylinder" for p in solids], bool)
        self.is_mesh = np.array([p.kind == "mesh" for p in solids], bool)
        self.is_upright = np.abs(self.rotation[:, 2, 2]) > _UPRIGHT
        reach = self.reach_along(np.eye(3), np.arange(len(solids)))
        self.low_m: Float[np.ndarray, "n 3"] = self.centre_m - reach[..., 0]
        self.high_m: Float[np.ndarray, "n 3"] = self.centre_m + reach[..., 1]

    def __len__(self) -> int:
        return len(self.primitives)

    def reach_along(
        self, axes: Float[np.ndarray, "a 3"], which: Int[np.ndarray, " k"]
    ) -> Float[np.ndarray, "k a 2"]:
        """Exact extent of some solids from their centres, against and along some vectors.

        Args:
            axes: Vectors, ENU; lengths other than one scale the result.
            which: Numbers of the solids.

        Returns:
            For each solid and vector: how far it extends against the vector and along it, m. Only
            meshes are not symmetrical.
        """
        local = np.asarray(axes) @ self.rotation[which]
        half = self.half_m[which]
        reach = np.einsum("nai,ni->na", np.abs(local), half)
        if self.is_round[which].any():
            is_cylinder = self.is_cylinder[which]
            # A cylinder adds the reach of its disc and of its axis; an ellipsoid is a scaled
            # sphere.
            is_ellipsoid = self.is_round[which] & ~is_cylinder
            radial = np.hypot(local[..., 0], local[..., 1]) * half[:, None, 0]
            along = np.abs(local[..., 2]) * half[:, None, 2]
            reach[is_cylinder] = (radial + along)[is_cylinder]
            reach[is_ellipsoid] = np.linalg.norm(local * half[:, None], axis=-1)[is_ellipsoid]
        both = np.stack([reach, reach], axis=-1)
        for row in np.flatnonzero(self.is_mesh[which]):
            heights = np.asarray(self.primitives[which[row]].vertices_m) @ local[row].T
            both[row] = np.stack([-heights.min(axis=0), heights.max(axis=0)], axis=-1)
        return both

    def points(self, index: int) -> Float[np.ndarray, "k 3"]:
        """Points on a solid whose hull it is; for round solids the hull is a little smaller."""
        primitive = self.primitives[index]
        if primitive.kind == "mesh":
            local = np.asarray(primitive.vertices_m)
        else:
            local = _unit_points(primitive.kind) * self.half_m[index]
        return local @ self.rotation[index].T + self.centre_m[index]

    def near(
        self, low_m: Float[np.ndarray, " 3"], high_m: Float[np.ndarray, " 3"]
    ) -> Int[np.ndarray, " k"]:
        """Numbers of the solids whose bounding boxes along the axes meet a box."""
        return np.flatnonzero(
            (self.low_m <= high_m).all(axis=1) & (self.high_m >= low_m).all(axis=1)
        )


def colliding(primitives: Iterable[Primitive]) -> Solids:
    """The solids of all primitives that collide; paint and other decor is left out."""
    return Solids(primitive for primitive in primitives if primitive.collides)


@cache
def _unit_points(kind: str) -> Float[np.ndarray, "k 3"]:
    """Points on the surface of a solid with half extents of one."""
    if kind == "box":
        return np.array(list(product((-1.0, 1.0), repeat=3)))
    turns = 2 * np.pi * np.arange(_ROUND) / _ROUND
    circle = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    if kind == "cylinder":
        return np.array([(x, y, z) for z in (-1.0, 1.0) for x, y in circle])
    rings = [(r * x, r * y, z) for z in _RINGS for r in (np.sqrt(1 - z * z),) for x, y in circle]
    return np.array([*rings, (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)])


@dataclass(frozen=True, slots=True, eq=False)
class HullFaces:
    """The faces of a convex hull."""

    planes: Float[np.ndarray, "faces 4"]
    """Outward normals and offsets: inside, `normal @ x + offset <= 0`."""
    corners: tuple[Int[np.ndarray, " k"], ...]
    """Numbers of the vertices of each face, unordered."""


@lru_cache(maxsize=4096)
def hull_faces(vertices_m: tuple[Vector3, ...]) -> HullFaces:
    """Faces of the convex hull of some points; coplanar triangles are united.

    Args:
        vertices_m: At least four points that do not lie in one plane.
    """
    from scipy.spatial import ConvexHull

    # Qhull returns triangles. Those with equal equations, up to rounding, are one face.
    hull = ConvexHull(np.asarray(vertices_m))
    _, first, face = np.unique(
        np.round(hull.equations, 6), axis=0, return_index=True, return_inverse=True
    )
    corners = tuple(np.unique(hull.simplices[face.ravel() == i]) for i in range(len(first)))
    return HullFaces(hull.equations[first], corners)
