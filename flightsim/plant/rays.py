"""Rays in MuJoCo's world from compiled code, by a tree of the static geoms.

The distance is MuJoCo's own, to the bit. The tree only excludes geoms that the ray cannot meet. A
cast therefore costs the same in a scene of 700 geoms and of 2,500, while `mj_ray` looks at each
geom. Moving geoms are tested one by one: they are few, and a tree over them would have to be
rebuilt at each step. Only height fields have rays of their own, see
`flightsim.plant.height_fields`.

Source of the walk through the tree without a stack: Hapala et al. 2011, Efficient stack-less BVH
traversal for ray tracing.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np

from autonomy.jit import fields, kernel, kernel_without_lock
from flightsim.plant.height_fields import ray_to_field_m
from flightsim.plant.mujoco_calls import (
    call_mj_ray_mesh,
    call_mju_ray_geom,
    doubles,
    functions,
    integers,
    table,
)
from flightsim.world import World
from flightsim.world.rays import RayTree

_MESH = int(mujoco.mjtGeom.mjGEOM_MESH)
HEIGHT_FIELD = int(mujoco.mjtGeom.mjGEOM_HFIELD)
_MARGIN_M = 1e-6
"""Relative and absolute margin of a geom's bounding sphere, so that rounding excludes none."""
_NEARLY_INFINITE = 1e300
"""Reciprocal of a zero direction. Infinity would not do, because infinity times zero is not a
number."""

RAYS_DTYPE = np.dtype(
    [
        *fields("ray_geom_address", "ray_mesh_address", kind="i8"),  # functions of MuJoCo
        *fields("model_address", "data_address", kind="i8"),
        *fields("type_address", "size_address", "rbound_address", "body_address", kind="i8"),
        *fields("xpos_address", "xmat_address", "n_geoms", kind="i8"),
        *fields("boxes_address", "axes_address", "leaves_address", "n_leaves", kind="i8"),
        *fields("endless_address", "n_endless", "moving_address", "n_moving", kind="i8"),
        # height fields: the number of the field of each geom, and the grid of each field
        *fields("dataid_address", "field_rows_address", "field_columns_address", kind="i8"),
        *fields("field_first_address", "field_heights_address", kind="i8"),
        *fields("field_size_address", "field_cosines_address", "n_fields", kind="i8"),
    ],
    align=True,
)
"""Addresses of a world's geoms and of their index (`flightsim.world.rays.RayTree`)."""


def new_rays(world: World, data: mujoco.MjData, tree: RayTree | None = None) -> np.ndarray:
    """Return the addresses that rays need, (1,) of `RAYS_DTYPE`.

    Args:
        world: The world; it must outlive the record.
        data: State of the physics, in which rays see the geoms; it must outlive the record.
        tree: Geoms that the rays meet; by default those of `world.rays`.
    """
    model, tree = world.model, world.rays if tree is None else tree
    records = np.zeros(1, RAYS_DTYPE)
    r = records[0]
    r["ray_geom_address"], r["ray_mesh_address"] = functions().ray_geom, functions().ray_mesh
    r["model_address"], r["data_address"] = model._address, data._address
    for name, array in (
        ("type", model.geom_type),
        ("size", model.geom_size),
        ("rbound", model.geom_rbound),
        ("body", model.geom_bodyid),
        ("xpos", data.geom_xpos),
        ("xmat", data.geom_xmat),
        ("boxes", tree.boxes_enu_m),
        ("axes", tree.axes),
        ("leaves", tree.leaf_geoms),
        ("endless", tree.endless_geoms),
        ("moving", tree.moving_geoms),
        ("dataid", model.geom_dataid),
        ("field_rows", model.hfield_nrow),
        ("field_columns", model.hfield_ncol),
        ("field_first", model.hfield_adr),
        ("field_heights", model.hfield_data),
        ("field_size", model.hfield_size),
        ("field_cosines", tree.field_cosines),
    ):
        r[f"{name}_address"] = array.ctypes.data
    r["n_geoms"], r["n_leaves"] = model.ngeom, len(tree.leaf_geoms)
    r["n_fields"] = model.nhfield
    r["n_endless"], r["n_moving"] = len(tree.endless_geoms), len(tree.moving_geoms)
    return records


@kernel_without_lock
def cast_rays(
    rays: np.ndarray, ray_enu_m: np.ndarray, excluded_body: int, distance_m: np.ndarray
) -> None:
    """Write the distances to the first solids that many rays meet.

    Args:
        rays: Record of a world's index (`new_rays`).
        ray_enu_m: Origin and direction of each ray, (n, 6).
        excluded_body: Body that no ray meets, such as the vehicle's own; -1 for none.
        distance_m: Takes the distances (n,), in lengths of the directions; infinite for none.
    """
    for i in range(len(ray_enu_m)):
        hit_m = _first_hit_m(rays[0], ray_enu_m[i], excluded_body)
        distance_m[i] = hit_m


