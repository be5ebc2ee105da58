"""Light as one number per point: 0 in the deepest shade, 1 in full sun.

Both renderers convert it to colour by `light_rgb`. OpenGL has no such number per mesh point, but
computes one from a normal, the cosine to the sun: `normals_for_light` gives the normal that yields
the number. Shade, shadows and lamps thus cost nothing when a picture is drawn.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

SUN_DIRECTION = (0.602, 0.341, -0.722)
"""Direction of sunlight, ENU, of unit length: afternoon, 46 degrees high."""
AMBIENT_RGB = (0.30, 0.33, 0.38)
"""Colour of light 0."""
SUN_RGB = (0.76, 0.71, 0.63)
"""Colour added at light 1."""

_SKY_SHARE = 0.30
_SUN_SHARE = 0.90
_TO_SUN = -np.array(SUN_DIRECTION)
_ACROSS_SUN = np.cross(_TO_SUN, (0.0, 0.0, 1.0))
_ACROSS_SUN /= np.linalg.norm(_ACROSS_SUN)

Normals = Float[np.ndarray, "*n 3"]
Shares = Float[np.ndarray, "*n"]


def surface_light(normals_enu: Normals, sun: Shares, sky: Shares) -> Shares:
    """Return the light on surfaces, 0 to 1.

    Args:
        normals_enu: Outward unit normals.
        sun: Visible share of the sun, 0 to 1.
        sky: Share of the sky not hidden by roofs; under roofs there are lamps.
    """
    up = normals_enu[..., 2]
    from_sky = _SKY_SHARE * (0.5 + 0.5 * up)
    # Walls differ in brightness, so that corners of a room are visible.
    from_lamps = 0.47 + 0.10 * up + 0.09 * (normals_enu @ np.array([0.8, -0.6, 0.0]))
    # Undersides indoors are ceilings, which are bright.
    from_lamps = from_lamps + 0.20 * np.clip(-up, 0.0, 1.0)
    from_sun = _SUN_SHARE * np.maximum(0.0, normals_enu @ _TO_SUN)
    return np.clip(sky * from_sky + (1.0 - sky) * from_lamps + sun * from_sun, 0.0, 1.0)


def light_rgb(light: Shares) -> Float[np.ndarray, "*n 3"]:
    """Return colour factors of surfaces, at most 1.

    Args:
        light: Light of each surface, 0 in the deepest shade, 1 in full sun.
    """
    ambient, sun = np.array(AMBIENT_RGB, light.dtype), np.array(SUN_RGB, light.dtype)
    return np.minimum(1.0, ambient + light[..., None] * sun)


def normals_for_light(light: Shares) -> Normals:
    """Return unit normals whose cosine to the sun is the light.

    A renderer that knows only normals then shows the light that was computed, shadows included.

    Args:
        light: Light of each surface, 0 in the deepest shade, 1 in full sun.
    """
    aside = np.sqrt(np.maximum(0.0, 1.0 - light**2))
    return light[..., None] * _TO_SUN + aside[..., None] * _ACROSS_SUN


def is_sunward(normals_enu: Normals) -> np.ndarray:
    """Return true for faces that the sun can reach at all, (...,) bool.

    Faces that the light only grazes count as turned away.
    """
    return normals_enu @ _TO_SUN > 0.05
