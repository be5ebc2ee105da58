"""Triangles of a MuJoCo model's geoms, in the tessellation that the model requests."""

from __future__ import annotations

import mujoco
import numpy as np
from jaxtyping import Float

from flightsim.looks.tessellation import box, capsule, cylinder, ellipsoid

Triangles = Float[np.ndarray, "n 3 3"]

# Half size of MuJoCo's infinite plane, in multiples of the scene's extent.
_PLANE_HALF_EXTENTS = 12.0


class ShapeError(ValueError):
    """A geom has a type that worlds do not use."""


def geom_triangles(model: mujoco.MjModel, geom_id: int) -> Triangles:
    """Return the triangles of one geom in its own frame, corners counter-clockwise from outside, m.

    Args:
        model: The model; its visual quality sets the sides of round shapes.
        geom_id: The geom.

    Raises:
        ShapeError: If the geom has no triangles.
    """
    kind = mujoco.mjtGeom(int(model.geom_type[geom_id]))
    size = model.geom_size[geom_id]
    slices, stacks = int(model.vis.quality.numslices), int(model.vis.quality.numstacks)
    if kind == mujoco.mjtGeom.mjGEOM_PLANE:
        return _plane(size, _PLANE_HALF_EXTENTS * float(model.stat.extent))
    # MuJoCo's sizes are half extents.
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return box(2 * size).corners_m()
    if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
        return ellipsoid(2 * size, slices, stacks).corners_m()
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return cylinder(float(size[0]), 2 * float(size[1]), slices).corners_m()
    if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        return capsule(float(size[0]), float(size[1]), slices, stacks).corners_m()
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        return _mesh(model, int(model.geom_dataid[geom_id]))
    if kind == mujoco.mjtGeom.mjGEOM_HFIELD:
        return _height_field(model, int(model.geom_dataid[geom_id]))
    raise ShapeError(
        f"geom {geom_id} is a {kind.name}; "
        "valid: plane, box, ellipsoid, cylinder, capsule, mesh, height field"
    )


def _plane(size: np.ndarray, endless_m: float) -> Triangles:
    # A size of 0 means an infinite plane.
    x, y = (float(s) if s > 0 else endless_m for s in size[:2])
    corners = np.array([(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)])
    return corners[np.array([(0, 1, 2), (0, 2, 3)])]


def _mesh(model: mujoco.MjModel, mesh_id: int) -> Triangles:
    first_vertex, first_face = model.mesh_vertadr[mesh_id], model.mesh_faceadr[mesh_id]
    faces = model.mesh_face[first_face : first_face + model.mesh_facenum[mesh_id]]
    return model.mesh_vert[first_vertex + faces].astype(float)


def _height_field(model: mujoco.MjModel, number: int) -> Triangles:
    """The upper surface; the common edge of a cell's triangles is that of the contacts."""
    n_rows, n_columns = int(model.hfield_nrow[number]), int(model.hfield_ncol[number])
    half_x, half_y, most_m, _ = model.hfield_size[number].tolist()
    data = model.hfield_data[model.hfield_adr[number] :][: n_rows * n_columns]
    x, y = np.meshgrid(
        np.linspace(-half_x, half_x, n_columns), np.linspace(-half_y, half_y, n_rows)
    )
    nodes = np.stack([x, y, most_m * data.reshape(n_rows, n_columns).astype(float)], axis=-1)
    a, b, c, d = nodes[:-1, :-1], nodes[:-1, 1:], nodes[1:, 1:], nodes[1:, :-1]
    both = np.stack([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)], axis=2)
    return both.reshape(-1, 3, 3)
