"""Patterns of walls and roofs: brick, stone, plaster, concrete, cladding, roof tiles."""

from __future__ import annotations

import numpy as np

from flightsim.looks.patterns.canvas import Canvas, Picture, mix, shade


def brick(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Courses of bricks, some burnt darker, in pale mortar."""
    across, up, tone = canvas.courses(12, 4)
    is_mortar = (up < 0.16) | (across < 0.05)
    noise = 1 + 0.07 * canvas.noise(64) + 0.05 * canvas.noise(5)
    # About a tenth of the bricks is burnt darker.
    burnt = np.where(tone > 1.35, 0.72, 1.0)
    bricks = shade(rgb, (1 + 0.13 * tone) * burnt * noise)
    return mix(is_mortar, shade(0.35 * rgb + 0.46, noise), bricks)


def stone_wall(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Rubble in mortar."""
    edge, tone = canvas.cells(7)
    noise = canvas.noise(16, 64)
    stones = shade(rgb, (0.74 + 0.46 * tone) * (0.86 + 0.5 * np.minimum(edge, 0.3)) + 0.07 * noise)
    return mix(edge < 0.045, shade(0.5 * rgb + 0.1, 1 + 0.06 * noise), stones)


def ashlar(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Large squared stones with fine joints."""
    across, up, tone = canvas.courses(4, 2)
    joint = (up < 0.035) | (across < 0.018)
    # The upper and right edges of a stone catch the light.
    lip = (up > 0.975) | (across > 0.988)
    noise = canvas.noise(8, 32) * 0.05 + 0.05 * canvas.noise(96)
    brightness = (1 + 0.075 * tone) * (1 + noise)
    return shade(rgb, np.where(joint, 0.58, np.where(lip, 1.08, brightness)))


def concrete(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Formwork panels with ties, blotches and water stains."""
    n = 2
    across, up = (canvas.u * n) % 1, (canvas.v * n) % 1
    joint = (across < 0.016) | (up < 0.016)
    # Round tie holes: squared distance from the nearest of four places in a panel.
    tie = np.minimum(np.abs(across - 0.25), np.abs(across - 0.75)) ** 2
    tie = tie + np.minimum(np.abs(up - 0.25), np.abs(up - 0.75)) ** 2 < 0.02**2
    stains = np.clip(canvas.noise((24, 3)), 0, 2) * np.clip(canvas.noise(3), 0, 1)
    brightness = 1 + 0.075 * canvas.noise(5, 10, 20) + 0.07 * canvas.noise(128) - 0.06 * stains
    return shade(rgb, np.where(tie, 0.62, np.where(joint, 0.66, brightness)))


def plaster(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Trowelled render: broad strokes, grain, a hairline crack."""
    strokes = canvas.noise((6, 14), (12, 24))
    brightness = 1 + 0.035 * strokes + 0.030 * canvas.noise(5) + 0.035 * canvas.noise(128)
    crack = np.abs(canvas.noise(3, 5)) < 0.008
    return shade(rgb, np.where(crack, 0.84, brightness))


def boards(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Cladding of horizontal boards that overlap."""
    rows = 10
    row = (canvas.v * rows).astype(int)
    up = (canvas.v * rows) % 1
    tone = 1 + 0.07 * canvas.normal(rows)[row]
    grain = 0.06 * canvas.noise((6, 96), (12, 128))
    butt = np.abs(canvas.u - canvas.uniform(rows)[row]) < 0.004
    lap = np.where(up < 0.10, 0.55, np.where(up > 0.92, 1.1, 0.94 + 0.10 * up))
    return shade(rgb, np.where(butt, 0.6, (tone + grain) * lap))


def cladding(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Metal cassettes with shadow gaps, each catching the light a little differently."""
    rows, columns = 4, 2
    row, column = (canvas.v * rows).astype(int), (canvas.u * columns).astype(int)
    across, up = (canvas.u * columns) % 1, (canvas.v * rows) % 1
    tone = 1 + 0.05 * canvas.normal(rows, columns)[row, column]
    gap = (across < 0.015) | (up < 0.03)
    lip = (across > 0.985) | (up > 0.965)
    sheen = 0.95 + 0.09 * up + 0.02 * canvas.noise((3, 64))
    return shade(rgb, np.where(gap, 0.45, np.where(lip, 1.12, tone * sheen)))


def corrugated(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Trapezoidal sheet with rows of screws and streaks of rust."""
    across = (canvas.u * 8) % 1
    rib = np.select([across < 0.3, across < 0.42, across < 0.8], [1.05, 0.72, 0.96], 1.16)
    row = (canvas.v * 2) % 1
    screws = (np.abs(row - 0.5) < 0.012) & (np.abs(across - 0.15) < 0.06)
    lap = row < 0.012
    rust = np.clip(canvas.noise((32, 3), (48, 6)) - 1.0, 0, 1) * 0.5
    picture = shade(rgb, np.where(screws, 0.4, np.where(lap, 0.6, rib)))
    picture = picture * (1 + 0.04 * canvas.noise((24, 6)))[..., None]
    return mix(np.clip(rust, 0, 0.6), np.array([0.42, 0.26, 0.17]), picture)


def roof_tiles(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Rows of pantiles; each row shades the one below."""
    across, up, tone = canvas.courses(8, 8)
    curve = 0.74 + 0.40 * np.sin(np.pi * across)
    # Each row lies over the one below, whose top is in shade.
    edge = np.where(up < 0.16, 0.52, 1.0 - 0.12 * up)
    moss = np.clip(canvas.noise(4, 12) - 0.9, 0, 1)
    picture = shade(rgb, (1 + 0.11 * tone) * curve * edge * (1 + 0.05 * canvas.noise(64)))
    return mix(0.35 * moss, np.array([0.36, 0.40, 0.22]), picture)


def felt(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Roofing felt: sheets with welded seams, mineral grain, dried puddles."""
    across = (canvas.u * 2) % 1
    seam = across < 0.022
    lap = (across > 0.022) & (across < 0.08)
    puddle = np.clip(canvas.noise(3, 6) - 0.5, 0, 1)
    rim = np.abs(canvas.noise(3, 5) - 0.8) < 0.035
    brightness = 1 + 0.13 * canvas.noise(128) + 0.07 * canvas.noise(6, 24) - 0.16 * puddle
    brightness = np.where(lap, 0.92 * brightness, brightness)
    return shade(rgb, np.where(seam, 0.55, np.where(rim, 0.84 * brightness, brightness)))
