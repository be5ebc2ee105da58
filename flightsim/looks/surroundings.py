"""Ground of a scene: grass around it, and land behind hedges as far as cameras see.

Crops and bare soil begin only around scenes in the country; a town ends in meadows.

It lies in the ground of the physics: the plane z = 0, or the relief.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from aeroscene.neighbourhood import NEIGHBOURHOOD_STYLES
from aeroscene.scene import Scene
from flightsim.looks.mesh import MeshBuilder
from flightsim.looks.paint import Paint, material_paint
from flightsim.looks.relief_ground import add_relief
from flightsim.looks.sky import FAR_LAND_RGB

GROUND_MATERIAL = "grass"

_YARD_M = 26.0
"""Width of the grass around the extent."""
_STRIPS_M = (34.0, 46.0, 60.0, 85.0, 130.0, 220.0, 400.0)
"""Depths of the fields from the yard outwards; the last is repeated up to the far plane."""
_N_TEXTURED = 4
"""Number of textured rings; fields further out are seen at too flat an angle."""
_HAZE_M = 500.0
_HEDGE_M = 1.4  # width of a hedge
_FIELDS: tuple[Paint, ...] = (
    Paint("meadow", (0.40, 0.55, 0.26), (24.0, 24.0)),
    Paint("meadow", (0.52, 0.58, 0.28), (24.0, 24.0)),
    Paint("crops", (0.36, 0.50, 0.20), (14.0, 14.0)),
    Paint("crops", (0.80, 0.68, 0.36), (14.0, 14.0)),
    Paint("soil", (0.50, 0.38, 0.27), (9.0, 9.0)),
)
_N_MEADOWS = 2
"""Number of fields, from the first, that are meadows."""
_HEDGE = Paint("leaves", (0.26, 0.40, 0.19), (3.0, 3.0))
_UP = np.array([0.0, 0.0, 1.0])
_Patch = tuple[np.ndarray, Paint]
"""Four corners (4, 2) and the paint between them."""


def add_surroundings(builder: MeshBuilder, scene: Scene, reach_m: float) -> None:
    """Add the ground of a scene up to a distance from its centre.

    Args:
        builder: Receives the surfaces.
        scene: The scene; its seed chooses the fields.
        reach_m: Distance from its centre, the far plane of cameras.
    """
    rng, fields = np.random.default_rng([scene.seed, 0x6E0]), _fields(scene)
    if scene.relief is not None:
        add_relief(builder, scene.relief, GROUND_MATERIAL, fields, _outward_m(reach_m), rng)
        return
    low, high = np.array(scene.extent_min_enu_m)[:2], np.array(scene.extent_max_enu_m)[:2]
    lines = [_lines(low[k] - _YARD_M, high[k] + _YARD_M, reach_m) for k in range(2)]
    points = _jittered(rng, lines)
    n_x, n_y = points.shape[0] - 1, points.shape[1] - 1
    patches: list[_Patch] = []
    for i, j in itertools.product(range(n_x), range(n_y)):
        quad = points[[i, i + 1, i + 1, i], [j, j, j + 1, j + 1]]
        ring = max(_rings_out(i, n_x), _rings_out(j, n_y))
        if ring == 0:
            patches.append((quad, material_paint(GROUND_MATERIAL)))
        else:
            field = fields[int(rng.integers(len(fields)))]
            patches += _field(quad, field, ring, (low + high) / 2)
    corners = np.array([quad for quad, _ in patches])
    tiles = corners / np.array([paint.size_m for _, paint in patches])[:, None]
    builder.add_quads(
        np.concatenate([corners, np.zeros((*corners.shape[:2], 1))], axis=2),
        np.broadcast_to(_UP, (*corners.shape[:2], 3)),
        tiles,
        np.array([builder.paint(paint) for _, paint in patches]),
    )


def _fields(scene: Scene) -> tuple[Paint, ...]:
    manner = NEIGHBOURHOOD_STYLES.get(scene.theme)
    return _FIELDS if manner is None or manner.is_rural else _FIELDS[:_N_MEADOWS]


def _lines(low_m: float, high_m: float, reach_m: float) -> np.ndarray:
    """Borders of fields along one axis; the middle cell is the yard."""
    outward = _outward_m(reach_m)
    return np.concatenate([low_m - outward[::-1], [low_m, high_m], high_m + outward])


def _outward_m(reach_m: float) -> np.ndarray:
    """Distances from the yard at which fields end, up to beyond a distance."""
    outward = np.cumsum([*_STRIPS_M, *[_STRIPS_M[-1]] * 9])
    return outward[: int(np.searchsorted(outward, reach_m)) + 1]


def _rings_out(cell: int, n_cells: int) -> int:
    """Number of cells between a cell and the yard in the middle."""
    return abs(cell - n_cells // 2)


def _jittered(rng: np.random.Generator, lines: list[np.ndarray]) -> np.ndarray:
    """Crossings of the borders, (x, y, 2), moved a little except those of the yard."""
    x, y = np.meshgrid(*lines, indexing="ij")
    points = np.stack([x, y], axis=2)
    shift = rng.uniform(-0.22, 0.22, points.shape)
    for axis, own in enumerate(lines):
        # Shifts are shares of the narrower neighbouring field, so that fields never overlap.
        gap = np.minimum(np.diff(own, prepend=own[0] - 50.0), np.diff(own, append=own[-1] + 50.0))
        middle = len(own) // 2
        gap[middle - 1 : middle + 1] = 0.0
        shape = (-1, 1) if axis == 0 else (1, -1)
        shift[..., axis] *= gap.reshape(shape)
    return points + shift


def _field(quad: np.ndarray, field: Paint, ring: int, middle: np.ndarray) -> list[_Patch]:
    """A field within its hedge; far ones are plain and hazy."""
    if ring > _N_TEXTURED:
        distance_m = float(np.linalg.norm(quad.mean(axis=0) - middle))
        # Few colours keep the number of skins low.
        haze = round(4 * (1.0 - math.exp(-distance_m / _HAZE_M))) / 4
        red, green, blue = (
            (1 - haze) * c + haze * h for c, h in zip(field.rgb, FAR_LAND_RGB, strict=True)
        )
        return [(quad, Paint(None, (red, green, blue)))]
    inward = quad.mean(axis=0) - quad
    inner = quad + inward * _HEDGE_M * 2 / np.linalg.norm(inward, axis=1, keepdims=True)
    hedges = [
        np.stack([quad[k], quad[(k + 1) % 4], inner[(k + 1) % 4], inner[k]]) for k in range(4)
    ]
    return [(inner, field), *((hedge, _HEDGE) for hedge in hedges)]
