"""Tessellation of solids, shared by OpenGL pictures, ray casting and tests.

Round shapes get `slices` sides around their axis and `stacks` from pole to pole. Texture
coordinates are in metres along the surface, u horizontal and v up, so that bricks have one size on
all walls.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from flightsim.looks.hull import face_axes, hull_faces

N_BOX_FACES = 6


@dataclass(frozen=True, eq=False)
class Surface:
    """A closed surface; corners counter-clockwise seen from outside."""

    vertices_m: Float[np.ndarray, "v 3"]
    normals: Float[np.ndarray, "v 3"]
    """Outward unit normals."""
    texture_m: Float[np.ndarray, "v 2"]
    triangles: Int[np.ndarray, "t 3"]

    def corners_m(self) -> Float[np.ndarray, "t 3 3"]:
        """Return the three corners of each triangle."""
        return self.vertices_m[self.triangles]


def box(size_m: np.ndarray) -> Surface:
    """Return a box by full extents; the texture starts in the lower left corner of each face."""
    vertices, texture, normals, triangles = unit_box()
    return Surface(vertices * size_m, normals, box_texture_m(texture, size_m), triangles)


def ellipsoid(size_m: np.ndarray, slices: int, stacks: int) -> Surface:
    """Return an ellipsoid by full extents.

    Args:
        size_m: Full extents.
        slices: Sides around the vertical axis.
        stacks: Bands from pole to pole.
    """
    unit = _unit_sphere(slices, stacks)
    half_m = np.asarray(size_m) / 2
    # The gradient of the implicit surface, which is not the direction from the centre.
    normals = unit.vertices_m / half_m
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    texture_m = unit.texture_m * (half_m[:2].mean(), half_m[2])
    return Surface(unit.vertices_m * half_m, normals, texture_m, unit.triangles)


def cylinder(radius_m: float, length_m: float, slices: int) -> Surface:
    """Return an upright cylinder at the origin.

    Args:
        radius_m: Radius.
        length_m: Height.
        slices: Sides.
    """
    unit = _unit_cylinder(slices)
    scale = np.array([radius_m, radius_m, length_m])
    n_side = 2 * (slices + 1)
    texture_m = unit.texture_m * radius_m
    # Only the side's v runs along the length; those of the caps lie in their plane.
    texture_m[:n_side, 1] = unit.texture_m[:n_side, 1] * length_m
    return Surface(unit.vertices_m * scale, unit.normals, texture_m, unit.triangles)


def capsule(radius_m: float, half_length_m: float, slices: int, stacks: int) -> Surface:
    """Return an upright cylinder with half spheres at its ends: a sphere stretched at its equator.

    Args:
        radius_m: Radius of cylinder and half spheres.
        half_length_m: Half the length of the cylinder.
        slices: Sides around the axis.
        stacks: Bands of both half spheres.
    """
    half_stacks = (stacks + 1) // 2
    polar = np.linspace(0.0, math.pi / 2, half_stacks + 1)
    rows = np.concatenate([polar, math.pi - polar[::-1]])
    shift_m = np.where(np.arange(len(rows)) <= half_stacks, half_length_m, -half_length_m)
    azimuth = np.arange(slices + 1) * (2 * math.pi / slices)
    normals = _sphere_points(rows, azimuth)
    points = radius_m * normals
    points[..., 2] += shift_m[:, None]
    texture = np.stack(np.broadcast_arrays(radius_m * azimuth, points[:, :1, 2]), axis=2)
    return _grid(points, normals, texture)


def hull(corners_m: np.ndarray) -> Surface:
    """Return the convex hull of some corners, with sharp edges."""
    vertices, normals, texture, triangles = [], [], [], []
    count = 0
    for normal, members in hull_faces(corners_m):
        points = np.asarray(corners_m, dtype=float)[members]
        n = len(members)
        vertices.append(points)
        normals.append(np.tile(normal, (n, 1)))
        texture.append(points @ np.stack(face_axes(normal), axis=1))
        triangles += [(count, count + i, count + i + 1) for i in range(1, n - 1)]
        count += n
    return Surface(
        np.vstack(vertices), np.vstack(normals), np.vstack(texture), np.array(triangles, np.int32)
    )


def _grid(points: np.ndarray, normals: np.ndarray, texture: np.ndarray) -> Surface:
    """Two triangles for each cell of a grid of points, rows from top to bottom."""
    rows, columns = points.shape[:2]
    index = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    triangles = np.concatenate([np.stack([a, b, c], 2), np.stack([a, c, d], 2)]).reshape(-1, 3)
    vertices = points.reshape(-1, 3)
    corners = vertices[triangles]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # At the poles one of the two is degenerate.
    has_area = np.linalg.norm(area, axis=1) > 1e-12
    return Surface(vertices, normals.reshape(-1, 3), texture.reshape(-1, 2), triangles[has_area])


@functools.cache
def unit_box() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return vertices, texture corners (0 or 1, and the axes they run along), normals, triangles.

    Four vertices for each face, in the order +x, -x, +y, -y, +z, -z.
    """
    vertices, axes, normals = [], [], []
    for axis in range(3):
        for sign in (1.0, -1.0):
            normal = np.zeros(3)
            normal[axis] = sign
            u, v = face_axes(normal)
            vertices += [
                normal / 2 + (s - 0.5) * u + (t - 0.5) * v
                for s, t in ((0, 0), (1, 0), (1, 1), (0, 1))
            ]
            axes += [
                (s, t, int(np.argmax(np.abs(u))), int(np.argmax(np.abs(v))))
                for s, t in ((0, 0), (1, 0), (1, 1), (0, 1))
            ]
            normals += [normal] * 4
    quad = np.array([(0, 1, 2), (0, 2, 3)], dtype=np.int32)
    triangles = np.concatenate([quad + 4 * face for face in range(6)])
    return np.array(vertices), np.array(axes), np.array(normals), triangles