@kernel
def cast_ray_m(e: np.record, s: np.record) -> float:
    """Return the distance to the first solid along a ray, without the vehicle; negative for none.

    Args:
        e: Engine of the plant.
        s: Record with `ray`, origin and direction ENU (6,), m.
    """
    distance_m = _first_hit_m(e.rays, s.ray, e.vehicle_body)
    return -1.0 if math.isinf(distance_m) else distance_m


@kernel
def _first_hit_m(r: np.record, ray: np.ndarray, excluded_body: int) -> float:
    """Return the distance to what a ray (6,) meets first; infinite for nothing."""
    best_m = math.inf
    for geom in integers(r.endless_address, r.n_endless):
        best_m = _nearer(best_m, geom_m(r, geom, ray))
    # Planes come first, because a hit on the ground cuts the search of the tree short.
    best_m = _first_standing_m(r, ray, best_m)
    body = integers(r.body_address, r.n_geoms)
    for geom in integers(r.moving_address, r.n_moving):
        if body[geom] != excluded_body and _is_near_line(r, geom, ray):
            best_m = _nearer(best_m, geom_m(r, geom, ray))
    return best_m


@kernel
def _first_standing_m(r: np.record, ray: np.ndarray, best_m: float) -> float:
    """Return the smaller of a distance and the distance to the first geom of the tree."""
    n = r.n_leaves
    boxes, axes = table(r.boxes_address, 2 * n, 6), integers(r.axes_address, n)
    leaves = integers(r.leaves_address, n)
    x, y, z = ray[0], ray[1], ray[2]
    over_x, over_y, over_z = _over(ray[3]), _over(ray[4]), _over(ray[5])
    # Columns of the boxes with the face of each pair that the ray meets first.
    first_x, first_y, first_z = 3 * (over_x < 0), 1 + 3 * (over_y < 0), 2 + 3 * (over_z < 0)
    last_x, last_y, last_z = 3 - first_x, 5 - first_y, 7 - first_z
    node = 1
    while True:
        box = boxes[node]
        enter_m = max((box[first_x] - x) * over_x, (box[first_y] - y) * over_y)
        enter_m = max(enter_m, (box[first_z] - z) * over_z)
        leave_m = min((box[last_x] - x) * over_x, (box[last_y] - y) * over_y)
        leave_m = min(leave_m, (box[last_z] - z) * over_z)
        if enter_m <= leave_m and leave_m >= 0.0 and enter_m <= best_m:
            if node < n:
                node = 2 * node + (ray[3 + axes[node]] < 0.0)
                continue
            best_m = _nearer(best_m, geom_m(r, int(leaves[node - n]), ray))
        # Go up while this node was the far child of its parent: both are then done.
        while node > 1 and (node & 1) != (ray[3 + axes[node >> 1]] < 0.0):
            node >>= 1
        if node == 1:
            return best_m
        # This was the near child: its sibling differs in the last bit.
        node ^= 1


@kernel
def _over(direction: float) -> float:
    return 1.0 / direction if direction != 0.0 else _NEARLY_INFINITE


@kernel
def _nearer(best_m: float, distance_m: float) -> float:
    """Return the smaller distance; a negative one means that nothing was hit."""
    return distance_m if 0.0 <= distance_m < best_m else best_m


@kernel
def _is_near_line(r: np.record, geom: int, ray: np.ndarray) -> bool:
    """Return true if a ray may meet the bounding sphere of a geom."""
    radius_m = doubles(r.rbound_address, r.n_geoms)[geom]
    centre = doubles(r.xpos_address + 24 * geom, 3)
    away_2 = along = length_2 = 0.0
    for k in range(3):
        away = centre[k] - ray[k]
        away_2 += away * away
        along += away * ray[3 + k]
        length_2 += ray[3 + k] * ray[3 + k]
    reach_m = radius_m + _MARGIN_M * (1.0 + math.sqrt(away_2))
    # The ray begins inside the sphere.
    if away_2 <= reach_m * reach_m:
        return True
    return along > 0.0 and away_2 - along * along / length_2 <= reach_m * reach_m


@kernel
def geom_m(r: np.record, geom: int, ray: np.ndarray) -> float:
    """Return the distance to one geom along a ray.

    Args:
        r: Record of a world's index.
        geom: Number of the geom.
        ray: Origin and direction, (6,).

    Returns:
        The distance in lengths of the direction; negative if the ray does not meet it.
    """
    origin, direction = ray.ctypes.data, ray[3:].ctypes.data
    kind = integers(r.type_address, r.n_geoms)[geom]
    if kind == HEIGHT_FIELD:
        return ray_to_field_m(r, geom, ray)
    if kind == _MESH:
        return call_mj_ray_mesh(
            r.ray_mesh_address, r.model_address, r.data_address, geom, origin, direction
        )
    # Three doubles a position or size, nine a rotation matrix: 24 and 72 bytes.
    return call_mju_ray_geom(
        r.ray_geom_address,
        r.xpos_address + 24 * geom,
        r.xmat_address + 72 * geom,
        r.size_address + 24 * geom,
        origin,
        direction,
        kind,
    )
