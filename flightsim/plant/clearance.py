"""Distance from a point to the nearest static solid, in compiled code, by the tree of the rays.

Free flight (`flightsim.plant.free_flight`) needs to know how far a vehicle may move before MuJoCo
must look for contacts. For that a lower bound is enough, which is far cheaper than the exact
distance to every shape. The bound is the distance to the bounding box of a geom in the geom's own
axes. It is exact for a box, and 0 inside the bounding box. Above a height field it is at least the
height times the cosine of the steepest slope.

Subtrees farther away than the nearest solid so far are skipped, so that a search visits a few dozen
of a scene's hundreds of geoms.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import kernel
from flightsim.plant.height_fields import above_field_m
from flightsim.plant.mujoco_calls import doubles, integers, table
from flightsim.plant.rays import HEIGHT_FIELD


@kernel
def clearance_m(r: np.record, f: np.record, point_enu_m: np.ndarray, most_m: float) -> float:
    """Return a lower bound of the distance to the nearest static solid, at most `most_m`.

    Args:
        r: `flightsim.plant.rays.RAYS_DTYPE`, with the tree.
        f: `flightsim.plant.free_flight.FREE_FLIGHT_DTYPE`, with the bounding boxes and contact bits
            of the geoms.
        point_enu_m: The point (3,), ENU, m.
        most_m: Greatest distance that is searched.
    """
    best_m = most_m
    # Planes have no bounding box, so the tree does not hold them.
    for geom in integers(r.endless_address, r.n_endless):
        if _is_solid(r, f, geom):
            best_m = min(best_m, _above_plane_m(r, geom, point_enu_m))
    return _clearance_of_boxes_m(r, f, point_enu_m, best_m)


@kernel
def _clearance_of_boxes_m(r: np.record, f: np.record, point: np.ndarray, best_m: float) -> float:
    """Return the smaller of a distance and the distance to the nearest solid of the tree.

    The traversal visits the child on the point's side first. It needs no stack, because it can
    decide again at each parent which child came first, as in `flightsim.plant.rays`.
    """
    n = r.n_leaves
    boxes, axes = table(r.boxes_address, 2 * n, 6), integers(r.axes_address, n)
    leaves = integers(r.leaves_address, n)
    # The tree is a heap: node k has children 2k and 2k + 1, and the nodes from n on are leaves.
    node = 1
    while True:
        if _box_m(boxes[node], point) < best_m:
            if node < n:
                node = 2 * node + _is_on_upper_side(boxes[node], axes[node], point)
                continue
            geom = int(leaves[node - n])
            if geom >= 0 and _is_solid(r, f, geom):
                best_m = min(best_m, _solid_m(r, f, geom, point))
        # Go up while this node was the second child of its parent: both are then done.
        while node > 1:
            parent = node >> 1
            if (node & 1) == _is_on_upper_side(boxes[parent], axes[parent], point):
                break
            node = parent
        if node == 1:
            return best_m
        # This was the first child: its sibling differs in the last bit.
        node ^= 1


@kernel
def _is_on_upper_side(box: np.ndarray, axis: int, point: np.ndarray) -> bool:
    return 2.0 * point[axis] > box[axis] + box[3 + axis]


@kernel
def _is_solid(r: np.record, f: np.record, geom: int) -> bool:
    """Return true if a geom can have contacts at all."""
    touching = integers(f.contype_address, r.n_geoms)[geom]
    return touching != 0 or integers(f.conaffinity_address, r.n_geoms)[geom] != 0


@kernel
def _above_plane_m(r: np.record, geom: int, point: np.ndarray) -> float:
    place, turn = doubles(r.xpos_address + 24 * geom, 3), doubles(r.xmat_address + 72 * geom, 9)
    height_m = 0.0
    for k in range(3):
        height_m += (point[k] - place[k]) * turn[3 * k + 2]
    return height_m


@kernel
def _box_m(box: np.ndarray, point: np.ndarray) -> float:
    """Return the distance to a box (6,) of least and greatest corner; 0 inside it."""
    square = 0.0
    for k in range(3):
        outside = max(box[k] - point[k], point[k] - box[3 + k], 0.0)
        square += outside * outside
    return math.sqrt(square)


@kernel
def _solid_m(r: np.record, f: np.record, geom: int, point: np.ndarray) -> float:
    """Return the distance to the bounding box of a geom in its own axes, or to a height field."""
    place, turn = doubles(r.xpos_address + 24 * geom, 3), doubles(r.xmat_address + 72 * geom, 9)
    # MuJoCo's `geom_aabb` holds the centre and the half sizes.
    around = doubles(f.aabb_address + 48 * geom, 6)
    x, y, z = point[0] - place[0], point[1] - place[1], point[2] - place[2]
    square = 0.0
    for k in range(3):
        along = x * turn[k] + y * turn[3 + k] + z * turn[6 + k]
        outside = max(abs(along - around[k]) - around[3 + k], 0.0)
        square += outside * outside
    if integers(r.type_address, r.n_geoms)[geom] == HEIGHT_FIELD:
        return max(above_field_m(r, geom, point), math.sqrt(square))
    return math.sqrt(square)
