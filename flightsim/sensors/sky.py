"""The sky as both camera renderers paint it where nothing is seen."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, UInt8

HORIZON_RGB = (0.80, 0.87, 0.93)
ZENITH_RGB = (0.28, 0.50, 0.82)

_HORIZON = np.array(HORIZON_RGB, dtype=np.float32)
_ZENITH = np.array(ZENITH_RGB, dtype=np.float32)


def sky_rgb(rays_enu: Float[np.ndarray, "n 3"]) -> UInt8[np.ndarray, "n 3"]:
    """Colour of the sky along rays of any length: from the horizon's up to the zenith's."""
    squared = np.einsum("ij,ij->i", rays_enu, rays_enu)
    height = np.clip(rays_enu[:, 2] / np.sqrt(squared), 0.0, 1.0)
    blend = np.sqrt(height)[:, None]
    return (255.0 * (_HORIZON + blend * (_ZENITH - _HORIZON)) + 0.5).astype(np.uint8)
