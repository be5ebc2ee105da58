"""Textures for ray casting: the colour of a mesh at each hit.

A tile is kept in three sizes, the last one pixel; a hit uses the size whose pixels are about as
large as the picture's, which keeps far walls from sparkling.
"""

from __future__ import annotations

import numpy as np

from flightsim.looks.light import Light
from flightsim.looks.mesh import WorldMesh
from flightsim.looks.paint import Paint
from flightsim.looks.rays import NOTHING, RayHits, RayScene
from flightsim.looks.textures import coarser, lit_tile, tile

_SHRINK = 8
_FULL_UP_TO = 2.5
_COARSE_UP_TO = 18.0
"""Largest number of full-size tile pixels that one picture pixel may cover in each size."""


class PaintedMesh:
    """Mesh with a colour everywhere, prepared for rays."""

    def __init__(self, mesh: WorldMesh, light: Light, *, is_lit: bool) -> None:
        """Prepare a mesh.

        Args:
            mesh: Mesh, whose normals contain its light if it is lit.
            light: Light of the colours.
            is_lit: Whether colours have this light; a fine picture adds its own.
        """
        self._light = light if is_lit else None
        self._scene = RayScene(mesh.corners_enu_m())
        self._paint = mesh.triangle_paint
        number = np.zeros(len(mesh.normals_enu))
        # Baked normals: the cosine to the sun is the light, see `flightsim.looks.light`.
        if is_lit:
            number = np.clip(mesh.normals_enu @ light.to_sun, 0.0, 1.0)
        at_vertices = np.column_stack([mesh.texture_tiles, number]).astype(np.float32)
        first, second, third = (at_vertices[mesh.triangles[:, k]] for k in range(3))
        # Corner and edges: a hit's values are then two products away.
        self._at_first, self._to_second, self._to_third = first, second - first, third - first
        pictures = [_picture(paint, light) for paint in mesh.paints]
        self._is_lit_within = np.array([paint.is_lit_within for paint in mesh.paints], dtype=bool)
        sizes = [pictures, [_shrunk(p) for p in pictures], [coarser(p, len(p)) for p in pictures]]
        flat = [picture for level in sizes for picture in level]
        counts = np.array([picture.shape[0] for picture in flat], dtype=np.int32)
        starts = np.cumsum([0, *counts**2], dtype=np.int32)[:-1]
        self._n_across = counts.reshape(3, -1)
        self._start = starts.reshape(3, -1)
        pixels = np.concatenate([picture.reshape(-1, 3) for picture in flat])
        self._pixels = pixels.astype(np.float32) / 255
        height_m = np.array([paint.size_m[1] for paint in mesh.paints])
        self._pixel_m = (height_m / self._n_across[0]).astype(np.float32)

    def hits(self, eye_enu_m: np.ndarray, rays_enu: np.ndarray) -> RayHits:
        """Return the first hits of rays (n, 3) from one point."""
        return self._scene.first_hits(eye_enu_m, rays_enu)

    def colours(self, hits: RayHits, focal_px: float) -> tuple[np.ndarray, np.ndarray]:
        """Return which rays hit, (m,), and the colour there, 0 to 1 (m, 3).

        Args:
            hits: Hits of `hits`.
            focal_px: Focal length of the picture, which sets how much of a tile a pixel covers.
        """
        met = np.flatnonzero(hits.triangle != NOTHING)
        triangle = hits.triangle[met]
        values = self._at_first[triangle]
        values += hits.u[met, None] * self._to_second[triangle]
        values += hits.v[met, None] * self._to_third[triangle]
        u, v, number = values.T
        paint = self._paint[triangle]
        covered = hits.distance[met] / focal_px / self._pixel_m[paint]
        level = (covered > _FULL_UP_TO).astype(np.int32) + (covered > _COARSE_UP_TO)
        n = self._n_across[level, paint]
        column = ((u - np.floor(u)) * n).astype(np.int32)
        # The top row comes first, and v grows upwards.
        row = ((np.ceil(v) - v) * n).astype(np.int32)
        # Rounding may reach the first pixel of the next tile.
        np.minimum(column, n - 1, out=column)
        np.minimum(row, n - 1, out=row)
        pixel = self._start[level, paint] + row * n + column
        rgb = self._pixels[pixel]
        if self._light is not None:
            factors = self._light.rgb(number)
            factors[self._is_lit_within[paint]] = 1.0
            rgb = rgb * factors
        return met, rgb


def _picture(paint: Paint, light: Light) -> np.ndarray:
    if paint.texture is None:
        return np.array(255 * np.array(paint.rgb) + 0.5, dtype=np.uint8).reshape(1, 1, 3)
    if paint.is_lit_within:
        return lit_tile(paint.texture, paint.rgb, light.wall_rgb)
    return tile(paint.texture, paint.rgb)


def _shrunk(picture: np.ndarray) -> np.ndarray:
    return coarser(picture, _SHRINK) if len(picture) > 1 else picture
