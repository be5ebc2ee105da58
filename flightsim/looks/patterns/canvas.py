"""Canvas of the patterns: a periodic square of pixels with noise, cells and joints.

Everything is periodic over the square, so that tiles meet without a seam. `u` runs right and `v`
up, from 0 to 1 over the tile.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

Picture = Float[np.ndarray, "n n 3"]
Plane = Float[np.ndarray, "n n"]
Mask = Bool[np.ndarray, "n n"]


class Canvas:
    """A periodic square with a random stream of its own.

    It remembers its random draws: after `rewind` the same calls return the same again, at no cost,
    for painting a pattern in another colour.
    """

    def __init__(self, n_pixels: int, seed: int) -> None:
        self.n = n_pixels
        self.u, self.v = _axes(n_pixels)
        self.panes = np.zeros((n_pixels, n_pixels), dtype=bool)
        """Pixels of windows behind which a lamp may shine; patterns of facades mark them."""
        self._rng = np.random.default_rng(seed)
        self._drawn: list[Any] = []
        self._next = 0

    def rewind(self) -> None:
        """Restart with the first random draw."""
        self._next = 0

    def normal(self, *shape: int) -> np.ndarray:
        """Return standard normal numbers of a given shape."""
        return self._remembered(lambda: self._rng.standard_normal(shape).astype(np.float32))

    def uniform(self, *shape: int) -> np.ndarray:
        """Return uniform numbers from 0 to 1 of a given shape."""
        return self._remembered(lambda: self._rng.random(shape).astype(np.float32))

    def noise(self, *cells: int | tuple[int, int]) -> Plane:
        """Return value noise of zero mean and about unit spread, summed over lattices.

        Args:
            cells: Lattice cells across the tile, or (across, up) for grain with a direction.
        """
        return self._remembered(lambda: self._noise(cells))

    def cells(self, n_across: int) -> tuple[Plane, Plane]:
        """Return pebbles, leaves, stones: one jittered point in each cell of a grid.

        Returns:
            Distance of each pixel from the border to the next cell (0 on it, about 0.5 in the
            centre), and a random number from 0 to 1 for each cell.
        """
        return self._remembered(lambda: self._cells(n_across))

    def courses(self, rows: int, columns: int, shift: float = 0.5) -> tuple[Plane, Plane, Plane]:
        """Return blocks in courses, every second one shifted, as in brickwork.

        Returns:
            For each pixel its position across and up its block, 0 to 1, and a standard normal
            number for each block.
        """
        return self._remembered(lambda: self._courses(rows, columns, shift))

    def rectangle(self, left: float, right: float, low: float, high: float) -> Mask:
        """Return the mask of a rectangle, whose left and low edges belong to it.

        Args:
            left: Left edge in tile coordinates, 0 to 1.
            right: Right edge.
            low: Low edge.
            high: High edge.
        """
        return (self.u >= left) & (self.u < right) & (self.v >= low) & (self.v < high)

    def _remembered(self, draw: Callable[[], Any]) -> Any:
        if self._next == len(self._drawn):
            self._drawn.append(draw())
        self._next += 1
        return self._drawn[self._next - 1]

    def _noise(self, cells: tuple[int | tuple[int, int], ...]) -> Plane:
        total = np.zeros((self.n, self.n), dtype=np.float32)
        for count in cells:
            across, up = count if isinstance(count, tuple) else (count, count)
            lattice = self._rng.standard_normal((up, across)).astype(np.float32)
            total += _stretch(_stretch(lattice, self.n).T, self.n).T
        # The spread of a sum of independent lattices grows with the root of their number.
        return total / np.float32(math.sqrt(len(cells)))

    def _cells(self, n_across: int) -> tuple[Plane, Plane]:
        jitter = self._rng.uniform(0.1, 0.9, (n_across, n_across, 2)).astype(np.float32)
        tone = self._rng.random((n_across, n_across)).astype(np.float32)
        x, y = self.u * n_across, self.v * n_across
        column, row = x.astype(int), y.astype(int)
        nearest = np.full(x.shape, 9.0, dtype=np.float32)
        second = nearest.copy()
        of_cell = np.zeros_like(nearest)
        # The nearest point may lie in any of the nine cells around a pixel.
        for dx, dy in itertools.product((-1, 0, 1), repeat=2):
            i, j = (row + dy) % n_across, (column + dx) % n_across
            away = np.hypot(column + dx + jitter[i, j, 0] - x, row + dy + jitter[i, j, 1] - y)
            is_nearer = away < nearest
            second = np.where(is_nearer, nearest, np.minimum(second, away))
            of_cell = np.where(is_nearer, tone[i, j], of_cell)
            nearest = np.minimum(nearest, away)
        return (second - nearest) / 2, of_cell

    def _courses(self, rows: int, columns: int, shift: float) -> tuple[Plane, Plane, Plane]:
        row = (self.v * rows).astype(int)
        along = (self.u * columns + shift * (row % 2)) % columns
        tone = self._rng.standard_normal((rows, columns)).astype(np.float32)
        return along % 1, (self.v * rows) % 1, tone[row, along.astype(int)]


def shade(rgb: np.ndarray, brightness: Plane) -> Picture:
    """Return a colour made lighter and darker."""
    return rgb * brightness[..., None].astype(np.float32)


def mix(mask: np.ndarray, inside: np.ndarray, outside: np.ndarray) -> Picture:
    """Return one picture within a mask, and another outside.

    Args:
        mask: True inside; fractions from 0 to 1 blend the two.
        inside: Picture or colour within the mask.
        outside: Picture or colour outside.
    """
    inside, outside = np.asarray(inside, np.float32), np.asarray(outside, np.float32)
    if mask.dtype == bool:
        return np.where(mask[..., None], inside, outside)
    return outside + mask[..., None].astype(np.float32) * (inside - outside)


Pattern = Callable[[Canvas, np.ndarray], Picture]
"""Paints a canvas in the tones of a colour, 0 to 1. Each pixel is linear in the colour, so that
the pattern in black and in white gives it in every other colour."""


@functools.cache
def _axes(n_pixels: int) -> tuple[Plane, Plane]:
    axis = (np.arange(n_pixels, dtype=np.float32) + 0.5) / n_pixels
    # The first row is the top one, so v is reversed.
    u, v = np.meshgrid(axis, axis[::-1])
    return u, v


def _stretch(lattice: np.ndarray, n_pixels: int) -> np.ndarray:
    """Smooth periodic interpolation of the last axis to a number of pixels."""
    n = lattice.shape[1]
    position = np.arange(n_pixels, dtype=np.float32) * n / n_pixels
    low = position.astype(int)
    blend = position - low
    blend = blend * blend * (3 - 2 * blend)
    return lattice[:, low] * (1 - blend) + lattice[:, (low + 1) % n] * blend
