"""Points spread evenly over a depth image, with the standard deviation of each."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from autonomy.jit import kernel
from autonomy.perception.depth_image import DepthImage, Pixels

_NEAREST_M, _FARTHEST_M = 0.2, 30.0  # depths outside of these are not used
_SURFACE_SIGMA_M = 0.05
"""Error of the map's surfaces."""
_TILT_SIGMA_RAD = 0.004
"""Error of the estimate's roll and pitch."""


def spread_points(
    image: DepthImage, n_points: int
) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, " n"]]:
    """Points relative to the camera, ENU, and each one's standard deviation from its surface, m.

    About `n_points` pixels are taken, evenly over the image, with a measurement or not.
    """
    height, width = image.depth_m.shape
    stride = max(1, round(math.sqrt(height * width / n_points)))
    return sample_points(image.pixels, stride, image.inverse_depth_sigma_pm)


@kernel
def sample_points(
    pixels: Pixels, stride: int, inverse_sigma: float
) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, " n"]]:
    """Sampled pixels as points from the camera, ENU, and the deviations of their distance, m."""
    depth, fx, fy, cx, cy, _, rotation = pixels
    most = (depth.shape[0] // stride + 1) * (depth.shape[1] // stride + 1)
    points, sigmas = np.empty((most, 3)), np.empty(most)
    n = 0
    for v in range(stride // 2, depth.shape[0], stride):
        for u in range(stride // 2, depth.shape[1], stride):
            d = float(depth[v, u])
            if not _NEAREST_M < d < _FARTHEST_M:
                continue
            x, y = d * (u - cx) / fx, d * (v - cy) / fy
            for i in range(3):
                points[n, i] = rotation[i, 0] * x + rotation[i, 1] * y + rotation[i, 2] * d
            noise = d * d * inverse_sigma
            # A tilt of the estimate moves a point in proportion to its distance.
            tilt = _TILT_SIGMA_RAD**2 * (x * x + y * y + d * d)
            sigmas[n] = math.sqrt(_SURFACE_SIGMA_M**2 + noise * noise + tilt)
            n += 1
    return points[:n], sigmas[:n]
