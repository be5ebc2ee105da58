"""A plan with one street that bends through the site in straight pieces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from math import cos, pi, radians, sin, tan

import numpy as np

from aeroscene.corpus.curation.builder import Builder, Placed
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.parcels import Parcel
from aeroscene.corpus.curation.site import ROAD_M, SIDEWALK_M, Site

_LIFT_M = 0.004
"""Every other piece lies this much higher, so that no two surfaces coincide at a bend."""
_DEPTHS_M = (30.0, 27.0, 24.0, 21.0, 18.5, 16.0, 14.0)
_SHARES = (1.0, 0.88, 0.75, 0.62)
_SHIFTS = (0.0, -0.08, 0.08, -0.16, 0.16)
_LEAST_WIDTH_M = 15.0
_PIECE_M = 24.0
"""Least length of a piece of street."""
_AIR_M = 10.0


@dataclass(frozen=True, slots=True)
class _Bend:
    """The middle line of a street: pieces of equal length that turn by equal angles."""

    pieces: tuple[Frame, ...]
    length: float
    turn: float

    def reach(self, offset: float) -> float:
        """Excess length of a strip's outer edge over its middle line at a bend, m."""
        return offset * tan(abs(self.turn) / 2)


def lay_curve(site: Site, rng: np.random.Generator) -> None:
    """A bent street with sidewalks, and parcels square to its pieces."""
    bend = _draw_bend(site, rng)
    _pave_bend(site, bend)
    taken = Builder("plan")
    for strip in (*(road.placed for road in site.roads), *site.sidewalks):
        taken.reserve(strip.frame, (*strip.size[:2], _AIR_M), 0.0)
    outer = -1 if bend.turn > 0 else 1
    for side, piece in product((outer, -outer), bend.pieces):
        for frame, width, depth in _frontages(site, bend, piece, side):
            at = site.world(frame)
            box = (width - 0.02, depth - 0.02, _AIR_M)
            if taken.is_free(at.moved(0, depth / 2), box, 0.0):
                taken.reserve(at.moved(0, depth / 2), (width, depth, _AIR_M), 0.0)
                site.parcels.append(Parcel(at, width, depth))
                break


def _draw_bend(site: Site, rng: np.random.Generator) -> _Bend:
    """An arc from the western to the eastern border, in two to four pieces."""
    count = max(2, min(4, int(2 * site.half_x / _PIECE_M)))
    turn = float(rng.choice([-1, 1])) * radians(float(rng.uniform(17, 24)))
    middle = (count - 1) / 2
    headings = [turn * (index - middle) for index in range(count)]
    margin = site.road_m / 2 * abs(sin(headings[0])) + site.walk_m
    length = 2 * (site.half_x - margin) / sum(cos(heading) for heading in headings)
    sagitta = abs(turn) / turn * length * sum(sin(abs(h)) for h in headings) / 2
    x, y = -(site.half_x - margin), sagitta / 2 + float(rng.uniform(-0.15, 0.15)) * site.half_y
    pieces: list[Frame] = []
    for heading in headings:
        dx, dy = length * cos(heading), length * sin(heading)
        pieces.append(Frame(x + dx / 2, y + dy / 2, heading))
        x, y = x + dx, y + dy
    return _Bend(tuple(pieces), length, turn)


def _pave_bend(site: Site, bend: _Bend) -> None:
    """Carriageways and sidewalks; each continues the one before, so that bends leave no gap."""
    half = site.road_m / 2
    road: Placed | None = None
    walks: dict[int, Placed | None] = {-1: None, 1: None}
    for index, piece in enumerate(bend.pieces):
        lift = _LIFT_M * (index % 2)
        shift, extra = _extra(bend, index, bend.reach(half))
        frame = piece.moved(shift, 0)
        length = bend.length + extra
        road = site.lay_road(frame, length, after=road, height=ROAD_M + lift)
        for side in (-1, 1):
            is_outer = (side > 0) != (bend.turn > 0)
            reach = bend.reach(half + site.walk_m if is_outer else -half)
            shift, extra = _extra(bend, index, reach)
            kerb = piece.moved(shift, side * half, 0.0 if side > 0 else pi)
            walks[side] = site.lay_sidewalk(
                kerb, bend.length + extra, after=walks[side], height=SIDEWALK_M + lift
            )


def _extra(bend: _Bend, index: int, reach: float) -> tuple[float, float]:
    """Shift and growth of a piece that reaches over the bends at its ends."""
    before = reach if index > 0 else 0.0
    after = reach if index < len(bend.pieces) - 1 else 0.0
    return (after - before) / 2, before + after


def _frontages(
    site: Site, bend: _Bend, piece: Frame, side: int
) -> Iterator[tuple[Frame, float, float]]:
    """Rectangles along a piece that keep within the plan, the largest first."""
    found: list[tuple[float, Frame, float, float]] = []
    v = side * (site.road_m / 2 + site.walk_m)
    for share, shift, depth in product(_SHARES, _SHIFTS, _DEPTHS_M):
        width = round(share * bend.length, 2)
        frame = piece.moved(shift * bend.length, v, 0.0 if side > 0 else pi)
        if width >= _LEAST_WIDTH_M and _is_inside(site, frame, width, depth):
            found.append((-width * depth + abs(shift) * bend.length, frame, width, depth))
    for _, frame, width, depth in sorted(found, key=lambda row: row[0]):
        yield frame, width, depth


def _is_inside(site: Site, frame: Frame, width: float, depth: float) -> bool:
    corners = [frame.point(su * width / 2, v) for su in (-1, 1) for v in (0.0, depth)]
    return all(abs(x) <= site.half_x and abs(y) <= site.half_y for x, y in corners)
