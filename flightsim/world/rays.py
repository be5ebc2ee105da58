"""Index of a world's geoms, so that a ray need be tested against a few of them only.

A ray of `mujoco.mj_ray` looks at every geom, and a scene has hundreds. Geoms that stand still are
therefore sorted once into a binary tree of boxes: each node is halved at the median along its
longest side. Numbers follow a heap: node 1 is the root, node i has the children 2 i and 2 i + 1,
and the last n are the leaves. A ray that misses a box skips all below it. `flightsim.plant.rays`
casts the rays, and asks MuJoCo about each geom that is left.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from jaxtyping import Bool, Float, Int32

_MARGIN_M = 1e-6
"""Length by which boxes are larger than their geoms, so that rounding loses no hit."""
_UNSUPPORTED = (mujoco.mjtGeom.mjGEOM_SDF,)  # their surface is no shape that a box is known for


class RayTreeError(ValueError):
    """A world has a geom that no ray can be cast at."""


@dataclass(frozen=True, eq=False)
class RayTree:
    """Geoms that rays meet, sorted by place; n, the number of leaves, is a power of two.

    Invisible geoms are left out of it, as `mujoco.mj_ray` does.
    """

    boxes_enu_m: Float[np.ndarray, "2*n 6"]
    """Box of each node, least and greatest corner; an empty node's least corner is infinite."""
    axes: Int32[np.ndarray, " n"]
    """Axis along which the children of each inner node lie, the first one lower."""
    leaf_geoms: Int32[np.ndarray, " n"]
    """Geom of each leaf, -1 in an empty one."""
    endless_geoms: Int32[np.ndarray, " e"]
    """Planes, which no box holds."""
    moving_geoms: Int32[np.ndarray, " m"]
    """Geoms of bodies other than the world, which have no lasting place."""
    field_cosines: Float[np.ndarray, " h"]
    """Cosine of the steepest slope of each height field, for bounds on the distance to it.
    """

    @classmethod
    def from_model(
        cls, model: mujoco.MjModel, left_out: Bool[np.ndarray, " ngeom"] | None = None
    ) -> RayTree:
        """Index the geoms of a model.

        Args:
            model: Compiled model with the geoms at their places.
            left_out: True for each geom that no ray shall meet; by default there is none.

        Returns:
            The index; it stays valid as long as the geoms of the world body stay.

        Raises:
            RayTreeError: If a geom is a signed distance field.
        """
        is_met = _is_visible(model) if left_out is None else _is_visible(model) & ~left_out
        geoms = np.flatnonzero(is_met).astype(np.int32)
        for geom in geoms[np.isin(model.geom_type[geoms], _UNSUPPORTED)].tolist():
            kind = mujoco.mjtGeom(model.geom_type[geom]).name
            raise RayTreeError(
                f"geom {geom} is a {kind}; valid: planes, primitives, meshes and height fields"
            )
        is_static = model.geom_bodyid[geoms] == 0
        is_endless = model.geom_type[geoms] == mujoco.mjtGeom.mjGEOM_PLANE
        boxed = geoms[is_static & ~is_endless]
        low, high = _boxes_enu_m(model, boxed)
        order, axes = _halve(0.5 * (low + high))
        leaf_geoms = np.where(order < len(boxed), np.append(boxed, -1)[order], -1)
        return cls(
            boxes_enu_m=_nodes(low, high, order),
            axes=axes,
            leaf_geoms=leaf_geoms.astype(np.int32),
            endless_geoms=geoms[is_static & is_endless],
            moving_geoms=geoms[~is_static],
            field_cosines=np.array([_cosine(model, i) for i in range(model.nhfield)]),
        )


