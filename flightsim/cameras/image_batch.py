"""Depth of many cameras in one call: static solids by Embree, moving geoms by MuJoCo's own rays.

Each world has static solids, as triangles, and geoms that move, whose poses the engine knows. Only
pixels within the outline of the sphere around a moving geom are tested against it, because MuJoCo's
rays cost much more than Embree's.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import fields, kernel, kernel_without_lock
from flightsim.looks.embree import (
    COHERENT,
    HIT_MESH,
    HIT_TRIANGLE,
    LANES,
    NO_MESH,
    RAY_DIRECTION,
    RAY_FAR,
    RAY_ORIGIN,
    call_rtc_packet,
    new_arguments,
    new_packet,
    new_valid,
)
from flightsim.looks.rays import NOTHING
from flightsim.plant.mujoco_calls import doubles, integers, take_number
from flightsim.plant.rays import RAYS_DTYPE, geom_m

FIRST_GEOM = -2
"""Number of the moving geom 0 among hits; geom g is `FIRST_GEOM - g`."""
_MARGIN_PX = 1e-3
"""Margin by which outlines are larger: rounding may lose no pixel."""

VIEW_DTYPE = np.dtype(
    [
        *fields("position_enu_m", shape=(3,)),
        *fields("rotation_enu_from_optical", shape=(3, 3)),
        *fields("focal_px", "far_m"),
        # `RayScene.address` of what stands, and the body that the camera does not see.
        *fields("scene_address", "own_body", kind="i8"),
    ],
    align=True,
)
"""A camera: its pose, its limits, and its world."""


@kernel_without_lock
def cast_images(
    query: int,
    counter: np.ndarray,
    views: np.ndarray,
    rays: np.ndarray,
    depth_m: np.ndarray,
    hits: np.ndarray,
) -> None:
    """Cast the images of many cameras.

    Several threads may call this with the same arrays at the same time: each takes the next image
    that is free, and no image depends on the thread that casts it.

    Args:
        query: `flightsim.looks.embree.Functions.intersect`.
        counter: Number of images that are taken (1,), int64; 0 before the call.
        views: `VIEW_DTYPE` (n,).
        rays: `flightsim.plant.rays.RAYS_DTYPE` (n,), for moving geoms; zeros for worlds without
            any.
        depth_m: Written: depth along the axis, at most `far_m` (n, h, w), float32.
        hits: Written: triangle, moving geom from `FIRST_GEOM` down, or `NOTHING` (n, h, w), int32.
    """
    packet, valid, arguments = new_packet(), new_valid(), new_arguments(COHERENT)
    while True:
        # Taken by an atomic addition: two threads never get the same number.
        i = take_number(counter)
        if i >= len(views):
            break
        if views[i].scene_address == 0:
            depth_m[i], hits[i] = views[i].far_m, NOTHING
        else:
            _cast_standing(query, views[i], packet, valid, arguments, depth_m[i], hits[i])
        _cast_moving(views[i], rays[i], depth_m[i], hits[i])


def example_arguments() -> tuple[int, *tuple[np.ndarray, ...]]:
    """Return arguments of the types that `cast_images` takes, for compiling it ahead."""
    image = (1, 1, 1)
    return (
        *(0, np.zeros(1, np.int64), np.zeros(1, VIEW_DTYPE), np.zeros(1, RAYS_DTYPE)),
        *(np.zeros(image, np.float32), np.zeros(image, np.int32)),
    )


@kernel
def _cast_standing(
    query: int,
    view: np.record,
    packet: np.ndarray,
    valid: np.ndarray,
    arguments: np.ndarray,
    depth_m: np.ndarray,
    hits: np.ndarray,
) -> None:
    as_integers = packet.view(np.int32)
    height, width = depth_m.shape
    # Origins are the same for all packets of an image and are written once.
    for axis in range(3):
        packet[RAY_ORIGIN + axis] = view.position_enu_m[axis]
    for row in range(height):
        for first in range(0, width, LANES):
            n = min(LANES, width - first)
            valid[:n], valid[n:] = -1, 0
            for k in range(n):
                ray = _ray_enu(view, row, first + k, height, width)
                for axis in range(3):
                    packet[RAY_DIRECTION + axis, k] = ray[axis]
            packet[RAY_FAR] = view.far_m
            as_integers[HIT_MESH], as_integers[HIT_TRIANGLE] = NO_MESH, NOTHING
            call_rtc_packet(
                query,
                valid.ctypes.data,
                view.scene_address,
                packet.ctypes.data,
                arguments.ctypes.data,
            )
            depth_m[row, first : first + n] = packet[RAY_FAR, :n]
            hits[row, first : first + n] = as_integers[HIT_TRIANGLE, :n]


@kernel
def _cast_moving(view: np.record, r: np.record, depth_m: np.ndarray, hits: np.ndarray) -> None:
    """Draw moving geoms over an image."""
    body, ray = integers(r.body_address, r.n_geoms), np.empty(6)
    ray[0:3] = view.position_enu_m
    height, width = depth_m.shape
    for geom in integers(r.moving_address, r.n_moving):
        if body[geom] == view.own_body:
            continue
        top, bottom, left, right = _outline(view, r, geom, height, width)
        for row in range(top, bottom):
            for column in range(left, right):
                for axis, along in enumerate(_ray_enu(view, row, column, height, width)):
                    ray[3 + axis] = along
                distance = geom_m(r, geom, ray)
                if 0.0 <= distance < depth_m[row, column]:
                    depth_m[row, column], hits[row, column] = distance, FIRST_GEOM - geom


@kernel
def _ray_enu(
    view: np.record, row: int, column: int, height: int, width: int
) -> tuple[float, float, float]:
    """Direction of a pixel in the world, one metre deep."""
    turn = view.rotation_enu_from_optical
    x = (column - 0.5 * (width - 1)) / view.focal_px
    y = (row - 0.5 * (height - 1)) / view.focal_px
    return (
        # In the order of `Viewpoint.rays_enu`, so that both round alike.
        x * turn[0, 0] + (y * turn[0, 1] + turn[0, 2]),
        x * turn[1, 0] + (y * turn[1, 1] + turn[1, 2]),
        x * turn[2, 0] + (y * turn[2, 1] + turn[2, 2]),
    )


@kernel
def _outline(
    view: np.record, r: np.record, geom: int, height: int, width: int
) -> tuple[int, int, int, int]:
    """First row and the one after the last, and likewise columns, of the sphere around a geom."""
    radius_m = doubles(r.rbound_address, r.n_geoms)[geom]
    centre = doubles(r.xpos_address + 24 * geom, 3)  # 24 bytes: three doubles a geom
    right = down = forward = 0.0
    for axis in range(3):
        away = centre[axis] - view.position_enu_m[axis]
        right += away * view.rotation_enu_from_optical[axis, 0]
        down += away * view.rotation_enu_from_optical[axis, 1]
        forward += away * view.rotation_enu_from_optical[axis, 2]
    rows = _span(down, forward, radius_m, view.focal_px, height)
    columns = _span(right, forward, radius_m, view.focal_px, width)
    return rows[0], rows[1], columns[0], columns[1]


@kernel
def _span(
    across_m: float, forward_m: float, radius_m: float, focal_px: float, n: int
) -> tuple[int, int]:
    """First pixel of n across which a disc may be seen, and the one after the last."""
    distance_m = math.hypot(across_m, forward_m)
    # The eye is inside the sphere: any pixel may show the geom.
    if distance_m <= radius_m:
        return 0, n
    middle, half = math.atan2(across_m, forward_m), math.asin(radius_m / distance_m)
    first, last = middle - half, middle + half
    low, high = 0.0, n - 1.0
    # Wholly behind the camera.
    if first > 0.5 * math.pi or last < -0.5 * math.pi:
        return 0, 0
    # Beyond a right angle the tangent has no meaning: that side reaches to the border.
    if first > -0.5 * math.pi:
        low = max(low, 0.5 * (n - 1) + focal_px * math.tan(first) - _MARGIN_PX)
    if last < 0.5 * math.pi:
        high = min(high, 0.5 * (n - 1) + focal_px * math.tan(last) + _MARGIN_PX)
    return math.ceil(low), math.floor(high) + 1