def box_texture_m(axes: np.ndarray, size_m: np.ndarray) -> np.ndarray:
    """Return a box's texture coordinates in metres.

    Args:
        axes: Texture corners of `unit_box`.
        size_m: Size of the box along its axes.
    """
    size = np.asarray(size_m)
    return np.stack([axes[:, 0] * size[axes[:, 2]], axes[:, 1] * size[axes[:, 3]]], axis=1)


def _sphere_points(polar: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    radius = np.sin(polar)[:, None]
    x, y, z = np.broadcast_arrays(
        radius * np.cos(azimuth), radius * np.sin(azimuth), np.cos(polar)[:, None]
    )
    return np.stack([x, y, z], axis=2)


@functools.cache
def _unit_sphere(slices: int, stacks: int) -> Surface:
    azimuth = np.arange(slices + 1) * (2 * math.pi / slices)
    polar = np.arange(stacks + 1) * (math.pi / stacks)
    points = _sphere_points(polar, azimuth)
    texture = np.stack(np.broadcast_arrays(azimuth, -polar[:, None]), axis=2)
    return _grid(points, points, texture)


@functools.cache
def _unit_cylinder(slices: int) -> Surface:
    """Cylinder of radius 1 and length 1: the side, then the top, then the bottom."""
    azimuth = np.arange(slices + 1) * (2 * math.pi / slices)
    circle = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros_like(azimuth)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    side = _grid(
        np.stack([circle + up / 2, circle - up / 2]),
        np.stack([circle, circle]),
        np.stack(np.broadcast_arrays(azimuth, np.array([[1.0], [0.0]])), axis=2),
    )
    n = slices + 1
    fan = np.array([(0, i, i + 1) for i in range(1, slices - 1)], dtype=np.int32)
    return Surface(
        np.concatenate([side.vertices_m, circle + up / 2, circle - up / 2]),
        np.concatenate([side.normals, np.tile(up, (n, 1)), np.tile(-up, (n, 1))]),
        np.concatenate([side.texture_m, circle[:, :2], circle[:, :2]]),
        # The bottom's triangles are reversed: it is seen from below.
        np.concatenate([side.triangles, fan + 2 * n, fan[:, ::-1] + 3 * n]),
    )
