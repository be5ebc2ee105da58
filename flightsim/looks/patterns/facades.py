"""Patterns of facades: one tile shows two bays and two storeys, no two windows alike."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flightsim.looks.patterns.canvas import Canvas, Pattern, Picture, mix, shade
from flightsim.looks.patterns.masonry import ashlar, brick, cladding, plaster

_SKY = np.array([0.38, 0.53, 0.68], np.float32)
_ROOM = np.array([0.13, 0.15, 0.18], np.float32)
_CURTAIN = np.array([0.80, 0.78, 0.72], np.float32)
_LAMP = np.array([0.98, 0.86, 0.56], np.float32)
_WHITE = np.array([0.93, 0.93, 0.91], np.float32)
_DARK = np.array([0.20, 0.22, 0.24], np.float32)
_SHUTTER = np.array([0.24, 0.40, 0.34], np.float32)
_STONE = np.array([0.80, 0.77, 0.70], np.float32)
_DOOR = np.array([0.30, 0.20, 0.13], np.float32)

Box = tuple[float, float, float, float]
"""Left, right, low and high within a bay of a storey, 0 to 1."""
EVERY_BAY = ((0, 0), (1, 0), (0, 1), (1, 1))
"""Bay and storey of each window of a tile."""
# Doors stand in every second bay.
RIGHT_BAYS = ((1, 0), (1, 1))
_AT_HOME = (1, 2)
"""Kinds of windows that are lit at night: behind a blind, and beside a lamp."""


@dataclass(frozen=True, slots=True)
class _Opening:
    """A window within its bay, and its parts."""

    box: Box
    casements: int = 2
    """Number of panes side by side."""
    transom: float = 0.0
    """Height of the cross bar as a share of the opening; 0 for none."""
    frame: float = 0.03


class _Wall:
    """Picture of a wall that is filled bay by bay."""

    def __init__(self, canvas: Canvas, picture: Picture) -> None:
        self.canvas = canvas
        self.picture = np.array(picture, dtype=np.float32)

    def fill(self, box: Box, rgb: np.ndarray, bays: tuple = EVERY_BAY) -> None:
        """Paint a box in every bay with a colour."""
        for area, _, _ in self.areas(box, bays):
            self.picture[area] = rgb

    def darken(self, box: Box, factor: float) -> None:
        """Darken a box in every bay."""
        for area, _, _ in self.areas(box):
            self.picture[area] *= factor

    def areas(
        self, box: Box, bays: tuple = EVERY_BAY
    ) -> Iterator[tuple[tuple[slice, slice], np.ndarray, np.ndarray]]:
        """Yield the pixels of a box in each bay.

        Args:
            box: Left, right, low and high edge, as fractions of a bay.
            bays: Bays to yield, as column and storey.

        Yields:
            Rows and columns of the picture, and two arrays with the pixels' places across and up
            the box, 0 to 1.
        """
        n, half = self.canvas.n, self.canvas.n / 2
        left, right, low, high = box
        for bay, storey in bays:
            columns = slice(round((bay + left) * half), round((bay + right) * half))
            # Rows count from the top of the picture.
            rows = slice(n - round((storey + high) * half), n - round((storey + low) * half))
            width, height = columns.stop - columns.start, rows.stop - rows.start
            across = (np.arange(width, dtype=np.float32) + 0.5) / max(1, width)
            up = (np.arange(height, dtype=np.float32)[::-1] + 0.5) / max(1, height)
            yield (rows, columns), *np.meshgrid(across, up)


def punched(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Plaster with casement windows, sills, lintels and a string course."""
    wall = _plastered(canvas, rgb)
    _put_window(wall, _Opening((0.26, 0.74, 0.28, 0.80)), _WHITE, 0.78 * rgb + 0.18)
    return wall.picture


