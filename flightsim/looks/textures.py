"""Procedural surface textures: a material's colour turned into a picture of brick, grass, wood...

Each pattern is a pure function of the colour, with a fixed random stream of its own, so that a
world is the same on every machine. Tiles repeat seamlessly; a material says how much a tile covers.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable

import numpy as np

Colour = tuple[float, float, float]
Pattern = Callable[[np.ndarray, np.random.Generator], np.ndarray]

TILE_PIXELS = 128


def tile(texture: str, rgb: Colour) -> np.ndarray:
    """Picture of one tile.

    Args:
        texture: Name of the pattern; a name without a pattern gets plaster's.
        rgb: Colour of the material, 0 to 1.

    Returns:
        uint8 (TILE_PIXELS, TILE_PIXELS, 3), top row first.
    """
    rng = np.random.default_rng(zlib.crc32(texture.encode()))
    pattern = _PATTERNS.get(texture, _plaster)
    picture = pattern(np.asarray(rgb, dtype=float), rng)
    return np.clip(255.0 * picture + 0.5, 0, 255).astype(np.uint8)


def _grid() -> tuple[np.ndarray, np.ndarray]:
    """Coordinates of pixel centres in the tile, 0 to 1; v grows upwards."""
    axis = (np.arange(TILE_PIXELS) + 0.5) / TILE_PIXELS
    u, v = np.meshgrid(axis, axis[::-1])
    return u, v


def _noise(rng: np.random.Generator, *cells: int) -> np.ndarray:
    """Periodic value noise of zero mean and about unit spread, summed over lattices."""
    total = np.zeros((TILE_PIXELS, TILE_PIXELS))
    for n in cells:
        lattice = rng.standard_normal((n, n))
        position = np.arange(TILE_PIXELS) * n / TILE_PIXELS
        low = position.astype(int)
        blend = position - low
        blend = blend * blend * (3 - 2 * blend)
        high = (low + 1) % n
        rows = lattice[low] * (1 - blend)[:, None] + lattice[high] * blend[:, None]
        total += rows[:, low] * (1 - blend) + rows[:, high] * blend
    return total / np.sqrt(len(cells))


def _shade(rgb: np.ndarray, brightness: np.ndarray) -> np.ndarray:
    return rgb * brightness[..., None]


def _mix(mask: np.ndarray, inside: np.ndarray, outside: np.ndarray) -> np.ndarray:
    return np.where(mask[..., None], inside, outside)


def _brick(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    u, v = _grid()
    courses, bricks = 12, 6
    course = (v * courses).astype(int)
    shifted = (u * bricks + 0.5 * (course % 2)) % bricks
    tone = 1 + 0.10 * rng.standard_normal((courses, bricks))[course, shifted.astype(int)]
    is_mortar = ((v * courses) % 1 < 0.14) | (shifted % 1 < 0.07)
    noise = 1 + 0.04 * _noise(rng, 64)
    return _mix(is_mortar, _shade(0.35 * rgb + 0.5, noise), _shade(rgb, tone * noise))


def _windows(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    u, v = _grid()
    wall = _shade(rgb, 1 + 0.03 * _noise(rng, 16, 64))
    is_frame = (np.abs(u - 0.5) < 0.27) & (np.abs(v - 0.52) < 0.27)
    is_glass = (np.abs(u - 0.5) < 0.24) & (np.abs(v - 0.52) < 0.24) & (np.abs(u - 0.5) > 0.012)
    is_sill = (np.abs(u - 0.5) < 0.30) & (np.abs(v - 0.24) < 0.018)
    sky = np.array([0.34, 0.47, 0.60]) + 0.25 * (v[..., None] - 0.5)
    picture = _mix(is_frame, np.full(3, 0.88), wall)
    picture = _mix(is_glass, sky, picture)
    return _mix(is_sill, np.full(3, 0.70), picture)


def _asphalt(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return _shade(rgb, 1 + 0.08 * _noise(rng, 8, 32) + 0.10 * _noise(rng, 128))


def _grass(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    blades = 0.97 + 0.05 * _noise(rng, 8, 32) + 0.11 * _noise(rng, 64, 128)
    dry = 0.05 * np.maximum(0, _noise(rng, 16, 64))
    return _shade(rgb, blades) + dry[..., None] * np.array([1.0, 0.8, 0.4])


def _wood(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    _, v = _grid()
    planks = 6
    plank = (v * planks).astype(int)
    tone = 1 + 0.09 * rng.standard_normal(planks)[plank]
    grain = 0.05 * np.sin(2 * np.pi * (18 * v + 0.6 * _noise(rng, 4)))
    seam = np.where((v * planks) % 1 < 0.06, 0.72, 1.0)
    return _shade(rgb, (tone + grain) * seam)


def _tiles(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    u, v = _grid()
    n = 4
    tone = 1 + 0.035 * rng.standard_normal((n, n))[(v * n).astype(int), (u * n).astype(int)]
    is_grout = ((u * n) % 1 < 0.05) | ((v * n) % 1 < 0.05)
    return _mix(is_grout, 0.72 * rgb, _shade(rgb, tone))


def _concrete(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    u, v = _grid()
    n = 2
    joint = np.where(((u * n) % 1 < 0.015) | ((v * n) % 1 < 0.015), 0.80, 1.0)
    return _shade(rgb, joint * (1 + 0.05 * _noise(rng, 8, 32) + 0.03 * _noise(rng, 128)))


def _water(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return _shade(rgb, 1 + 0.10 * _noise(rng, 8, 16, 32))


def _fabric(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    u, v = _grid()
    weave = 0.05 * (np.sin(2 * np.pi * 32 * u) + np.sin(2 * np.pi * 32 * v))
    return _shade(rgb, 1 + weave + 0.04 * _noise(rng, 32))


def _plaster(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return _shade(rgb, 1 + 0.025 * _noise(rng, 16, 64))


def _paving(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    u, v = _grid()
    rows, columns = 6, 3
    row = (v * rows).astype(int)
    shifted = (u * columns + 0.5 * (row % 2)) % columns
    tone = 1 + 0.06 * rng.standard_normal((rows, columns))[row, shifted.astype(int)]
    joint = np.where(((v * rows) % 1 < 0.08) | (shifted % 1 < 0.04), 0.75, 1.0)
    return _shade(rgb, tone * joint * (1 + 0.03 * _noise(rng, 64)))


def _roof_tiles(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    u, v = _grid()
    rows, columns = 8, 8
    row = (v * rows).astype(int)
    shifted = (u * columns + 0.5 * (row % 2)) % columns
    tone = 1 + 0.08 * rng.standard_normal((rows, columns))[row, shifted.astype(int)]
    curve = 0.82 + 0.28 * np.sin(np.pi * (shifted % 1)) - 0.22 * ((v * rows) % 1)
    return _shade(rgb, tone * curve)


def _corrugated(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    u, _ = _grid()
    return _shade(rgb, 0.92 + 0.12 * np.sin(2 * np.pi * 8 * u) + 0.02 * _noise(rng, 16))


def _gravel(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return _shade(rgb, 1 + 0.10 * _noise(rng, 32, 64) + 0.10 * _noise(rng, 128))


def _leaves(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    clumps = 1 + 0.24 * _noise(rng, 16, 32) + 0.14 * _noise(rng, 64)
    return _shade(rgb, np.maximum(0.45, clumps))


def _solar(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    del rng
    u, v = _grid()
    n = 6
    is_busbar = ((u * n) % 1 < 0.07) | ((v * n) % 1 < 0.07)
    is_frame = (np.minimum(u, v) < 0.02) | (np.maximum(u, v) > 0.98)
    cells = _mix(is_busbar, rgb + 0.22, _shade(rgb, 0.9 + 0.2 * v))
    return _mix(is_frame, np.full(3, 0.75), cells)


_PATTERNS: dict[str, Pattern] = {
    "asphalt": _asphalt,
    "brick": _brick,
    "concrete": _concrete,
    "corrugated": _corrugated,
    "fabric": _fabric,
    "grass": _grass,
    "gravel": _gravel,
    "leaves": _leaves,
    "paving": _paving,
    "plaster": _plaster,
    "roof_tiles": _roof_tiles,
    "solar": _solar,
    "tiles": _tiles,
    "water": _water,
    "windows": _windows,
    "wood": _wood,
}