def _cosine(model: mujoco.MjModel, number: int) -> float:
    """Return the cosine of the steepest slope of a height field.

    Args:
        model: Model with the field.
        number: Number of the field in the model.
    """
    first, shape = model.hfield_adr[number], (model.hfield_nrow[number], model.hfield_ncol[number])
    half_x, half_y, most_m, _ = model.hfield_size[number]
    # MuJoCo keeps the heights as fractions of the greatest one.
    heights = most_m * model.hfield_data[first:][: shape[0] * shape[1]].reshape(shape).astype(float)
    east = np.diff(heights, axis=1) * (shape[1] - 1) / (2.0 * half_x)
    north = np.diff(heights, axis=0) * (shape[0] - 1) / (2.0 * half_y)
    # Each cell is two triangles, and each of these slopes as one pair of the cell's edges.
    slopes = (np.hypot(east[:-1], north[:, :-1]), np.hypot(east[1:], north[:, 1:]))
    # Data of 32 bits: rounding may have made the field this much steeper.
    return 1.0 / np.sqrt(1.0 + (1.0001 * max(slope.max() for slope in slopes)) ** 2)


def _is_visible(model: mujoco.MjModel) -> np.ndarray:
    # A material's colour stands for the geom's own.
    alpha = model.geom_rgba[:, 3].copy()
    has_material = model.geom_matid >= 0
    alpha[has_material] = model.mat_rgba[model.geom_matid[has_material], 3]
    return alpha != 0.0


def _boxes_enu_m(model: mujoco.MjModel, geoms: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the least and greatest corners (k, 3) of geoms of the world body."""
    rotation = np.empty((len(geoms), 9))
    for row, quat in zip(rotation, model.geom_quat[geoms], strict=True):
        mujoco.mju_quat2Mat(row, quat)
    rotation = rotation.reshape(-1, 3, 3)
    centre, half = model.geom_aabb[geoms, :3], model.geom_aabb[geoms, 3:]
    middle = model.geom_pos[geoms] + (rotation @ centre[..., None])[..., 0]
    # Half lengths of the upright box around a turned one.
    reach = (np.abs(rotation) @ half[..., None])[..., 0] + _MARGIN_M
    return middle - reach, middle + reach


def _halve(middle_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sort points into a balanced tree by halving at the median.

    Args:
        middle_m: Middles of k boxes, (k, 3).

    Returns:
        Number of the point in each of the n leaves, k in those that have none; and the axis of each
        inner node, (n,) both.
    """
    k = len(middle_m)
    n = 1 << max(k - 1, 0).bit_length()
    # Empty places are at infinity, so they gather behind all points.
    points = np.full((n, 3), np.inf)
    points[:k] = middle_m
    order, axes = np.arange(n), np.zeros(n, dtype=np.int32)
    # One round halves all nodes of a level at once.
    n_nodes = 1
    while n_nodes < n:
        inside = points[order].reshape(n_nodes, -1, 3)
        is_point = np.isfinite(inside)
        widest = np.where(is_point, inside, -np.inf).max(1)
        widest -= np.where(is_point, inside, np.inf).min(1)
        axis = widest.argmax(1)
        axes[n_nodes : 2 * n_nodes] = axis
        along = np.take_along_axis(inside, axis[:, None, None], axis=2)[..., 0]
        # Equal middles keep their order, so the tree is always the same.
        sorting = np.argsort(along, axis=1, kind="stable")
        order = np.take_along_axis(order.reshape(n_nodes, -1), sorting, axis=1).ravel()
        n_nodes *= 2
    return np.minimum(order, k), axes


def _nodes(low: np.ndarray, high: np.ndarray, order: np.ndarray) -> np.ndarray:
    """Return the boxes of all nodes (2 n, 6) from those of the geoms.

    Args:
        low: Least corners of the geoms, (k, 3).
        high: Greatest corners.
        order: Geom of each leaf, k in an empty one.
    """
    n = len(order)
    boxes = np.empty((2 * n, 6))
    boxes[n:, :3] = np.append(low, np.full((1, 3), np.inf), axis=0)[order]
    boxes[n:, 3:] = np.append(high, np.full((1, 3), -np.inf), axis=0)[order]
    while n > 1:
        pairs = boxes[n : 2 * n].reshape(-1, 2, 6)
        n //= 2
        boxes[n : 2 * n, :3] = pairs[:, :, :3].min(1)
        boxes[n : 2 * n, 3:] = pairs[:, :, 3:].max(1)
    boxes[0] = boxes[1]  # there is no node 0
    return boxes
