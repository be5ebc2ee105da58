"""Geoms of a MuJoCo model as triangles, in the tessellation that the model asks of its renderer."""

from __future__ import annotations

import functools
import math

import mujoco
import numpy as np
from jaxtyping import Float

Triangles = Float[np.ndarray, "n 3 3"]

# MuJoCo's endless plane: this far from the middle of the scene, in multiples of its extent.
_PLANE_HALF_EXTENTS = 8.0


def geom_triangles(model: mujoco.MjModel, geom_id: int) -> Triangles:
    """Triangles of one geom in its own frame, corners counter-clockwise seen from outside, m."""
    kind = mujoco.mjtGeom(int(model.geom_type[geom_id]))
    size = model.geom_size[geom_id]
    slices, stacks = int(model.vis.quality.numslices), int(model.vis.quality.numstacks)
    if kind == mujoco.mjtGeom.mjGEOM_PLANE:
        return _plane(size, _PLANE_HALF_EXTENTS * float(model.stat.extent))
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return _unit_box() * size
    if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        return _unit_sphere(slices, stacks) * size[0]
    if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
        return _unit_sphere(slices, stacks) * size
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return _unit_cylinder(slices) * np.array([size[0], size[0], size[1]])
    if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        return _capsule(float(size[0]), float(size[1]), slices, stacks)
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        return _mesh(model, int(model.geom_dataid[geom_id]))
    raise NotImplementedError(f"geom {geom_id} is a {kind.name}, which rays do not meet yet")


def _plane(size: np.ndarray, endless_m: float) -> Triangles:
    x, y = (float(s) if s > 0 else endless_m for s in size[:2])
    corners = np.array([(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)])
    return corners[np.array([(0, 1, 2), (0, 2, 3)])]


@functools.cache
def _unit_box() -> Triangles:
    quad = np.array([(1.0, -1.0, -1.0), (1.0, 1.0, -1.0), (1.0, 1.0, 1.0), (1.0, -1.0, 1.0)])
    front = quad[np.array([(0, 1, 2), (0, 2, 3)])]
    faces = [np.roll(front, k, axis=2) for k in range(3)]
    # The opposite faces by mirroring through the centre, which turns the corners' order.
    return np.concatenate(faces + [-face[:, ::-1] for face in faces])


@functools.cache
def _unit_sphere(slices: int, stacks: int) -> Triangles:
    azimuth = np.arange(slices + 1) * (2 * math.pi / slices)
    polar = np.arange(stacks + 1) * (math.pi / stacks)
    radius = np.sin(polar)[:, None]
    return _grid_triangles(
        radius * np.cos(azimuth), radius * np.sin(azimuth), np.cos(polar)[:, None]
    )


@functools.cache
def _unit_cylinder(slices: int) -> Triangles:
    azimuth = np.arange(slices + 1) * (2 * math.pi / slices)
    # Rows from the middle of the top over its rim and the bottom's to the middle of the bottom.
    radius = np.array([0.0, 1.0, 1.0, 0.0])[:, None]
    height = np.array([1.0, 1.0, -1.0, -1.0])[:, None]
    return _grid_triangles(radius * np.cos(azimuth), radius * np.sin(azimuth), height)


def _capsule(radius_m: float, half_length_m: float, slices: int, stacks: int) -> Triangles:
    """A sphere pulled apart at its equator."""
    sphere = _unit_sphere(slices, 2 * ((stacks + 1) // 2)) * radius_m
    is_upper = sphere.mean(axis=1)[:, 2] > 0
    sphere[:, :, 2] += np.where(is_upper, half_length_m, -half_length_m)[:, None]
    azimuth = np.arange(slices + 1) * (2 * math.pi / slices)
    height = np.array([half_length_m, -half_length_m])[:, None]
    ring = np.ones((2, 1)) * radius_m
    return np.concatenate(
        [sphere, _grid_triangles(ring * np.cos(azimuth), ring * np.sin(azimuth), height)]
    )


def _grid_triangles(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> Triangles:
    """Two triangles for each cell of a grid of points, rows from top to bottom."""
    points = np.stack(np.broadcast_arrays(x, y, z), axis=2)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    cells = np.stack([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)], axis=2)
    triangles = cells.reshape(-1, 3, 3)
    edges = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    # At poles and centres one of the two has no area.
    return triangles[np.linalg.norm(edges, axis=1) > 1e-12]


def _mesh(model: mujoco.MjModel, mesh_id: int) -> Triangles:
    first_vertex, first_face = model.mesh_vertadr[mesh_id], model.mesh_faceadr[mesh_id]
    faces = model.mesh_face[first_face : first_face + model.mesh_facenum[mesh_id]]
    return model.mesh_vert[first_vertex + faces].astype(float)
