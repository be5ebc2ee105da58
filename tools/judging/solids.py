"""Distances of points from the solids of a recording, as rerun draws them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

Columns = Mapping[str, Any]
"""Components of an entity by their names, each a list or None."""


@dataclass(frozen=True, eq=False)
class Solid:
    """A solid in its own frame, with the distances of points from it.

    A distance is exact outside of boxes and cylinders, of the first order outside of ellipsoids,
    and a lower bound outside of hulls. The sign is exact for each.
    """

    entity: str
    kind: str
    position_enu_m: np.ndarray
    rotation: Rotation
    half_size_m: np.ndarray
    planes: np.ndarray
    """Outward normals and offsets of a hull's faces, n x 4; empty for other kinds."""

    def distances(self, points_enu_m: np.ndarray) -> np.ndarray:
        """Signed distance of each of n points, negative inside, m.

        Args:
            points_enu_m: Points, n x 3.
        """
        if self.kind == "hull":
            # The face that a point is farthest outside of; beside an edge the true distance is
            # greater.
            return np.max(points_enu_m @ self.planes[:, :3].T - self.planes[:, 3], axis=1)
        local_m = self.rotation.inv().apply(points_enu_m - self.position_enu_m)
        if self.kind == "ellipsoid":
            # With k0 = |p / r| and k1 = |p / r^2| the distance is about k0 (k0 - 1) / k1: the value
            # of the implicit function k0 - 1 over the length of its gradient.
            scaled = np.linalg.norm(local_m / self.half_size_m, axis=1)
            slope = np.linalg.norm(local_m / self.half_size_m**2, axis=1)
            return scaled * (scaled - 1.0) / np.maximum(slope, 1e-9)
        if self.kind == "cylinder":
            # Seen across and along the axis, a cylinder is a rectangle.
            across_m = np.linalg.norm(local_m[:, :2], axis=1)
            local_m = np.column_stack([across_m, local_m[:, 2]])
            half_m = self.half_size_m[1:]
        else:
            half_m = self.half_size_m
        beyond_m = np.abs(local_m) - half_m
        outside_m = np.linalg.norm(np.maximum(beyond_m, 0.0), axis=1)
        return outside_m + np.minimum(beyond_m.max(axis=1), 0.0)


def solids_of(entity: str, columns: Columns) -> Iterator[Solid]:
    """Solids of one entity, as many as it has.

    Args:
        entity: Path of the entity.
        columns: Its components.
    """
    for name, kind, sizes in (
        ("Boxes3D", "box", lambda get: get("half_sizes")),
        ("Ellipsoids3D", "ellipsoid", lambda get: get("half_sizes")),
        (
            "Cylinders3D",
            "cylinder",
            lambda get: np.column_stack([get("radii"), get("radii"), get("lengths") / 2]),
        ),
    ):
        if f"{name}:centers" not in columns:
            continue

        # The default holds the name of this turn of the loop.
        def get(component: str, name: str = name) -> np.ndarray:
            return np.array(columns[f"{name}:{component}"], dtype=float)

        turns = Rotation.from_quat(get("quaternions"))
        for centre_m, turn, half_m in zip(get("centers"), turns, sizes(get), strict=True):
            yield Solid(entity, kind, centre_m, turn, half_m, np.empty((0, 4)))
    # A mesh has the corners of three for each triangle, none of them shared.
    for triangles_m in _hulls(columns.get("Mesh3D:vertex_positions", [])):
        middle_m = triangles_m.reshape(-1, 3).mean(axis=0)
        planes = _planes(triangles_m, middle_m)
        yield Solid(entity, "hull", middle_m, Rotation.identity(), np.zeros(3), planes)


def _planes(triangles_m: np.ndarray, inside_m: np.ndarray) -> np.ndarray:
    """Outward normals and offsets, m x 4, of the planes of n triangles that have an area."""
    edges_m = np.diff(triangles_m, axis=1)
    normals = np.cross(edges_m[:, 0], edges_m[:, 1])
    lengths = np.linalg.norm(normals, axis=1)
    is_flat = lengths < 1e-9
    normals, corners_m = normals[~is_flat] / lengths[~is_flat, None], triangles_m[~is_flat, 0]
    # Triangles may be wound either way, so that the middle of the hull decides what is outward.
    normals *= np.sign(np.sum(normals * (corners_m - inside_m), axis=1))[:, None]
    return np.column_stack([normals, np.sum(normals * corners_m, axis=1)])


def _hulls(vertices_m: Sequence[Sequence[float]]) -> Iterator[np.ndarray]:
    """Triangles, n x 3 x 3, of each closed surface: hulls stand one after another in a mesh."""
    triangles_m = np.array(vertices_m, dtype=float).reshape(-1, 3, 3)
    # An edge of a closed surface belongs to two triangles, and so is struck out by the second.
    open_edges: set[frozenset[tuple[float, ...]]] = set()
    begin = 0
    for end, triangle_m in enumerate(triangles_m.tolist(), start=1):
        corners = [tuple(corner) for corner in triangle_m]
        for edge in combinations(corners, 2):
            open_edges ^= {frozenset(edge)}
        if not open_edges:
            yield triangles_m[begin:end]
            begin = end
