"""Materials by name: colour, texture, friction.

A texture is the name of a pattern that the colour tints (`flightsim.looks.textures` paints them);
`texture_size_m` is the part of a surface that one tile of it covers. A renderer draws the textures
that it knows.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

FACADE_BAY_M = (3.0, 3.2)
"""Width and height of one bay of a painted facade: a window and the wall about it, m."""
# A tile of a facade has two bays by two.
_TWO_BAYS_M = (2 * FACADE_BAY_M[0], 2 * FACADE_BAY_M[1])


@dataclass(frozen=True, slots=True)
class Material:
    """Look and grip of a surface."""

    name: str
    rgba: tuple[float, float, float, float]
    texture: str | None = None
    texture_size_m: tuple[float, float] = (1.0, 1.0)
    """Length and height that one tile of the texture covers."""
    friction: float = 0.8
    """Sliding friction coefficient."""
    specular: float = 0.1
    """0 matt to 1."""


def _grey(level: float) -> tuple[float, float, float, float]:
    return (level, level, level, 1.0)


def _facade(name: str, red: float, green: float, blue: float) -> Material:
    return Material(f"facade_{name}", (red, green, blue, 1.0), "punched", _TWO_BAYS_M)


def _plaster(name: str, red: float, green: float, blue: float) -> Material:
    return Material(f"plaster_{name}", (red, green, blue, 1.0), "plaster", (3.0, 3.0), 0.8, 0.0)


def _paint(name: str, red: float, green: float, blue: float) -> Material:
    return Material(f"paint_{name}", (red, green, blue, 1.0), "paint", (2.0, 2.0), 0.6, 0.6)


def _fabric(name: str, red: float, green: float, blue: float) -> Material:
    return Material(f"fabric_{name}", (red, green, blue, 1.0), "fabric", (0.8, 0.8), 0.9, 0.0)


WALL_COLOURS = ("cream", "sand", "rose", "sky", "sage", "white", "ochre", "slate")
"""Colours of facades and of plaster."""
PAINT_COLOURS = ("red", "blue", "white", "silver", "black", "green", "yellow", "orange")
"""Colours of vehicles, containers and doors."""
FABRIC_COLOURS = ("teal", "rust", "navy", "beige", "moss", "plum")
"""Colours of upholstery and bedding."""

# In the order of the names above.
_WALL_RGB = (
    (0.93, 0.88, 0.76),
    (0.86, 0.76, 0.60),
    (0.88, 0.68, 0.62),
    (0.68, 0.78, 0.87),
    (0.70, 0.79, 0.66),
    (0.94, 0.94, 0.92),
    (0.88, 0.70, 0.38),
    (0.55, 0.60, 0.66),
)
_PAINT_RGB = (
    (0.72, 0.10, 0.10),
    (0.12, 0.28, 0.62),
    (0.92, 0.92, 0.90),
    (0.62, 0.65, 0.68),
    (0.10, 0.10, 0.12),
    (0.14, 0.40, 0.24),
    (0.92, 0.74, 0.12),
    (0.88, 0.42, 0.10),
)
_FABRIC_RGB = (
    (0.16, 0.46, 0.47),
    (0.66, 0.32, 0.20),
    (0.17, 0.22, 0.40),
    (0.80, 0.73, 0.60),
    (0.40, 0.46, 0.26),
    (0.42, 0.22, 0.38),
)

# Name, colour, texture, size of a tile (m), friction, shine.
_PLAIN = (
    Material("asphalt", _grey(0.34), "asphalt", (4.0, 4.0), 1.0, 0.0),
    Material("concrete", (0.70, 0.69, 0.66, 1.0), "concrete", (4.0, 4.0), 0.9, 0.0),
    Material("dark_concrete", (0.48, 0.48, 0.48, 1.0), "concrete", (4.0, 4.0), 0.9, 0.0),
    Material("paving", (0.76, 0.73, 0.69, 1.0), "paving", (1.2, 1.2), 0.9, 0.0),
    Material("red_paving", (0.72, 0.52, 0.44, 1.0), "paving", (0.8, 0.8), 0.9, 0.0),
    Material("gravel", (0.66, 0.62, 0.55, 1.0), "gravel", (2.0, 2.0), 0.8, 0.0),
    Material("grass", (0.38, 0.53, 0.27, 1.0), "grass", (8.0, 8.0), 0.8, 0.0),
    Material("soil", (0.36, 0.26, 0.18, 1.0), "soil", (1.6, 1.6), 0.8, 0.0),
    Material("water", (0.20, 0.42, 0.55, 1.0), "water", (8.0, 8.0), 0.4, 0.8),
    Material("brick", (0.72, 0.42, 0.33, 1.0), "brick", (1.0, 0.9), 0.9, 0.0),
    Material("roof_red", (0.68, 0.30, 0.22, 1.0), "roof_tiles", (1.5, 1.5), 0.8, 0.05),
    Material("roof_slate", (0.36, 0.39, 0.44, 1.0), "roof_tiles", (1.5, 1.5), 0.8, 0.05),
    Material("roofing", (0.55, 0.54, 0.52, 1.0), "felt", (4.0, 4.0), 0.9, 0.0),
    Material("corrugated", (0.68, 0.71, 0.73, 1.0), "corrugated", (2.0, 2.0), 0.6, 0.4),
    Material("wood", (0.66, 0.46, 0.28, 1.0), "wood", (1.5, 1.5), 0.7, 0.05),
    Material("dark_wood", (0.40, 0.26, 0.16, 1.0), "wood", (1.5, 1.5), 0.7, 0.05),
    Material("pale_wood", (0.84, 0.72, 0.54, 1.0), "wood", (1.5, 1.5), 0.7, 0.05),
    Material("parquet", (0.72, 0.53, 0.34, 1.0), "parquet", (1.6, 1.6), 0.7, 0.2),
    Material("floor_tiles", (0.86, 0.86, 0.83, 1.0), "tiles", (1.2, 1.2), 0.7, 0.3),
    Material("carpet", (0.46, 0.48, 0.55, 1.0), "carpet", (1.0, 1.0), 1.0, 0.0),
    Material("bark", (0.40, 0.30, 0.22, 1.0), "bark", (0.8, 1.2), 0.9, 0.0),
    Material("leaves", (0.36, 0.56, 0.22, 1.0), "leaves", (1.5, 1.5), 0.8, 0.0),
    Material("leaves_dark", (0.22, 0.43, 0.22, 1.0), "leaves", (1.5, 1.5), 0.8, 0.0),
    Material("leaves_autumn", (0.80, 0.50, 0.16, 1.0), "leaves", (1.5, 1.5), 0.8, 0.0),
    Material("leaves_light", (0.46, 0.60, 0.28, 1.0), "leaves", (1.5, 1.5), 0.8, 0.0),
    Material("blossom", (0.90, 0.62, 0.70, 1.0), "leaves", (1.0, 1.0), 0.8, 0.0),
    Material("blossom_yellow", (0.93, 0.77, 0.22, 1.0), "leaves", (1.0, 1.0), 0.8, 0.0),
    Material("blossom_red", (0.80, 0.20, 0.18, 1.0), "leaves", (1.0, 1.0), 0.8, 0.0),
    Material("birch_bark", (0.86, 0.85, 0.81, 1.0), "plaster", (0.8, 0.8), 0.9, 0.0),
    Material("hedge", (0.28, 0.47, 0.22, 1.0), "leaves", (1.2, 1.2), 0.8, 0.0),
    Material("glass", (0.45, 0.60, 0.70, 1.0), "glass", (2.0, 2.2), 0.4, 0.9),
    Material("dark_glass", (0.16, 0.21, 0.26, 1.0), "glass", (1.6, 1.8), 0.4, 0.9),
    Material("metal", (0.62, 0.64, 0.66, 1.0), "metal", (1.0, 1.0), 0.6, 0.5),
    Material("dark_metal", (0.26, 0.27, 0.30, 1.0), "metal", (1.0, 1.0), 0.6, 0.4),
    Material("rubber", (0.10, 0.10, 0.11, 1.0), "rubber", (0.5, 0.5), 1.1, 0.05),
    Material("plastic_white", (0.92, 0.92, 0.92, 1.0), "plastic", (1.0, 1.0), 0.6, 0.3),
    Material("plastic_black", (0.11, 0.11, 0.12, 1.0), "plastic", (0.6, 0.6), 0.6, 0.3),
    Material("plastic_green", (0.16, 0.38, 0.20, 1.0), "plastic", (0.8, 0.8), 0.6, 0.3),
    Material("cardboard", (0.68, 0.52, 0.34, 1.0), "cardboard", (0.6, 0.6), 0.7, 0.0),
    Material("ceramic", (0.95, 0.94, 0.91, 1.0), "ceramic", (0.3, 0.3), 0.6, 0.5),
    # No texture: a smooth surface.
    Material("enamel", (0.95, 0.95, 0.94, 1.0), None, (1.0, 1.0), 0.5, 0.6),
    Material("stone", (0.80, 0.78, 0.74, 1.0), "ashlar", (2.4, 2.4), 0.7, 0.3),
    Material("terracotta", (0.74, 0.42, 0.28, 1.0), "plaster", (1.0, 1.0), 0.8, 0.0),
    Material("solar", (0.16, 0.22, 0.42, 1.0), "solar", (1.0, 1.0), 0.5, 0.7),
    Material("screen", (0.10, 0.16, 0.26, 1.0), "screen", (0.6, 0.4), 0.5, 0.8),
    Material("marking_white", (0.93, 0.93, 0.93, 1.0), "worn_paint", (1.5, 1.5), 0.9, 0.0),
    Material("marking_yellow", (0.95, 0.78, 0.15, 1.0), "worn_paint", (1.5, 1.5), 0.9, 0.0),
    Material("light_warm", (1.0, 0.93, 0.72, 1.0), None, (1.0, 1.0), 0.6, 0.5),
    Material("light_red", (0.85, 0.12, 0.10, 1.0), None, (1.0, 1.0), 0.6, 0.5),
    Material("light_green", (0.10, 0.75, 0.30, 1.0), None, (1.0, 1.0), 0.6, 0.5),
    Material("facade_brick", (0.72, 0.42, 0.33, 1.0), "brickwork", _TWO_BAYS_M),
    Material("stone_wall", (0.70, 0.65, 0.57, 1.0), "stone_wall", (2.4, 2.4), 0.9, 0.0),
    Material("cobbles", (0.60, 0.58, 0.55, 1.0), "cobbles", (1.4, 1.4), 0.9, 0.0),
    Material("sand", (0.84, 0.75, 0.56, 1.0), "sand", (3.0, 3.0), 0.8, 0.0),
    Material("timber", (0.62, 0.45, 0.30, 1.0), "boards", (2.4, 1.6), 0.7, 0.0),
    Material("timber_white", (0.90, 0.89, 0.85, 1.0), "boards", (2.4, 1.6), 0.7, 0.0),
    Material("timber_red", (0.58, 0.20, 0.16, 1.0), "boards", (2.4, 1.6), 0.7, 0.0),
    Material("cladding_grey", (0.60, 0.63, 0.66, 1.0), "cladding", (3.0, 3.2), 0.6, 0.3),
    Material("cladding_white", (0.90, 0.91, 0.91, 1.0), "cladding", (3.0, 3.2), 0.6, 0.3),
    Material("cladding_blue", (0.30, 0.42, 0.56, 1.0), "cladding", (3.0, 3.2), 0.6, 0.3),
    Material("ceiling", (0.92, 0.92, 0.90, 1.0), "ceiling", (2.4, 2.4), 0.8, 0.0),
    Material("wallpaper", (0.80, 0.76, 0.66, 1.0), "wallpaper", (1.2, 1.2), 0.8, 0.0),
    Material("wall_tiles", (0.78, 0.87, 0.88, 1.0), "tiles", (0.8, 0.8), 0.7, 0.3),
    Material("paper", (0.90, 0.87, 0.78, 1.0), "print", (0.3, 0.4), 0.7, 0.0),
)


def _build() -> dict[str, Material]:
    materials = list(_PLAIN)
    for name, rgb in zip(WALL_COLOURS, _WALL_RGB, strict=True):
        materials += [_facade(name, *rgb), _plaster(name, *rgb)]
    materials += [_paint(name, *rgb) for name, rgb in zip(PAINT_COLOURS, _PAINT_RGB, strict=True)]
    materials += [
        _fabric(name, *rgb) for name, rgb in zip(FABRIC_COLOURS, _FABRIC_RGB, strict=True)
    ]
    return {material.name: material for material in materials}


MATERIALS: Mapping[str, Material] = _build()
"""Every material that a shape may name."""
