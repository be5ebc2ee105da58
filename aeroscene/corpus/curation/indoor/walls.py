"""Ends of the walls of a floor plan, so that they meet in corners without overlap."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

from aeroscene.corpus.curation.indoor.zones import Border, Side, Zone, barrier

PARTITION_M = 0.12
_HALF_M = PARTITION_M / 2

_Point = tuple[float, float]


def wall_spans(zones: Sequence[Zone], borders: Sequence[Border]) -> dict[int, tuple[float, float]]:
    """Start and end of each border that is a wall, under the border's number.

    Walls along y run through corners, walls along x end at their faces.
    """
    walls = [border for border in borders if barrier(zones, border) == "wall"]
    corners: dict[_Point, list[Border]] = defaultdict(list)
    for wall in walls:
        for point in _ends(wall):
            corners[point].append(wall)
    return {
        index: (border.low + _cut(border, corners, 0), border.high - _cut(border, corners, 1))
        for index, border in enumerate(borders)
        if barrier(zones, border) == "wall"
    }


def _ends(border: Border) -> tuple[_Point, _Point]:
    if border.along == "x":
        return ((border.low, border.at), (border.high, border.at))
    return ((border.at, border.low), (border.at, border.high))


def _cut(border: Border, corners: dict[_Point, list[Border]], end: int) -> float:
    """Length by which a wall is cut at its low (0) or high (1) end; negative: it is longer."""
    point = _ends(border)[end]
    met = [
        other
        for other in corners[point]
        # Only walls that share a height meet.
        if other is not border and other.base < border.top and border.base < other.top
    ]
    if border.along == "x":
        return _HALF_M if any(other.along == "y" for other in met) else 0.0
    if all(other.along == "y" for other in met):
        return 0.0
    # Two walls along y in one line meet in the corner: the upper one fills it.
    is_passed_on = end == 1 and any(
        other.along == "y" and _ends(other)[0] == point for other in met
    )
    return _HALF_M if is_passed_on else -_HALF_M


def insets(zones: Sequence[Zone], borders: Sequence[Border]) -> list[dict[Side, float]]:
    """Distance of each zone's floor from each of its sides: half a wall or nothing."""
    found: list[dict[Side, float]] = [{"x0": 0.0, "x1": 0.0, "y0": 0.0, "y1": 0.0} for _ in zones]
    for border in borders:
        if barrier(zones, border) == "open":
            continue
        for index in border.zones:
            is_upper = zones[index].level > min(zones[i].level for i in border.zones)
            if barrier(zones, border) == "wall" or not is_upper:
                found[index][border.side_of(index)] = _HALF_M
    return found
