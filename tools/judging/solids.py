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
    """A solid in its own frame; `distances` is exact outside of boxes and cylinders.

    Outside of ellipsoids it is of the first order, outside of hulls a lower bound; the sign is
    exact for each.
    """

    entity: str
    kind: str
    position_enu_m: np.ndarray
    rotation: Rotation
    half_size_m: np.ndarray
    planes: np.ndarray
    """Of a hull: outward normals and offsets, n x 4."""

    def distances(self, points_enu_m: np.ndarray) -> np.ndarray:
        """Signed distance of each of n points, negative inside."""
        if self.kind == "hull":
            return np.max(points_enu_m @ self.planes[:, :3].T - self.planes[:, 3], axis=1)
        local_m = self.rotation.inv().apply(points_enu_m - self.position_enu_m)
        if self.kind == "ellipsoid":
            scaled = np.linalg.norm(local_m / self.half_size_m, axis=1)
            slope = np.linalg.norm(local_m / self.half_size_m**2, axis=1)
            return scaled * (scaled - 1.0) / np.maximum(slope, 1e-9)
        if self.kind == "cylinder":
            across_m = np.linalg.norm(local_m[:, :2], axis=1)
            local_m = np.column_stack([across_m, local_m[:, 2]])
            half_m = self.half_size_m[1:]
        else:
            half_m = self.half_size_m
        beyond_m = np.abs(local_m) - half_m
        outside_m = np.linalg.norm(np.maximum(beyond_m, 0.0), axis=1)
        return outside_m + np.minimum(beyond_m.max(axis=1), 0.0)


def solids_of(entity: str, columns: Columns) -> Iterator[Solid]:
    """Solids of one entity that has any."""
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

        def get(component: str, name: str = name) -> np.ndarray:
            return np.array(columns[f"{name}:{component}"], dtype=float)

        turns = Rotation.from_quat(get("quaternions"))
        for centre_m, turn, half_m in zip(get("centers"), turns, sizes(get), strict=True):
            yield Solid(entity, kind, centre_m, turn, half_m, np.empty((0, 4)))
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
    normals *= np.sign(np.sum(normals * (corners_m - inside_m), axis=1))[:, None]
    return np.column_stack([normals, np.sum(normals * corners_m, axis=1)])


def _hulls(vertices_m: Sequence[Sequence[float]]) -> Iterator[np.ndarray]:
    """Triangles, n x 3 x 3, of each closed surface: hulls stand one after another in a mesh."""
    triangles_m = np.array(vertices_m, dtype=float).reshape(-1, 3, 3)
    open_edges: set[frozenset[tuple[float, ...]]] = set()
    begin = 0
    for end, triangle_m in enumerate(triangles_m.tolist(), start=1):
        corners = [tuple(corner) for corner in triangle_m]
        for edge in combinations(corners, 2):
            open_edges ^= {frozenset(edge)}
        if not open_edges:
            yield triangles_m[begin:end]
            begin = end
