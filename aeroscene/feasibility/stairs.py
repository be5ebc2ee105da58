"""Stairs and the levels to which they lead: they stay together, or the stairs are dropped."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from aeroscene.feasibility.boxes import Boxes
from aeroscene.feasibility.layout import Layout
from aeroscene.scene.catalogue import BRIDGES, LEVELS, STAIRS
from aeroscene.solids.shapes.structures import RAIL_M

REACH_M = 0.5
"""Greatest distance between the top of stairs and the level to which they lead."""
STEP_M = 0.25
"""Largest step between the top of stairs and the level to which they lead."""


@dataclass(frozen=True, slots=True)
class Landing:
    """Upper end of stairs: its level, and its place there."""

    stairs: int
    level: int
    share: Float[np.ndarray, " 2"]
    """The nearest point of the level, in its own frame, divided by half its extents."""
    away_m: Float[np.ndarray, " 2"]
    """Vector from there to the middle of the stairs, in the frame of the level."""


def landings_of(layout: Layout) -> list[Landing]:
    """Find the level to which each flight of stairs leads; stairs without one are left out."""
    found: list[Landing] = []
    for stairs in layout.rows(STAIRS):
        best = (REACH_M, -1)
        for level in layout.rows(LEVELS):
            best = min(best, (_gap_m(layout, stairs, level), level))
        if best[1] >= 0:
            found.append(_landing(layout.boxes, stairs, best[1]))
    return found


def follow_levels(layout: Layout, landings: list[Landing]) -> None:
    """Move stairs with all that they carry to the present place of their level.

    Args:
        layout: Layout; changed.
        landings: Landings before the levels moved.
    """
    boxes = layout.boxes
    for each in landings:
        if not (layout.is_present[each.stairs] and layout.is_present[each.level]):
            continue
        # The share scales with the level: stairs stay at its edge after a cut.
        point = each.share * boxes.half_m[each.level, :2] + each.away_m
        wanted = boxes.centre_m[each.level, :2] + boxes.frame(each.level).T @ point
        shift = wanted - boxes.centre_m[each.stairs, :2]
        layout.shift(each.stairs, np.array([*shift, 0.0]))


def drop_lost(layout: Layout, landings: list[Landing]) -> None:
    """Drop stairs that led somewhere and no longer do.

    Args:
        layout: Layout; changed.
        landings: Landings before the projection.
    """
    leading = {each.stairs for each in landings_of(layout)}
    for each in landings:
        if layout.is_present[each.stairs] and each.stairs not in leading:
            layout.drop(each.stairs)


def _gap_m(layout: Layout, stairs: int, level: int) -> float:
    """Distance from the top of stairs to a level in the plane, m; infinite at another height."""
    boxes = layout.boxes
    # A bridge's box ends at its rail, people walk on the deck below.
    rail_m = RAIL_M if layout.objects[level].category in BRIDGES else 0.0
    if abs(boxes.top_m[stairs] - boxes.top_m[level] + rail_m) > STEP_M:
        return np.inf
    half_m = boxes.half_m[stairs]
    # The front edge (+x) of the highest step, by three points.
    edge = np.array([[half_m[0], side * half_m[1]] for side in (-1.0, 0.0, 1.0)])
    points = boxes.centre_m[stairs, :2] + edge @ boxes.frame(stairs)
    beside = (points - boxes.centre_m[level, :2]) @ boxes.frame(level).T
    beyond = np.maximum(np.abs(beside) - boxes.half_m[level, :2], 0.0)
    return float(np.hypot(*beyond.T).min())


def _landing(boxes: Boxes, stairs: int, level: int) -> Landing:
    half_m = boxes.half_m[level, :2]
    top = boxes.centre_m[stairs, :2] + np.array([boxes.half_m[stairs, 0], 0.0]) @ boxes.frame(
        stairs
    )
    nearest = np.clip(boxes.frame(level) @ (top - boxes.centre_m[level, :2]), -half_m, half_m)
    middle = boxes.frame(level) @ (boxes.centre_m[stairs, :2] - boxes.centre_m[level, :2])
    return Landing(stairs, level, nearest / half_m, middle - nearest)
