"""Paint of a surface: a pattern in a colour."""

from __future__ import annotations

from dataclasses import dataclass, replace

from aeroscene.solids.shapes import MATERIALS

Colour = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Paint:
    """Pattern in a colour, for surfaces of any size; equal paints share a skin."""

    texture: str | None
    """Name of a pattern; None for plain colour."""
    rgb: Colour
    size_m: tuple[float, float] = (1.0, 1.0)
    """Length and height of one tile."""
    is_fitted: bool = False
    """True if one tile covers each face, however large."""
    is_clear: bool = False
    """True if sunlight passes through, as through glass."""
    is_lamp: bool = False
    """True if it emits light, or has enough lamps to count as emitting."""
    is_lit_within: bool = False
    """True if lamps shine behind its windows; the picture then has its own light."""

    def tinted(self, factors: Colour) -> Paint:
        """Return the same pattern in another colour, at most white."""
        red, green, blue = (min(1.0, c * f) for c, f in zip(self.rgb, factors, strict=True))
        return replace(self, rgb=(red, green, blue))

    def with_texture(self, texture: str, size_m: tuple[float, float]) -> Paint:
        """Return paint with another pattern in the same colour.

        Args:
            texture: Name of the pattern.
            size_m: Width and height of one tile on the surface.
        """
        return replace(self, texture=texture, size_m=size_m)


def material_paint(name: str) -> Paint:
    """Return the paint of a material in the catalogue of materials."""
    material = MATERIALS[name]
    red, green, blue, _ = material.rgba
    return Paint(
        material.texture,
        (red, green, blue),
        material.texture_size_m,
        is_fitted=material.texture == "screen",
        is_clear=name == "glass",
        is_lamp=name == "ceiling" or name.startswith("light_"),
    )
