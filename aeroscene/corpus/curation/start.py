"""Start of a flight: a pad on open ground under open sky."""

from __future__ import annotations

import math
from collections.abc import Sequence

from aeroscene.corpus.curation.builder import Builder, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import Frame
from aeroscene.scene import SceneObject

PAD_M = 2.6
FREE_RADIUS_M = 3.6
"""Half the side of the square that stays free around the pad."""
FREE_HEIGHT_M = 60.0
_OPEN_RADII_M = (11.0, 9.0, 7.0, 5.0)
"""Half the side of a square of air above the pad that stays free; the first that is free is taken.
Scripts for SDKs take off and fly some 10 m to a side without looking.
"""
_OPEN_ABOVE_M = 3.5
"""Lowest height of that air above the pad."""
# Distance between the spots that are tried, and the most whose openness is measured.
_GRID_M = 1.5
_MAX_SPOTS = 16
_KERB_M = 0.16
"""Height up to which kerbs and paths beside the pad are no obstacle."""
_GROUNDS = ("lawn", "plaza", "parking_lot")
# Tried only if no other ground has an open spot.
_LAST_RESORT = "road"


class NoStartError(RuntimeError):
    """Raised for a ground plan that leaves no open place to start from."""


def place_start(builder: Builder, draw: Draw, site_half: tuple[float, float]) -> Placed:
    """Put the home pad on a free spot of the ground, and keep the air around it free.

    Args:
        builder: Scene whose structures stand.
        draw: Randomness.
        site_half: Half sides of the site along east and north, m.

    Raises:
        NoStartError: If no spot is free of structures.
    """
    # In any order, so that starts are not always on grass.
    order = [_GROUNDS[index] for index in draw.shuffled(range(len(_GROUNDS)))]
    for name in (*order, _LAST_RESORT):
        spots = [
            (ground, u, v)
            for ground in builder.objects
            if ground.category == name
            for u, v in _grid(ground)
            if _is_open(builder, ground, u, v, site_half)
        ]
        # Measuring openness is slow, hence only for a sample of the spots.
        drawn = [spots[index] for index in draw.shuffled(range(len(spots)))[:_MAX_SPOTS]]
        for ground, u, v in sorted(drawn, key=lambda spot: -_openness_m(builder, *spot)):
            pad = _pad(builder, ground, u, v)
            if pad:
                return pad
    raise NoStartError(f"{builder.scene_id}: no free square of {2 * FREE_RADIUS_M} m to start from")


def _grid(ground: SceneObject) -> Sequence[tuple[float, float]]:
    reach_u, reach_v = (s / 2 - PAD_M / 2 - 0.3 for s in ground.bbox.s[:2])
    if min(reach_u, reach_v) < 0:
        return []
    steps_u, steps_v = (max(1, int(2 * r / _GRID_M)) for r in (reach_u, reach_v))
    return [
        (-reach_u + 2 * reach_u * i / steps_u, -reach_v + 2 * reach_v * j / steps_v)
        for i in range(steps_u + 1)
        for j in range(steps_v + 1)
    ]


def _frame(ground: SceneObject) -> Frame:
    return Frame(ground.bbox.p[0], ground.bbox.p[1], ground.bbox.yaw_rad)


def _top(ground: SceneObject) -> float:
    return ground.bbox.p[2] + ground.bbox.s[2] / 2


def _is_open(
    builder: Builder, ground: SceneObject, u: float, v: float, half: tuple[float, float]
) -> bool:
    frame = _frame(ground)
    x, y = frame.point(u, v)
    if abs(x) > half[0] - FREE_RADIUS_M or abs(y) > half[1] - FREE_RADIUS_M:
        return False
    side = 2 * FREE_RADIUS_M
    base = _top(ground) + _KERB_M
    # Above the kerbs, and up to a height that nothing in the corpus reaches.
    return builder.is_free(frame.moved(u, v), (side, side, FREE_HEIGHT_M), base)


def _openness_m(builder: Builder, ground: SceneObject, u: float, v: float) -> float:
    """Half the side of the widest free square of air above a spot, m."""
    frame, base = _frame(ground), _top(ground) + _OPEN_ABOVE_M
    for radius_m in _OPEN_RADII_M:
        if builder.is_free(frame.moved(u, v), (2 * radius_m, 2 * radius_m, FREE_HEIGHT_M), base):
            return radius_m
    return FREE_RADIUS_M


def _pad(builder: Builder, ground: SceneObject, u: float, v: float) -> Placed | None:
    bearer = Placed(
        ground.id,
        ground.category,
        _frame(ground),
        ground.bbox.s,
        _top(ground) - ground.bbox.s[2],
        "outdoor",
    )
    open_m = _openness_m(builder, ground, u, v)
    spot = bearer.frame.moved(u, v)
    look = {"is_start": True}
    pad = builder.place(
        "landing_pad", spot, (PAD_M, PAD_M, 0.05), parent=bearer, within=bearer, look=look
    )
    if pad:
        # A narrow shaft from the ground, and a wide one above the height of cars and hedges.
        for radius_m, base in ((FREE_RADIUS_M, pad.top), (open_m, bearer.top + _OPEN_ABOVE_M)):
            size = (2 * radius_m, 2 * radius_m, FREE_HEIGHT_M)
            builder.reserve(pad.frame, size, base)
    return pad


def start_yaw(pad: Placed) -> float:
    """Heading of a vehicle on the pad, towards the middle of the site.

    Returns:
        Angle from east, rad, counter-clockwise.
    """
    return math.atan2(-pad.frame.y, -pad.frame.x)
