"""How far a point is from all that stands, from compiled code, by the tree that rays use.

The distance is a lower bound: to the box around a geom in the geom's own axes, which for a box is
the box, and nothing for a point within it. A subtree whose box is farther than what has been found
is left out, so that a search meets a few dozen of a scene's hundreds of geoms.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import kernel
from flightsim.plant.mujoco_calls import doubles, integers, table


@kernel
def clear_m(r: np.record, f: np.record, point_enu_m: np.ndarray, most_m: float) -> float:
    """Distance to the nearest solid that stands, at least; `most_m` where all are farther.

    Args:
        r: Record of the rays (`flightsim.plant.rays`), with the tree.
        f: Record with the addresses of what else is to be known of the geoms
            (`flightsim.plant.free_flight`).
        point_enu_m: Where (3,).
        most_m: Distance beyond which nothing is looked for.
    """
    best_m = most_m
    for geom in integers(r.endless_address, r.n_endless):
        if _is_solid(r, f, geom):
            best_m = min(best_m, _above_plane_m(r, geom, point_enu_m))
    return _clear_of_boxes_m(r, f, point_enu_m, best_m)


@kernel
def _clear_of_boxes_m(r: np.record, f: np.record, point: np.ndarray, best_m: float) -> float:
    """The lesser one of a distance and that to the nearest solid of the tree.

    The walk goes first to the child on the point's side, and finds its way back by asking the same
    again, as `flightsim.plant.rays` does.
    """
    n = r.n_leaves
    boxes, axes = table(r.boxes_address, 2 * n, 6), integers(r.axes_address, n)
    leaves = integers(r.leaves_address, n)
    node = 1
    while True:
        if _box_m(boxes[node], point) < best_m:
            if node < n:
                node = 2 * node + _is_on_upper_side(boxes[node], axes[node], point)
                continue
            geom = int(leaves[node - n])
            if geom >= 0 and _is_solid(r, f, geom):
                best_m = min(best_m, _solid_m(r, f, geom, point))
        while node > 1:
            parent = node >> 1
            if (node & 1) == _is_on_upper_side(boxes[parent], axes[parent], point):
                break
            node = parent
        if node == 1:
            return best_m
        node ^= 1


@kernel
def _is_on_upper_side(box: np.ndarray, axis: int, point: np.ndarray) -> bool:
    return 2.0 * point[axis] > box[axis] + box[3 + axis]


@kernel
def _is_solid(r: np.record, f: np.record, geom: int) -> bool:
    """Whether anything can touch a geom."""
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
    """Distance to a box (6,) of least and greatest corner; 0 within it."""
    square = 0.0
    for k in range(3):
        outside = max(box[k] - point[k], point[k] - box[3 + k], 0.0)
        square += outside * outside
    return math.sqrt(square)


@kernel
def _solid_m(r: np.record, f: np.record, geom: int, point: np.ndarray) -> float:
    """Distance to the box around a geom in its own axes."""
    place, turn = doubles(r.xpos_address + 24 * geom, 3), doubles(r.xmat_address + 72 * geom, 9)
    around = doubles(f.aabb_address + 48 * geom, 6)
    x, y, z = point[0] - place[0], point[1] - place[1], point[2] - place[2]
    square = 0.0
    for k in range(3):
        along = x * turn[k] + y * turn[3 + k] + z * turn[6 + k]
        outside = max(abs(along - around[k]) - around[3 + k], 0.0)
        square += outside * outside
    return math.sqrt(square)
