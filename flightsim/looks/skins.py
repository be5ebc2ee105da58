"""Skins of a mesh: one for each paint and ground tile, small enough to be culled well.

One skin for a paint would be drawn whole even if a corner of it is in view; one for each solid
would mean many more draw calls.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flightsim.looks.mesh import WorldMesh
from flightsim.looks.paint import Paint

_TILE_M = 32.0
_N_ACROSS = 1 << 12  # columns of tiles, more than any world needs
_LEAST_TO_TILE = 400
"""Least number of triangles of a paint that is divided: drawing fewer costs less than dividing
them."""
_LEAST_VERTICES = 4
"""Least vertices of a skin, because MuJoCo accepts no single triangle as a mesh."""


@dataclass(frozen=True, eq=False)
class Skin:
    """Triangles with one paint."""

    paint: Paint
    vertices_enu_m: np.ndarray
    normals: np.ndarray
    texture_tiles: np.ndarray
    triangles: np.ndarray


def skins(mesh: WorldMesh) -> Iterator[Skin]:
    """Yield the skins of a mesh, in a fixed order."""
    if not len(mesh.triangles):
        return
    # The first corner keeps both triangles of a quad together.
    where = mesh.vertices_enu_m[mesh.triangles[:, 0], :2]
    column, row = (np.floor(where / _TILE_M).astype(np.int64) + _N_ACROSS // 2).T
    is_rare = np.bincount(mesh.triangle_paint)[mesh.triangle_paint] < _LEAST_TO_TILE
    tile = np.where(is_rare, 0, column * _N_ACROSS + row)
    key = mesh.triangle_paint.astype(np.int64) * _N_ACROSS**2 + tile
    order = np.argsort(key, kind="stable")
    starts = np.flatnonzero(np.diff(key[order])) + 1
    for group in np.split(order, starts):
        used, renumbered = np.unique(mesh.triangles[group], return_inverse=True)
        if len(used) < _LEAST_VERTICES:
            used = np.append(used, used[:1])
        yield Skin(
            mesh.paints[int(mesh.triangle_paint[group[0]])],
            mesh.vertices_enu_m[used],
            mesh.normals_enu[used],
            mesh.texture_tiles[used],
            renumbered.reshape(-1, 3),
        )
