"""Patterns of rooms and things: wood, floor tiles, fabric, metal, glass, screens."""

from __future__ import annotations

import numpy as np

from flightsim.looks.patterns.canvas import Canvas, Picture, mix, shade


def wood(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Planks along u with grain, knots and butt joints."""
    planks = 6
    plank = (canvas.v * planks).astype(int)
    up = (canvas.v * planks) % 1
    tone = 1 + 0.11 * canvas.normal(planks)[plank]
    grain = 0.09 * canvas.noise((5, 64), (9, 128)) + 0.05 * np.sin(
        2 * np.pi * (24 * canvas.v + 0.9 * canvas.noise((3, 6)))
    )
    # Each plank has one butt joint at a place of its own.
    seam = (up < 0.07) | (np.abs(canvas.u - canvas.uniform(planks)[plank]) < 0.006)
    edge, knot = canvas.cells(9)
    is_knot = (knot > 0.965) & (edge > 0.30)
    return shade(rgb, np.where(seam, 0.52, np.where(is_knot, 0.62, tone + grain)))


def parquet(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Blocks of four staves, turned by a quarter from block to block."""
    n = 4
    column, row = (canvas.u * n).astype(int), (canvas.v * n).astype(int)
    # Quarter turns alternate like a chessboard.
    is_turned = (column + row) % 2 == 1
    across, up = (canvas.u * n) % 1, (canvas.v * n) % 1
    stave = (np.where(is_turned, across, up) * 4).astype(int)
    within = (np.where(is_turned, across, up) * 4) % 1
    tone = canvas.normal(n, n, 4)[row, column, stave]
    along = np.where(is_turned, canvas.noise((96, 8)), canvas.noise((8, 96)))
    end = np.where(is_turned, up, across) < 0.03
    return shade(rgb, np.where((within < 0.08) | end, 0.62, 1 + 0.12 * tone + 0.06 * along))


def tiles(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Glazed tiles in grout."""
    n = 4
    across, up = (canvas.u * n) % 1, (canvas.v * n) % 1
    # One tone for each tile, looked up by its row and column.
    tone = canvas.normal(n, n)[(canvas.v * n).astype(int), (canvas.u * n).astype(int)]
    is_grout = (across < 0.045) | (up < 0.045)
    brightness = 0.97 + 0.05 * tone + 0.05 * (up - 0.5) + 0.025 * canvas.noise(8, 32)
    return mix(is_grout, 0.62 * rgb, shade(rgb, brightness))


def carpet(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Carpet tiles laid by turns, with loops of pile."""
    is_turned = ((canvas.u * 2).astype(int) + (canvas.v * 2).astype(int)) % 2 == 1
    lines = np.where(is_turned, canvas.noise((64, 8)), canvas.noise((8, 64)))
    seam = ((canvas.u * 2) % 1 < 0.012) | ((canvas.v * 2) % 1 < 0.012)
    brightness = np.where(is_turned, 1.06, 0.94) + 0.10 * lines + 0.08 * canvas.noise(128)
    return shade(rgb, np.where(seam, 0.78, brightness))


def fabric(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Weave with stripes and folds."""
    weave = 0.09 * (np.sin(2 * np.pi * 32 * canvas.u) * np.sin(2 * np.pi * 32 * canvas.v))
    stripe = np.where((canvas.u * 4) % 1 < 0.12, 1.14, 1.0)
    folds = 0.07 * canvas.noise((4, 2)) + 0.06 * canvas.noise(24)
    return shade(rgb, (1 + weave + folds) * stripe)


def metal(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Brushed sheet: streaks, a seam and rivets."""
    streaks = 0.06 * canvas.noise((128, 3)) + 0.05 * canvas.noise(4)
    sheen = 0.05 * np.sin(2 * np.pi * (canvas.v + 0.25))
    seam = (canvas.v < 0.012) | (canvas.u < 0.012)
    near = np.minimum(np.abs(canvas.v - 0.045), np.abs(canvas.u - 0.045)) < 0.010
    rivet = near & (((canvas.u + canvas.v) * 10) % 1 < 0.16)
    # Raised rivets catch the light, seams lie in shade.
    return shade(rgb, np.where(seam, 0.58, np.where(rivet, 1.22, 1 + streaks + sheen)))


def paint(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Painted panels: seams, a sheen of sky, dust at the bottom, scratches."""
    up = canvas.v
    sheen = 0.90 + 0.16 * np.clip(np.sin(np.pi * up), 0, 1) + 0.03 * canvas.noise(3, 6)
    seam = (np.abs(canvas.u - 0.5) < 0.007) | (up < 0.012)
    edge = (np.abs(canvas.u - 0.515) < 0.006) | (np.abs(up - 0.02) < 0.007)
    # Gloss: the brightest part mirrors the sky.
    picture = shade(rgb, sheen) + 0.05 * np.clip(sheen - 0.96, 0, 1)[..., None]
    dust = (
        0.16 * np.clip(0.28 - up, 0, 1)[..., None] * np.clip(1 + canvas.noise(24), 0, 2)[..., None]
    )
    picture = picture * (1 - dust) + dust * np.array([0.55, 0.50, 0.43])
    scratch = np.abs(canvas.noise((4, 24))) < 0.012
    picture = mix(scratch, 0.8 * picture + 0.12, picture)
    return mix(edge, 1.12 * picture + 0.02, mix(seam, 0.35 * picture, picture))


def container(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Painted container walls: upright folds, rust along the edges."""
    across = (canvas.u * 7) % 1
    # Slopes of a trapezoidal fold differ in brightness, as if lit from one side.
    fold = np.select([across < 0.34, across < 0.48, across < 0.86], [1.04, 0.66, 0.90], 1.18)
    rust = np.clip(canvas.noise((24, 4), (40, 8)) - 1.05, 0, 0.7)
    picture = shade(rgb, fold * (1 + 0.05 * canvas.noise(6, 24)))
    return mix(rust, np.array([0.40, 0.22, 0.13]), picture)


def plastic(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Moulded shell: ribs, grain and a paler rim."""
    rib = np.where((canvas.v * 4) % 1 < 0.05, 0.80, 1.0)
    rim = (canvas.u < 0.02) | (canvas.v < 0.02)
    brightness = (1 + 0.03 * canvas.noise(8) + 0.045 * canvas.noise(96)) * rib
    # Dust shows on black.
    dust = np.clip(0.02 + 0.02 * canvas.noise(12, 64), 0.0, 0.06)
    return mix(rim, 0.82 * rgb + 0.06, mix(dust, np.ones(3), shade(rgb, brightness)))


def glass(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """A pane that mirrors the sky: paler above, with clouds and slanting streaks."""
    sky = 0.72 + 0.42 * np.sin(np.pi * canvas.v)
    streak = np.sin(2 * np.pi * (canvas.u + canvas.v + 0.12 * canvas.noise(3)))
    clouds = np.clip(canvas.noise((3, 5), (6, 10)), 0, 1.5)
    glare = 0.10 * np.clip(streak - 0.75, 0, 1) * 4 + 0.09 * clouds
    frame = (canvas.u < 0.022) | (canvas.v < 0.022)
    picture = shade(rgb, sky) + glare[..., None] * np.array([0.8, 0.95, 1.0])
    return mix(frame, 0.35 * rgb, picture)


def solar(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Cells with busbars in an aluminium frame."""
    n = 6
    across, up = (canvas.u * n) % 1, (canvas.v * n) % 1
    is_busbar = (across < 0.07) | (up < 0.07)
    is_frame = (np.minimum(canvas.u, canvas.v) < 0.02) | (np.maximum(canvas.u, canvas.v) > 0.98)
    tone = 1 + 0.08 * canvas.normal(n, n)[(canvas.v * n).astype(int), (canvas.u * n).astype(int)]
    cells = mix(is_busbar, rgb + 0.24, shade(rgb, tone * (0.85 + 0.3 * canvas.v)))
    return mix(is_frame, np.full(3, 0.78), cells)


def cardboard(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Flutes, a strip of tape and printed marks."""
    flutes = 0.03 * np.sin(2 * np.pi * 48 * canvas.u) + 0.05 * canvas.noise(5, 48)
    picture = shade(rgb, 1 + flutes)
    picture = mix(np.abs(canvas.u - 0.5) < 0.06, 0.75 * picture + 0.16, picture)
    marks = canvas.rectangle(0.10, 0.30, 0.12, 0.18) | canvas.rectangle(0.10, 0.24, 0.22, 0.25)
    arrow = canvas.rectangle(0.74, 0.78, 0.60, 0.80) | canvas.rectangle(0.82, 0.86, 0.60, 0.80)
    return mix(marks | arrow, 0.45 * rgb, picture)


def ceramic(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Glaze with a painted band and speckles."""
    band = np.abs((canvas.v * 2) % 1 - 0.75) < 0.05
    speckle = canvas.noise(48) > 2.1
    picture = shade(rgb, 1 + 0.05 * canvas.noise(4) + 0.03 * canvas.noise(64))
    return mix(band | speckle, np.array([0.30, 0.42, 0.58]), picture)


def screen(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """A desktop: windows with lines of text on a dark ground."""
    picture = shade(rgb, 0.9 + 0.5 * canvas.v)
    for left, right, low, high in ((0.06, 0.56, 0.20, 0.88), (0.62, 0.94, 0.42, 0.80)):
        window = canvas.rectangle(left, right, low, high)
        picture = mix(window, np.array([0.82, 0.87, 0.92]), picture)
        bar = canvas.rectangle(left, right, high - 0.06, high)
        picture = mix(bar, np.array([0.22, 0.46, 0.72]), picture)
        # Noise of one cell a word cuts lines into words.
        words = ((canvas.v * 18) % 1 < 0.45) & (canvas.noise((24, 18)) > -0.3)
        text = canvas.rectangle(left + 0.04, right - 0.05, low + 0.05, high - 0.10) & words
        picture = mix(text, np.array([0.30, 0.34, 0.40]), picture)
    return picture


def print_(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Lines of print in two columns."""
    words = ((canvas.v * 20) % 1 < 0.45) & (canvas.noise((32, 20)) > -0.4)
    column = (canvas.u * 2) % 1
    text = words & (column > 0.1) & (column < 0.9)
    return mix(text, 0.42 * rgb, shade(rgb, 1 + 0.03 * canvas.noise(6)))


def rubber(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Treads."""
    tread = (canvas.u * 12 + 0.5 * ((canvas.v * 4).astype(int) % 2)) % 1 < 0.30
    return shade(rgb, np.where(tread, 0.55, 1.25 + 0.15 * canvas.noise(48)))


def worn_paint(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Road paint with the asphalt showing through."""
    worn = (canvas.noise(24, 64) > 1.75) | (np.abs(canvas.noise(3, 7)) < 0.02)
    return mix(worn, 0.60 * rgb + 0.05, shade(rgb, 0.98 + 0.05 * canvas.noise(8, 48)))


def ceiling(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Mineral panels on a grid, one in eight a light."""
    n = 4
    column, row = (canvas.u * n).astype(int), (canvas.v * n).astype(int)
    across, up = (canvas.u * n) % 1, (canvas.v * n) % 1
    is_rail = (across < 0.045) | (up < 0.045)
    # One panel of each second row.
    is_light = (row % 2 == 1) & (column == 2) & ~is_rail
    holes = canvas.noise(96) > 1.1
    picture = shade(rgb, np.where(holes, 0.80, 0.90 + 0.02 * canvas.noise(8)))
    picture = mix(is_rail, 0.68 * rgb, picture)
    return mix(is_light, np.full(3, 1.0), picture)


def wallpaper(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Stripes with a small motif."""
    stripe = np.where((canvas.u * 6) % 1 < 0.5, 1.0, 0.92)
    x, y = (canvas.u * 6) % 1 - 0.25, (canvas.v * 6) % 1 - 0.5
    motif = (np.abs(x) + np.abs(y) < 0.16) & (np.abs(x) + np.abs(y) > 0.07)
    picture = shade(rgb, stripe * (1 + 0.02 * canvas.noise(8, 64)))
    return mix(motif, 0.72 * rgb, picture)


def skirting(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """A painted wall from floor to ceiling: skirting board, trowelled paint, cornice."""
    brightness = 1 + 0.03 * canvas.noise((6, 12), (12, 24)) + 0.03 * canvas.noise(96)
    return _trimmed(canvas, shade(rgb, brightness), rgb)


def dado(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Panelling to a rail at a third of the height, paint above."""
    brightness = 1 + 0.025 * canvas.noise((6, 12)) + 0.03 * canvas.noise(96)
    across = (canvas.u * 3) % 1
    low = canvas.v < 0.34
    moulding = np.abs(np.maximum(np.abs(across - 0.5) - 0.36, np.abs(canvas.v - 0.19) * 3 - 0.30))
    panels = np.where(moulding < 0.02, 0.72, 1.0)
    picture = mix(low, shade(0.62 * rgb, panels * brightness), shade(rgb, brightness))
    rail = np.abs(canvas.v - 0.345) < 0.010
    return _trimmed(canvas, mix(rail, 0.5 * rgb + 0.45, picture), rgb)


def papered(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Wallpaper between skirting and cornice."""
    return _trimmed(canvas, wallpaper(canvas, rgb), rgb)


def _trimmed(canvas: Canvas, wall: Picture, rgb: np.ndarray) -> Picture:
    # Skirting board, its shadow line, cornice and its shadow line.
    picture = mix(canvas.v < 0.045, 0.35 * rgb + 0.58, wall)
    picture = mix(np.abs(canvas.v - 0.047) < 0.005, 0.55 * rgb, picture)
    picture = mix(canvas.v > 0.965, 0.25 * rgb + 0.70, picture)
    return mix(np.abs(canvas.v - 0.962) < 0.004, 0.62 * rgb, picture)
