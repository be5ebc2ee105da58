"""Ray casting against many triangles, by Embree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

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

    def within(self, far: float) -> RayHits:
        """Keep only the hits nearer than a distance."""
        is_far = self.distance > far
        triangle = np.where(is_far, NOTHING, self.triangle)
        return RayHits(triangle, np.where(is_far, np.inf, self.distance), self.u, self.v)


class RayScene:
    """Triangles (t, 3, 3) in m, prepared for rays."""

    def __init__(self, triangles_m: np.ndarray) -> None:
        # Load Embree only when someone casts a ray.
        from embreex.mesh_construction import TriangleMesh  # noqa: PLC0415
        from embreex.rtcore_scene import EmbreeScene  # noqa: PLC0415

        self._scene = EmbreeScene()
        self._is_empty = not len(triangles_m)
        if not self._is_empty:
            # Kept alive: the scene refers to it.
            self._mesh = TriangleMesh(self._scene, triangles_m.astype(np.float32))

    def is_hidden(self, origins_m: np.ndarray, directions: np.ndarray) -> Bool[np.ndarray, " n"]:
        """Whether each ray hits anything."""
        if self._is_empty or not len(origins_m):
            return np.zeros(len(origins_m), dtype=bool)
        hit = self._scene.run(
            np.ascontiguousarray(origins_m, dtype=np.float32),
            np.ascontiguousarray(directions, dtype=np.float32),
            query="OCCLUDED",
        )
        return hit != NOTHING

    def first_hits(self, origins_m: np.ndarray, directions: np.ndarray) -> RayHits:
        """First hit of each ray."""
        n = len(origins_m)
        if self._is_empty or not n:
            empty = np.zeros(n, dtype=np.float32)
            return RayHits(np.full(n, NOTHING), np.full(n, np.inf), empty, empty)
        result = self._scene.run(
            np.ascontiguousarray(origins_m, dtype=np.float32),
            np.ascontiguousarray(directions, dtype=np.float32),
            query="INTERSECT",
            output=True,
        )
        triangle = result["primID"]
        distance = np.where(triangle == NOTHING, np.float32(np.inf), result["tfar"])
        return RayHits(triangle, distance, result["u"], result["v"])

    def distances(
        self, origin_m: Float[np.ndarray, 3], directions: np.ndarray, far: float
    ) -> Float[np.ndarray, " n"]:
        """Distance along each ray from one point, in lengths of its direction, at most `far`.

        The interpreter's lock is free meanwhile, and several threads may ask at once.
        """
        far_each = np.full(len(directions), far, dtype=np.float32)
        if self._is_empty:
            return far_each
        return self._scene.run(
            np.broadcast_to(origin_m.astype(np.float32), directions.shape).copy(),
            np.ascontiguousarray(directions, dtype=np.float32),
            dists=far_each,
            query="DISTANCE",
        )
