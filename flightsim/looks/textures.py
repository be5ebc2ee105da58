"""Procedural surface textures: pictures of brick, grass, wood etc. in a material's colour.

Each pattern is a pure function of the colour, with a fixed random stream of its own, so that a
world is the same on every machine. Tiles repeat seamlessly; the material sets the size of a tile.
"""

from __future__ import annotations

import functools
import inspect
import zlib
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from jaxtyping import UInt8

from flightsim.looks.patterns import facades, ground, indoors, masonry
from flightsim.looks.patterns.canvas import Canvas, Pattern

Colour = tuple[float, float, float]

TILE_PIXELS = 128
LARGE_TILE_PIXELS = 256
"""Tile size for facades, which show four windows, and for lawns, whose repetition would show."""

PATTERNS: Mapping[str, Pattern] = MappingProxyType(
    {
        # Names that are Python's own end in an underscore there.
        name.rstrip("_"): pattern
        for module in (ground, masonry, indoors, facades)
        for name, pattern in inspect.getmembers(module, inspect.isfunction)
        if pattern.__module__ == module.__name__ and not name.startswith("_")
    }
)
"""Patterns by the names that materials use: every public function of the patterns' modules."""

_LAMPLIGHT = np.array([1.0, 0.82, 0.52], dtype=np.float32)

_LARGE = frozenset(
    {"grass", *(name for name in PATTERNS if PATTERNS[name].__module__ == facades.__name__)}
)


@functools.lru_cache(maxsize=512)
def tile(texture: str, rgb: Colour) -> UInt8[np.ndarray, "n n 3"]:
    """Return the picture of one tile, top row first; read-only, because it is cached.

    Args:
        texture: Name of the pattern; an unknown name gets the pattern of plaster.
        rgb: Colour of the material, 0 to 1.
    """
    picture, _ = _painted(texture, rgb)
    return _in_bytes(picture)


@functools.lru_cache(maxsize=512)
def lit_tile(texture: str, rgb: Colour, outside_rgb: Colour) -> UInt8[np.ndarray, "n n 3"]:
    """Picture of one tile of a facade at night, with light in some of its windows.

    Args:
        texture: Name of the pattern.
        rgb: Colour of the material, 0 to 1.
        outside_rgb: Light on the wall, by which the picture is dimmed outside of those windows.
    """
    picture, is_pane = _painted(texture, rgb)
    grey = picture.mean(axis=2, keepdims=True)
    within = _LAMPLIGHT * (0.45 + 0.75 * grey)
    dimmed = picture * np.array(outside_rgb, dtype=np.float32)
    return _in_bytes(np.where(is_pane[..., None], within, dimmed))


def _painted(texture: str, rgb: Colour) -> tuple[np.ndarray, np.ndarray]:
    """A pattern in a colour, and its pixels behind which lamps shine at night."""
    black, white, is_pane = _in_black_and_white(texture if texture in PATTERNS else "plaster")
    return black + np.asarray(rgb, dtype=np.float32) * (white - black), is_pane


def _in_bytes(picture: np.ndarray) -> np.ndarray:
    tile_rgb = np.clip(255.0 * picture + 0.5, 0, 255).astype(np.uint8)
    tile_rgb.setflags(write=False)
    return tile_rgb


@functools.cache
def _in_black_and_white(texture: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A pattern in the two colours between which all others are interpolated, and its panes."""
    n_pixels = LARGE_TILE_PIXELS if texture in _LARGE else TILE_PIXELS
    # A checksum as the seed: Python's own hash differs from run to run.
    canvas = Canvas(n_pixels, zlib.crc32(texture.encode()))
    black = PATTERNS[texture](canvas, np.zeros(3, dtype=np.float32))
    canvas.rewind()
    white = PATTERNS[texture](canvas, np.ones(3, dtype=np.float32))
    return black.astype(np.float32), white.astype(np.float32), canvas.panes


def coarser(picture: UInt8[np.ndarray, "n n 3"], factor: int) -> UInt8[np.ndarray, "m m 3"]:
    """Return a tile with fewer pixels, each the mean of a square of the original's.

    Args:
        picture: Tile of n by n pixels.
        factor: Divisor of n, by which the tile shrinks.
    """
    n = picture.shape[0] // factor
    squares = picture.reshape(n, factor, n, factor, 3)
    return (squares.mean(axis=(1, 3)) + 0.5).astype(np.uint8)
