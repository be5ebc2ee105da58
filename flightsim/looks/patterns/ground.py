"""Patterns underfoot and out of doors: asphalt, paving, gravel, grass, fields, water."""

from __future__ import annotations

import numpy as np

from flightsim.looks.patterns.canvas import Canvas, Picture, mix, shade


def asphalt(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Aggregate, worn patches, a mended rectangle and cracks sealed with tar."""
    wear = canvas.noise(4, 8)
    grain = canvas.noise(64, 128)
    brightness = 1 + 0.10 * wear + 0.13 * grain
    patch = canvas.rectangle(0.55, 0.86, 0.12, 0.34)
    brightness = np.where(patch, 0.78 + 0.10 * grain, brightness)
    # Where noise crosses zero, thin lines run: cracks.
    crack = np.abs(canvas.noise(3, 6)) < 0.028
    return shade(rgb, np.where(crack, 0.55, brightness))


def paving(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Slabs in courses, each of its own tone, with dirt in the joints."""
    across, up, tone = canvas.courses(6, 3)
    joint = (up < 0.07) | (across < 0.035)
    lip = (up > 0.9) | (across > 0.965)
    brightness = (1 + 0.085 * tone) * (1 + 0.05 * canvas.noise(48) + 0.06 * canvas.noise(4))
    return shade(rgb, np.where(joint, 0.56, np.where(lip, 1.06 * brightness, brightness)))


def cobbles(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Round setts."""
    edge, tone = canvas.cells(9)
    brightness = (0.78 + 0.34 * tone) * (0.55 + 0.6 * np.minimum(edge * 3.2, 0.75))
    return shade(rgb, brightness * (1 + 0.06 * canvas.noise(64)))


def gravel(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Pebbles with dark gaps."""
    edge, tone = canvas.cells(22)
    brightness = (0.72 + 0.5 * tone) * (0.62 + 0.55 * np.minimum(edge * 4.0, 0.8))
    return shade(rgb, brightness * (1 + 0.07 * canvas.noise(6, 12)))


def soil(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Crumbs of earth."""
    edge, tone = canvas.cells(16)
    brightness = (0.7 + 0.45 * tone) * (0.8 + edge) * (1 + 0.14 * canvas.noise(8, 64))
    return shade(rgb, brightness)


def grass(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Blades, clumps, dry spots and a few daisies."""
    # Many lattice cells across and few up give blades that stand upright.
    blades = canvas.noise((256, 110), (200, 80))
    clumps = canvas.noise(3, 7, 17)
    picture = shade(rgb, 0.99 + 0.17 * blades + 0.11 * clumps)
    dry = np.clip(canvas.noise(4, 11) - 0.7, 0, 0.6)
    picture = picture + 0.22 * dry[..., None] * np.array([1.0, 0.75, 0.25], np.float32)
    daisies = (canvas.noise(110) > 2.3) & (canvas.noise(5) > 0.4)
    return mix(daisies, np.array([0.93, 0.93, 0.86]), picture)


def meadow(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Pasture seen from afar: clumps and mown strips."""
    strips = np.sin(2 * np.pi * 6 * canvas.u + 0.5 * canvas.noise(4))
    brightness = 1 + 0.05 * strips + 0.13 * canvas.noise(5, 11) + 0.10 * canvas.noise(40, 90)
    return shade(rgb, brightness)


def crops(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Rows of plants on earth, with tracks of a tractor."""
    rows = np.sin(2 * np.pi * 16 * canvas.u + 0.3 * canvas.noise(6))
    green = shade(rgb, 0.98 + 0.14 * canvas.noise(40, 90) + 0.10 * canvas.noise(4, 9))
    earth = shade(np.array([0.42, 0.34, 0.24]), 1 + 0.1 * canvas.noise(64))
    picture = mix(np.clip(0.78 + 0.5 * rows, 0, 1), green, earth)
    # Two tracks at the spacing of a tractor's wheels.
    track = np.minimum(np.abs(canvas.u - 0.40), np.abs(canvas.u - 0.52)) < 0.018
    return mix(track, earth, picture)


def water(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Ripples that catch the sky."""
    swell = canvas.noise((5, 9), (9, 16))
    ripples = canvas.noise((16, 34), (30, 64))
    # Only crests of the waves mirror the sky.
    crest = np.clip(0.6 * swell + 0.8 * ripples - 0.6, 0, 1.2)
    picture = shade(rgb, 0.95 + 0.12 * swell + 0.11 * ripples)
    return picture + 0.17 * crest[..., None] * np.array([0.75, 0.9, 1.0])


def sand(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Wind ripples and grains."""
    ripples = np.sin(2 * np.pi * (9 * canvas.v + 0.5 * canvas.noise(3, 6)))
    return shade(rgb, 1 + 0.06 * ripples + 0.05 * canvas.noise(8) + 0.07 * canvas.noise(128))


def leaves(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Foliage: lit leaves over dark gaps between twigs."""
    edge, tone = canvas.cells(20)
    small_edge, small_tone = canvas.cells(40)
    clumps = canvas.noise(4, 8)
    lit = 0.62 + 0.62 * tone + 0.25 * clumps
    lit = lit * np.clip(0.55 + 2.2 * edge, 0.55, 1.0) * (0.82 + 0.45 * small_tone)
    gap = (small_edge < 0.04) & (clumps < 0.2)
    picture = shade(rgb, np.clip(np.where(gap, 0.55 * lit, lit), 0.40, 1.75))
    # Leaves in the sun are yellower.
    return picture + np.clip(lit - 1.0, 0, 0.5)[..., None] * np.array([0.22, 0.19, 0.0])


def bark(canvas: Canvas, rgb: np.ndarray) -> Picture:
    """Ridges along the trunk."""
    ridges = canvas.noise((22, 4), (40, 7))
    return shade(rgb, np.clip(1 + 0.30 * ridges + 0.08 * canvas.noise(64), 0.4, 1.7))
