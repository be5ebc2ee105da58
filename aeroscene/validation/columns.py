"""Intervals of vertical lines within solids, exact for every kind of solid.

Support, claims and sunk objects ask for the height of a surface at points. Solids are convex, so a
line is inside of each for one interval at most.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from aeroscene.solids.solids import Solids, hull_faces

_FLAT = 1e-12


def spans(
    solids: Solids, index: int, points_enu_m: Float[np.ndarray, "n 2"]
) -> Float[np.ndarray, "n 2"]:
    """Heights at which vertical lines enter and leave a solid.

    Args:
        solids: Solids of a scene.
        index: Number of the solid.
        points_enu_m: Points through which the lines pass.

    Returns:
        Lower and upper height for each line, m; NaN if it misses the solid.
    """
    rotation, centre = solids.rotation[index], solids.centre_m[index]
    # A vertical line through each point, in the frame of the solid.
    offset = np.column_stack([points_enu_m - centre[:2], np.zeros(len(points_enu_m))])
    origin, direction = offset @ rotation, rotation[2]
    half = solids.half_m[index]
    if solids.is_mesh[index]:
        planes = hull_faces(solids.primitives[index].vertices_m).planes
        span = _between(origin @ planes[:, :3].T + planes[:, 3], planes[:, :3] @ direction)
    elif solids.is_box[index]:
        span = _slabs(origin, direction, half, (0, 1, 2))
    elif solids.is_cylinder[index]:
        scale = np.array([half[0], half[0], np.inf])
        span = _meet(
            _ball(origin / scale, direction / scale), _slabs(origin, direction, half, (2,))
        )
    else:
        span = _ball(origin / half, direction / half)
    # Written so that NaN counts as a miss, too.
    span[~(span[:, 0] <= span[:, 1])] = np.nan
    return span + centre[2]


def _between(height: np.ndarray, rate: np.ndarray) -> Float[np.ndarray, "n 2"]:
    """Interval with `height + t * rate <= 0` for all planes, by lines (rows), planes (columns)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        t = -height / rate
    is_up, is_down = rate > _FLAT, rate < -_FLAT
    high = np.where(is_up, t, np.inf).min(axis=1)
    low = np.where(is_down, t, -np.inf).max(axis=1)
    # Parallel to a plane and on its outer side: the line misses the solid.
    is_beside = ((np.abs(rate) <= _FLAT) & (height > _FLAT)).any(axis=1)
    return np.column_stack([np.where(is_beside, np.inf, low), high])


def _slabs(
    origin: np.ndarray, direction: np.ndarray, half: np.ndarray, axes: tuple[int, ...]
) -> Float[np.ndarray, "n 2"]:
    heights = [sign * origin[:, i] - half[i] for i in axes for sign in (1, -1)]
    rates = [sign * direction[i] for i in axes for sign in (1, -1)]
    return _between(np.column_stack(heights), np.array(rates))


def _ball(origin: np.ndarray, direction: np.ndarray) -> Float[np.ndarray, "n 2"]:
    """Interval of lines in the unit ball; a component that is zero throughout does not count."""
    a = float(direction @ direction)
    c = (origin**2).sum(axis=1) - 1.0
    # A line along the axis of a cylinder is inside for good, or never.
    if a < _FLAT:
        inside = np.where(c <= 0, np.inf, -np.inf)
        return np.column_stack([-inside, inside])
    b = origin @ direction
    with np.errstate(invalid="ignore"):
        root = np.sqrt(b**2 - a * c)
    return np.column_stack([-b - root, -b + root]) / a


def _meet(first: np.ndarray, second: np.ndarray) -> Float[np.ndarray, "n 2"]:
    return np.column_stack(
        [np.maximum(first[:, 0], second[:, 0]), np.minimum(first[:, 1], second[:, 1])]
    )
