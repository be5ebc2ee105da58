"""Points and boxes, plainly."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from aeroscene.scene.box import rotation_matrix


def signed_distance(
    points_enu_m: ArrayLike, p: ArrayLike, q: ArrayLike, s: ArrayLike
) -> Float[np.ndarray, "*batch"]:
    """Distance from points to the surface of boxes, negative inside, m; broadcasts."""
    offset = np.asarray(points_enu_m, dtype=float) - np.asarray(p, dtype=float)
    local = np.einsum("...ji,...j->...i", rotation_matrix(q), offset)
    excess = np.abs(local) - 0.5 * np.asarray(s, dtype=float)
    outside = np.linalg.norm(np.maximum(excess, 0.0), axis=-1)
    return outside + np.minimum(excess.max(axis=-1), 0.0)
