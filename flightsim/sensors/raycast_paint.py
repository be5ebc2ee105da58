"""Textures for ray casting: the colour of a mesh where rays meet it.

A tile is kept in three sizes, the last one pixel, and a hit takes the size whose pixels are about
as large as the picture's, which is what keeps far walls from sparkling.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from flightsim.looks.mesh import WorldMesh
from flightsim.looks.paint import Paint
from flightsim.looks.rays import NOTHING, RayHits, RayScene
from flightsim.looks.textures import coarser, tile

_SHRINK = 8
_FULL_UP_TO = 2.5
_COARSE_UP_TO = 18.0
"""Pixels of the full tile that one pixel of the picture may cover in each size."""


class PaintedMesh:
    """A mesh that rays can meet and that has a colour everywhere."""

    def __init__(self, mesh: WorldMesh) -> None:
        self._scene = RayScene(mesh.corners_enu_m())
        self._mesh = mesh
        self._tiles = mesh.texture_tiles.astype(np.float32)
        pictures = [_picture(paint) for paint in mesh.paints]
        sizes = [pictures, [_shrunk(p) for p in pictures], [coarser(p, len(p)) for p in pictures]]
        flat = [picture for level in sizes for picture in level]
        counts = np.array([picture.shape[0] for picture in flat])
        starts = np.cumsum([0, *counts**2])[:-1]
        self._n_across = counts.reshape(3, -1)
        self._start = starts.reshape(3, -1)
        self._pixels = np.concatenate([picture.reshape(-1, 3) for picture in flat])
        height_m = np.array([paint.size_m[1] for paint in mesh.paints])
        self._pixel_m = height_m / self._n_across[0]

    def hits(self, eye_enu_m: np.ndarray, rays_enu: np.ndarray) -> RayHits:
        """What rays from a point meet; rays (n, 3)."""
        eyes = np.broadcast_to(eye_enu_m.astype(np.float32), rays_enu.shape)
        return self._scene.first_hits(eyes, rays_enu)

    def at_hits(
        self, hits: RayHits, values: Float[np.ndarray, "v k"]
    ) -> tuple[np.ndarray, Float[np.ndarray, "m k"]]:
        """Which rays met something, (m,), and what is given at vertices, there."""
        met = np.flatnonzero(hits.triangle != NOTHING)
        corners = self._mesh.triangles[hits.triangle[met]]
        u, v = hits.u[met, None], hits.v[met, None]
        first = values[corners[:, 0]]
        return met, first + u * (values[corners[:, 1]] - first) + v * (values[corners[:, 2]] - first)

    def rgb(self, hits: RayHits, focal_px: float) -> Float[np.ndarray, "m 3"]:
        """Colours, 0 to 1, of the surfaces at the rays that met something."""
        met, tiles = self.at_hits(hits, self._tiles)
        paint = self._mesh.triangle_paint[hits.triangle[met]]
        covered = hits.distance[met] / focal_px / self._pixel_m[paint]
        level = (covered > _FULL_UP_TO).astype(np.int32) + (covered > _COARSE_UP_TO)
        n = self._n_across[level, paint]
        column = np.minimum(((tiles[:, 0] % 1.0) * n).astype(np.int32), n - 1)
        # The top row comes first, and v grows upwards.
        row = np.minimum((((1.0 - tiles[:, 1]) % 1.0) * n).astype(np.int32), n - 1)
        return self._pixels[self._start[level, paint] + row * n + column].astype(np.float32) / 255


def _picture(paint: Paint) -> np.ndarray:
    if paint.texture is None:
        return np.array(255 * np.array(paint.rgb) + 0.5, dtype=np.uint8).reshape(1, 1, 3)
    return tile(paint.texture, paint.rgb)


def _shrunk(picture: np.ndarray) -> np.ndarray:
    return coarser(picture, _SHRINK) if len(picture) > 1 else picture
