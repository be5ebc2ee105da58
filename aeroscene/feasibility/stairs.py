"""Stairs and the levels that they lead to: they stay together, or the stairs go."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from aeroscene.feasibility.boxes import Boxes
from aeroscene.feasibility.layout import Layout
from aeroscene.scene.catalogue import BRIDGES, LEVELS, STAIRS
from aeroscene.solids.shapes.structures import RAIL_M

REACH_M = 0.5
"""Farthest that a level begins from the top of the stairs that lead to it."""
STEP_M = 0.25
"""Largest step between the top of stairs and the level that they lead to."""


@dataclass(frozen=True, slots=True)
class Landing:
    """Where stairs end: which level, and where on it."""

    stairs: int
    level: int
    share: Float[np.ndarray, " 2"]
    """The nearest point of the level, in its own frame over half its extents."""
    away_m: Float[np.ndarray, " 2"]
    """From there to the middle of the stairs, in the frame of the level."""


def landings_of(layout: Layout) -> list[Landing]:
    """The level that each flight of stairs leads to; those that lead nowhere are left out."""
    found: list[Landing] = []
    for stairs in layout.rows(STAIRS):
        best = (REACH_M, -1)
        for level in layout.rows(LEVELS):
            best = min(best, (_gap_m(layout, stairs, level), level))
        if best[1] >= 0:
            found.append(_landing(layout.boxes, stairs, best[1]))
    return found


def follow_levels(layout: Layout, landings: list[Landing]) -> None:
    """Bring stairs to where their levels are now, with all that they carry."""
    boxes = layout.boxes
    for each in landings:
        if not (layout.is_left[each.stairs] and layout.is_left[each.level]):
            continue
        point = each.share * boxes.half_m[each.level, :2] + each.away_m
        wanted = boxes.centre_m[each.level, :2] + boxes.frame(each.level).T @ point
        shift = wanted - boxes.centre_m[each.stairs, :2]
        layout.shift(each.stairs, np.array([*shift, 0.0]))


def drop_lost(layout: Layout, landings: list[Landing]) -> None:
    """Take out the stairs that led somewhere and no longer do."""
    leading = {each.stairs for each in landings_of(layout)}
    for each in landings:
        if layout.is_left[each.stairs] and each.stairs not in leading:
            layout.drop(each.stairs)


def _gap_m(layout: Layout, stairs: int, level: int) -> float:
    """From the top of stairs to a level in the plane; infinite at another height."""
    boxes = layout.boxes
    rail_m = RAIL_M if layout.objects[level].category in BRIDGES else 0.0
    if abs(boxes.top_m[stairs] - boxes.top_m[level] + rail_m) > STEP_M:
        return np.inf
    half_m = boxes.half_m[stairs]
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