def shuttered(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Windows between louvred shutters."""
    wall = _Wall(canvas, plaster(canvas, rgb))
    opening = _Opening((0.34, 0.66, 0.22, 0.80), transom=0.7)
    _put_window(wall, opening, _WHITE, 0.75 * rgb + 0.2)
    for box in ((0.17, 0.325, 0.22, 0.80), (0.675, 0.83, 0.22, 0.80)):
        for area, _, up in wall.areas(box):
            wall.picture[area] = shade(_SHUTTER, np.where((up * 20) % 1 < 0.4, 0.70, 1.05))
    return wall.picture


def brickwork(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Brick with stone lintels and sills over tall sashes."""
    wall = _Wall(canvas, _repeated(brick, canvas, rgb, 4))
    opening = _Opening((0.29, 0.71, 0.24, 0.80), casements=1, transom=0.5)
    _put_window(wall, opening, _WHITE, _STONE)
    return wall.picture


def stonework(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Ashlar with deep windows."""
    wall = _Wall(canvas, ashlar(canvas, rgb))
    _put_window(wall, _Opening((0.28, 0.72, 0.22, 0.82), transom=0.66), _DARK, 1.08 * rgb)
    return wall.picture


def balconies(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """French windows behind railings."""
    wall = _plastered(canvas, rgb)
    _put_window(wall, _Opening((0.20, 0.80, 0.06, 0.78), casements=3), _DARK, 0.8 * rgb)
    for area, across, _ in wall.areas((0.12, 0.88, 0.06, 0.36)):
        is_bar = (across * 18) % 1 < 0.26
        wall.picture[area] = mix(is_bar, 0.8 * _DARK, wall.picture[area])
    wall.fill((0.12, 0.88, 0.345, 0.375), 0.8 * _DARK)
    wall.fill((0.12, 0.88, 0.015, 0.06), 0.8 * _STONE)
    return wall.picture


def ribbon(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Bands of office windows in metal cladding."""
    wall = _Wall(canvas, cladding(canvas, rgb))
    opening = _Opening((0.0, 1.0, 0.30, 0.84), casements=3, frame=0.022)
    _put_window(wall, opening, _DARK, None)
    return wall.picture


def curtain_wall(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Glass from floor to floor in a grid of mullions, with coloured spandrels."""
    wall = _Wall(canvas, shade(0.62 * rgb, 0.95 + 0.05 * canvas.noise(4, 24)))
    opening = _Opening((0.0, 1.0, 0.20, 1.0), casements=2, transom=0.62, frame=0.02)
    _put_window(wall, opening, _DARK, None)
    return wall.picture


def shop_front(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Ground floor: shop windows with goods, a door, a fascia with lettering and an awning."""
    wall = _Wall(canvas, _repeated(ashlar, canvas, 0.62 * rgb + 0.05, 2))
    goods = canvas.noise((14, 10), (28, 18))
    for area, across, up in wall.areas((0.05, 0.95, 0.14, 0.70)):
        things = 0.16 * np.clip(goods[area], 0, 2)[..., None] * np.array([1.0, 0.8, 0.55])
        glow = 0.34 * np.clip(up - 0.5, 0, 1)[..., None] * _LAMP
        inside = (_ROOM + 0.12 + things + glow).astype(np.float32)
        is_bar = (across * 3.6) % 1 < 0.035
        wall.picture[area] = mix(is_bar, _DARK, inside)
        wall.canvas.panes[area] = ~is_bar
    for (bay, storey), hue in zip(
        EVERY_BAY, np.array([[0.16, 0.30, 0.28], [0.45, 0.14, 0.13]] * 2, np.float32), strict=True
    ):
        _put_fascia(wall, ((bay, storey),), hue)
    wall.fill((0.40, 0.60, 0.02, 0.70), _DARK, RIGHT_BAYS)
    wall.fill((0.43, 0.57, 0.12, 0.66), 0.6 * _SKY, RIGHT_BAYS)
    return wall.picture


def entrance(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Ground floor of flats: rusticated stone, a window in one bay and a door in the other."""
    wall = _Wall(canvas, _repeated(ashlar, canvas, 0.80 * rgb, 2))
    _put_window(wall, _Opening((0.26, 0.74, 0.28, 0.76)), _DARK, 0.7 * rgb + 0.1)
    wall.fill((0.18, 0.82, 0.0, 0.86), 0.86 * rgb + 0.08, RIGHT_BAYS)
    wall.fill((0.30, 0.70, 0.0, 0.68), _DOOR, RIGHT_BAYS)
    for box in ((0.34, 0.48, 0.06, 0.62), (0.52, 0.66, 0.06, 0.62)):
        wall.fill(box, 1.35 * _DOOR, RIGHT_BAYS)
    wall.fill((0.30, 0.70, 0.70, 0.80), _SKY + 0.1, RIGHT_BAYS)
    return wall.picture


def _plastered(canvas: Canvas, rgb: np.ndarray) -> _Wall:
    """Return plaster with a string course at every floor."""
    wall = _Wall(canvas, plaster(canvas, rgb))
    wall.fill((0.0, 1.0, 0.012, 0.045), 0.6 * rgb + 0.36)
    wall.fill((0.0, 1.0, 0.0, 0.012), 0.62 * rgb)
    return wall


def _put_window(
    wall: _Wall, opening: _Opening, frame_rgb: np.ndarray, trim_rgb: np.ndarray | None
) -> None:
    """Put the same opening into every bay, each with a different interior."""
    left, right, low, high = opening.box
    # Lintel and jambs, sill, and the shadow below the sill.
    if trim_rgb is not None:
        wall.fill((left - 0.035, right + 0.035, low - 0.01, high + 0.05), trim_rgb)
        wall.fill((left - 0.06, right + 0.06, low - 0.045, low - 0.01), 1.08 * trim_rgb + 0.04)
        wall.darken((left - 0.06, right + 0.06, low - 0.075, low - 0.045), 0.62)
    wall.fill(opening.box, frame_rgb)
    edge = opening.frame
    pane = (left + edge, right - edge, low + edge, high - edge)
    # A random order of the four interiors: each window of a tile differs.
    kinds = np.argsort(wall.canvas.uniform(4)).tolist()
    reflections = wall.canvas.noise(4, 9)
    for kind, (area, across, up) in zip(kinds, wall.areas(pane), strict=True):
        # Bars between panes, of the frame's width whatever the number of panes.
        bar = np.abs((across * opening.casements) % 1 - 0.5) > 0.5 - 0.5 * edge * opening.casements
        if opening.transom:
            bar |= np.abs(up - opening.transom) < 0.8 * edge
        glass = _behind_glass(kind, across, up, reflections[area])
        if kind in _AT_HOME:
            wall.canvas.panes[area] = ~bar
        wall.picture[area] = mix(bar, frame_rgb, glass)
    # The reveal casts a shadow on the glass.
    wall.darken((left, right, high - 0.045, high), 0.45)


def _behind_glass(kind: int, x: np.ndarray, y: np.ndarray, reflections: np.ndarray) -> Picture:
    """Sky reflected in the glass and, by the window's kind, curtains, a blind, a lamp or none."""
    sky = np.clip(0.15 + 0.75 * y + 0.12 * reflections, 0, 1)
    picture = mix(sky, _SKY + 0.06, np.broadcast_to(_ROOM, (*x.shape, 3)))
    if kind == 0:
        folds = 0.85 + 0.15 * np.sin(2 * np.pi * 9 * x)
        return mix((x < 0.24) | (x > 0.76), shade(_CURTAIN, folds), picture)
    if kind == 1:
        return mix(y > 0.45, shade(_CURTAIN, np.where((y * 22) % 1 < 0.3, 0.7, 0.95)), picture)
    if kind == 2:
        glow = np.clip(1 - 1.6 * np.hypot(x - 0.5, y - 0.75), 0, 1)
        return mix(0.55 * glow, _LAMP, picture)
    return picture


def _put_fascia(wall: _Wall, bays: tuple, hue: np.ndarray) -> None:
    """Put a shop's name over its awning."""
    wall.fill((0.03, 0.97, 0.83, 0.96), hue, bays)
    # Random cells look like lettering from afar, and no word has to be written.
    ink = wall.canvas.uniform(9, 24)
    for area, across, up in wall.areas((0.22, 0.78, 0.865, 0.925), bays):
        letter = ink[(up * 9).astype(int), (across * 24).astype(int)] > 0.45
        is_ink = letter & ((across * 8) % 1 < 0.75)
        wall.picture[area] = mix(is_ink, _STONE + 0.12, wall.picture[area])
    for area, across, up in wall.areas((0.03, 0.97, 0.70, 0.83), bays):
        is_pale = (across * 11).astype(int) % 2 == 0
        cloth = mix(is_pale, _WHITE, np.broadcast_to(1.25 * hue, (*across.shape, 3)))
        wall.picture[area] = cloth * (0.72 + 0.35 * up)[..., None]


def _repeated(pattern: Pattern, canvas: Canvas, rgb: np.ndarray, times: int) -> Picture:
    """Repeat a pattern several times over a tile."""
    picture = pattern(canvas, rgb)
    every = (np.arange(canvas.n) * times) % canvas.n
    return picture[every][:, every]
