"""Ground of a scene with a relief: grass on its grid, and fields beyond it up to the far plane.

The triangles are those of the physics, see `aeroscene.scene.relief`.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from aeroscene.scene import Relief
from flightsim.looks.mesh import MeshBuilder
from flightsim.looks.paint import Paint, material_paint
from flightsim.looks.sky import FAR_LAND_RGB
from flightsim.looks.tessellation import Surface

_FIELD_M = 40.0
"""Width of a field along the border of the grid."""
_HAZE_M = 500.0
_N_HAZES = 4
"""Number of shades of haze: few keep the number of skins low."""


def add_relief(
    builder: MeshBuilder,
    relief: Relief,
    grass: str,
    fields: tuple[Paint, ...],
    outward_m: Float[np.ndarray, " k"],
    rng: np.random.Generator,
) -> None:
    """Add the ground of a scene with a relief.

    Args:
        builder: Receives the surfaces.
        relief: The relief.
        grass: Material of the grid.
        fields: Paints of fields.
        outward_m: Distances from the grid at which fields end, ascending.
        rng: Chooses the paint of each field.
    """
    lines = [_lines(relief, axis, outward_m) for axis in (1, 0)]
    vertices = _vertices(relief, lines)
    normals = _normals(vertices)
    paints = _paints(lines, len(outward_m), grass, fields, rng)
    cells = np.array([builder.paint(paint) for paint in paints.ravel()]).reshape(paints.shape)
    palette = {builder.paint(paint): paint for paint in paints.ravel()}
    for number, paint in palette.items():
        corners = _triangles(cells == number, vertices.shape[1])
        used, renumbered = np.unique(corners, return_inverse=True)
        points = vertices.reshape(-1, 3)[used]
        surface = Surface(
            points,
            normals.reshape(-1, 3)[used],
            points[:, :2],
            renumbered.reshape(-1, 3).astype(np.int32),
        )
        builder.add_surface(surface, paint, is_flat=False)


def relief_surface(relief: Relief, beyond_m: float) -> Surface:
    """Return the ground as one surface, up to a distance beyond the grid.

    Args:
        relief: Heights of the ground.
        beyond_m: Distance by which the border's heights continue outwards; 0 ends at the grid.
    """
    outward_m = np.array([beyond_m]) if beyond_m > 0.0 else np.zeros(0)
    vertices = _vertices(relief, [_lines(relief, axis, outward_m) for axis in (1, 0)])
    points = vertices.reshape(-1, 3)
    is_cell = np.ones((vertices.shape[0] - 1, vertices.shape[1] - 1), dtype=bool)
    triangles = _triangles(is_cell, vertices.shape[1]).astype(np.int32)
    return Surface(points, _normals(vertices).reshape(-1, 3), points[:, :2], triangles)


def _vertices(relief: Relief, lines: list[np.ndarray]) -> Float[np.ndarray, "r c 3"]:
    x, y = np.meshgrid(*lines)
    return np.stack([x, y, relief.height_m(x, y)], axis=-1)


def _lines(relief: Relief, axis: int, outward_m: np.ndarray) -> Float[np.ndarray, " n"]:
    """Coordinates of the nodes along an axis (1 is east, 0 is north), and of the fields' ends."""
    nodes = relief.origin_enu_m[1 - axis] + relief.spacing_m * np.arange(
        relief.heights_m.shape[axis]
    )
    return np.concatenate([nodes[0] - outward_m[::-1], nodes, nodes[-1] + outward_m])


def _normals(vertices: Float[np.ndarray, "r c 3"]) -> Float[np.ndarray, "r c 3"]:
    """Upward unit normals of the nodes, by the slopes between their neighbours."""
    x, y, z = vertices[0, :, 0], vertices[:, 0, 1], vertices[..., 2]
    north, east = np.gradient(z, y, x)
    normals = np.stack([-east, -north, np.ones_like(z)], axis=-1)
    return normals / np.linalg.norm(normals, axis=-1, keepdims=True)


def _paints(
    lines: list[np.ndarray],
    n_out: int,
    grass: str,
    fields: tuple[Paint, ...],
    rng: np.random.Generator,
) -> np.ndarray:
    """Paint of each cell, (rows, columns) of objects."""
    parts = [_parts(line, n_out) for line in lines]
    # A cell at a corner lies as far out as the farther of both axes.
    ring = np.maximum(parts[1][1][:, None], parts[0][1][None, :])
    choice = rng.integers(len(fields), size=(parts[1][0].max() + 1, parts[0][0].max() + 1))
    which = choice[parts[1][0][:, None], parts[0][0][None, :]]
    away_m = np.maximum(parts[1][2][:, None], parts[0][2][None, :])
    paints = np.empty(ring.shape, dtype=object)
    paints[:] = material_paint(grass)
    for number, field in enumerate(fields):
        haze = np.rint(_N_HAZES * (1.0 - np.exp(-away_m / _HAZE_M))).astype(int)
        for shade in np.unique(haze):
            paints[(ring > 0) & (which == number) & (haze == shade)] = _hazy(field, int(shade))
    return paints


def _parts(line: np.ndarray, n_out: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """For each interval of a line: its field's number, rings out of the grid, distance from it."""
    n = len(line) - 1
    index = np.arange(n)
    ring = np.maximum(np.maximum(n_out - index, index - (n - 1 - n_out)), 0)
    inner = np.floor((line[:-1] - line[n_out]) / _FIELD_M).astype(int)
    last = math.ceil((line[-1 - n_out] - line[n_out]) / _FIELD_M)
    number = np.where(ring == 0, inner, np.where(index < n_out, index, last + index - n + n_out))
    number = np.where(ring == 0, number + n_out, number + np.where(index < n_out, 0, n_out))
    middle = 0.5 * (line[:-1] + line[1:])
    away_m = np.maximum(np.maximum(line[n_out] - middle, middle - line[-1 - n_out]), 0.0)
    return number, ring, away_m


def _hazy(field: Paint, shade: int) -> Paint:
    """Return a field in haze: far ones are seen at too flat an angle for a texture."""
    if shade == 0:
        return field
    haze = shade / _N_HAZES
    red, green, blue = (
        (1 - haze) * c + haze * h for c, h in zip(field.rgb, FAR_LAND_RGB, strict=True)
    )
    return Paint(None, (red, green, blue))


def _triangles(is_wanted: np.ndarray, n_columns: int) -> np.ndarray:
    """Corners (t, 3) of the triangles of cells, counter-clockwise from above."""
    row, column = np.nonzero(is_wanted)
    south_west = row * n_columns + column
    south_east, north_west = south_west + 1, south_west + n_columns
    north_east = north_west + 1
    # The diagonal runs from south-west to north-east, as in the physics.
    lower = np.stack([south_west, south_east, north_east], axis=1)
    upper = np.stack([south_west, north_east, north_west], axis=1)
    return np.concatenate([lower, upper])
