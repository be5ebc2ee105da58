"""Reading of the segments of a line off the walls there and their openings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from aeroscene.partition.frames import Bounds
from aeroscene.partition.storeys.storey import NOBODY, OPEN, Border, Line, Segment, SegmentKind
from aeroscene.partition.tree import Axis, parts_of
from aeroscene.scene import SceneObject

# Distance of a wall's middle from its line, at most.
_ON_LINE_M = 0.015
_LEAST_M = 0.02
"""Shorter stretches are rounding."""
_ROUNDING_M = 1e-6
_DEFAULT_HEAD_M = {"door": 2.4, "window": 2.2}
_DEFAULT_SILL_M = 0.9
"""Values of a wall without these attributes; see `aeroscene.solids.shapes.shell`."""


@dataclass(frozen=True, slots=True)
class StandingWall:
    """A wall of a scene in the frame of its building."""

    obj: SceneObject
    bounds: Bounds
    quarter: int

    def moved(self, dx: float, dy: float) -> StandingWall:
        """Return the same wall in a frame with another corner."""
        x0, y0, x1, y1 = self.bounds
        return replace(self, bounds=(x0 + dx, y0 + dy, x1 + dx, y1 + dy))

    @property
    def axis(self) -> Axis:
        """Axis along which it runs: its own y."""
        return "y" if self.quarter % 2 == 0 else "x"

    @property
    def span(self) -> tuple[float, float]:
        """Begin and end along its axis."""
        x0, y0, x1, y1 = self.bounds
        return (x0, x1) if self.axis == "x" else (y0, y1)

    @property
    def middle(self) -> float:
        """Coordinate across its axis."""
        x0, y0, x1, y1 = self.bounds
        return (y0 + y1) / 2 if self.axis == "x" else (x0 + x1) / 2

    @property
    def thickness_m(self) -> float:
        """Extent along its own x."""
        return self.obj.bbox.s[0]

    @property
    def base_m(self) -> float:
        """Height of its underside."""
        return self.obj.bbox.p[2] - self.obj.bbox.s[2] / 2

    @property
    def top_m(self) -> float:
        """Height of its top."""
        return self.obj.bbox.p[2] + self.obj.bbox.s[2] / 2

    def openings(self) -> list[_Stretch]:
        """Return its door and its window, from its low end."""
        # Offsets count along the wall's own y, which points along the frame's axis after 0 or 3
        # quarter turns, and against it otherwise.
        sign = 1.0 if self.quarter in {0, 3} else -1.0
        middle = sum(self.span) / 2
        found: list[_Stretch] = []
        kinds: tuple[SegmentKind, ...] = ("door", "window")
        for kind in kinds:
            half = self._number(f"{kind}_m", 0.0) / 2
            if half > 0.0:
                at = middle + sign * self._number(f"{kind}_offset_m", 0.0)
                head = self._number(f"{kind}_height_m", _DEFAULT_HEAD_M[kind])
                sill = self._number("window_sill_m", _DEFAULT_SILL_M) if kind == "window" else 0.0
                found.append(_Stretch(kind, at - half, at + half, sill, head))
        return sorted(found, key=lambda opening: opening.low)

    def _number(self, name: str, default: float) -> float:
        value = self.obj.attributes.get(name, default)
        return float(value) if isinstance(value, (int, float)) else default


def stands_on(wall: StandingWall, line: Line, *, is_inset: bool) -> bool:
    """True if a wall stands on a line, or beyond it if nobody is there.

    Args:
        wall: The wall.
        line: The line.
        is_inset: True if walls stand on their lines; otherwise outer walls stand beyond.
    """
    low, high = wall.span
    # A wall reaches over the next line by half of the wall that it meets there, an outer one by all
    # of it. So much overlap does not mean that it stands on that line.
    reach = wall.thickness_m * (0.5 if is_inset else 1.0) + _LEAST_M
    overlap = min(high, line.high) - max(low, line.low)
    least = min(reach, (line.high - line.low) / 2, high - low - _LEAST_M)
    if wall.axis != line.axis or overlap < least:
        return False
    at = line.at
    if not is_inset and NOBODY in line.rooms:
        at += wall.thickness_m / 2 * (-1 if line.rooms[0] == NOBODY else 1)
    return abs(wall.middle - at) < _ON_LINE_M


class _Stretch(NamedTuple):
    kind: SegmentKind
    low: float
    high: float
    sill_m: float = 0.0
    head_m: float = 0.0


def read_border(line: Line, walls: Sequence[StandingWall]) -> Border:
    """Return the segments of a line.

    A wall's end at a corner counts as the line's end, because walls are cut back or longer there.
    """
    found: list[_Stretch] = []
    at = line.low
    for wall in sorted(walls, key=lambda w: w.span):
        slack = wall.thickness_m + _ON_LINE_M
        # Ends within a wall's thickness of a corner belong to the corner.
        low, high = wall.span
        low = line.low if low < line.low + slack else low
        high = line.high if high > line.high - slack else high
        if low - at > _LEAST_M:
            found.append(_Stretch("open", at, low))
            at = low
        for opening in wall.openings():
            first, last = max(opening.low, at), min(opening.high, high)
            if last - first > _LEAST_M:
                found.append(_Stretch("wall", at, first))
                found.append(opening._replace(low=first, high=last))
                at = last
        found.append(_Stretch("wall", at, high))
        at = high
    if line.high - at > _LEAST_M:
        found.append(_Stretch("open", at, line.high))
    found = [stretch for stretch in found if stretch.high - stretch.low > _ROUNDING_M]
    if not walls or not found:
        return OPEN
    parts = parts_of(
        # Rounded, so that equal doors share one width.
        [round(stretch.high - stretch.low, 7) for stretch in found],
        [stretch.kind in {"door", "window"} for stretch in found],
    )
    forms = [str(wall.obj.attributes.get("form", "")) for wall in walls]
    segments = (Segment(s.kind, p, s.sill_m, s.head_m) for s, p in zip(found, parts, strict=True))
    # The most frequent form of the walls stands for all.
    return Border(tuple(segments), max(forms, key=forms.count))
