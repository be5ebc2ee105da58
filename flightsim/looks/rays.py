"""Ray casting against many triangles, by Embree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from autonomy.jit import kernel_without_lock
from flightsim.looks.embree import (
    COHERENT,
    HIT_MESH,
    HIT_TRIANGLE,
    HIT_U,
    HIT_V,
    LANES,
    NO_MESH,
    RAY_DIRECTION,
    RAY_FAR,
    RAY_ORIGIN,
    TriangleScene,
    call_rtc_packet,
    functions,
    new_arguments,
    new_packet,
    new_valid,
)

NOTHING = -1


@dataclass(frozen=True, eq=False)
class RayHits:
    """First hit of each ray."""

    triangle: Int[np.ndarray, " n"]
    """Index of the triangle, or `NOTHING`."""
    distance: Float[np.ndarray, " n"]
    """Distance in lengths of the ray's direction; inf without a hit."""
    u: Float[np.ndarray, " n"]
    """Barycentric weight of the triangle's second corner at the hit."""
    v: Float[np.ndarray, " n"]
    """Barycentric weight of its third corner."""

    def within(self, far: float | Float[np.ndarray, " n"]) -> RayHits:
        """Return the hits within a distance, or within one for each; the others become misses."""
        is_far = self.distance > far
        triangle = np.where(is_far, NOTHING, self.triangle)
        return RayHits(triangle, np.where(is_far, np.inf, self.distance), self.u, self.v)


class RayScene:
    """Triangles (t, 3, 3) in m, prepared for rays.

    Rays from one point that point nearly alike, such as those of an image, cost least. The
    interpreter's lock is free meanwhile, and several threads may ask at once.
    """

    def __init__(self, triangles_m: np.ndarray) -> None:
        self._scene = TriangleScene(triangles_m) if len(triangles_m) else None

    @property
    def address(self) -> int:
        """Address of the scene in Embree's memory, for kernels; 0 without triangles."""
        return 0 if self._scene is None else self._scene.address

    def is_hidden(self, origins_m: np.ndarray, directions: np.ndarray) -> Bool[np.ndarray, " n"]:
        """Return for each ray whether it hits anything; for the arguments see `first_hits`."""
        if self._scene is None:
            return np.zeros(len(directions), dtype=bool)
        numbers, _ = self._cast(functions().occluded, origins_m, directions)
        # Embree marks a hidden ray by a negative distance.
        return numbers[0] < 0.0

    def first_hits(self, origins_m: np.ndarray, directions: np.ndarray) -> RayHits:
        """Return the first hit of each ray.

        Args:
            origins_m: Origin of each ray (n, 3), or one for all rays of an image (3,).
            directions: Directions of the rays (n, 3), of any length.
        """
        if self._scene is None:
            n = len(directions)
            empty = np.zeros(n, dtype=np.float32)
            return RayHits(np.full(n, NOTHING), np.full(n, np.inf), empty, empty)
        (distance, u, v), triangle = self._cast(functions().intersect, origins_m, directions)
        return RayHits(triangle, distance, u, v)

    def _cast(
        self, query: int, origins_m: np.ndarray, directions: np.ndarray
    ) -> tuple[Float[np.ndarray, "3 n"], Int[np.ndarray, " n"]]:
        """Return distance, u and v of each ray, and its triangle."""
        n = len(directions)
        numbers, triangle = np.empty((3, n), np.float32), np.empty(n, np.int32)
        cast_packets(
            query,
            self.address,
            np.ascontiguousarray(np.atleast_2d(origins_m), dtype=np.float32),
            np.ascontiguousarray(directions, dtype=np.float32),
            COHERENT if origins_m.ndim == 1 else 0,
            numbers,
            triangle,
        )
        return numbers, triangle


@kernel_without_lock
def cast_packets(
    query: int,
    scene: int,
    origins_m: np.ndarray,
    directions: np.ndarray,
    flags: int,
    numbers: np.ndarray,
    triangle: np.ndarray,
) -> None:
    """Cast rays by packets.

    Args:
        query: Address of Embree's function.
        scene: Address of the scene.
        origins_m: Origins of the rays (n, 3), or one for all (1, 3), float32.
        directions: Their directions (n, 3), float32.
        flags: `COHERENT` or 0.
        numbers: Written: distance, infinite without a hit, and two weights of corners (3, n).
        triangle: Written: the triangle that was hit, or `NOTHING` (n,).
    """
    packet, valid, arguments = new_packet(), new_valid(), new_arguments(flags)
    as_integers = packet.view(np.int32)
    places = valid.ctypes.data, packet.ctypes.data, arguments.ctypes.data
    # 0 takes the only origin for all rays.
    step = len(origins_m) > 1
    for first in range(0, len(directions), LANES):
        n = min(LANES, len(directions) - first)
        for k in range(n):
            valid[k] = -1
            origin = origins_m[(first + k) * step]
            for axis in range(3):
                packet[RAY_ORIGIN + axis, k] = origin[axis]
                packet[RAY_DIRECTION + axis, k] = directions[first + k, axis]
            # The last packet may be smaller: its spare lanes are switched off below.
            packet[RAY_FAR, k] = np.inf
            as_integers[HIT_MESH, k] = NO_MESH
            as_integers[HIT_TRIANGLE, k] = NOTHING
        valid[n:] = 0
        call_rtc_packet(query, places[0], scene, places[1], places[2])
        for k in range(n):
            numbers[0, first + k] = packet[RAY_FAR, k]
            numbers[1, first + k] = packet[HIT_U, k]
            numbers[2, first + k] = packet[HIT_V, k]
            triangle[first + k] = as_integers[HIT_TRIANGLE, k]
