"""A plan with one street that winds through the site in straight pieces.

All objects are boxes, so a bend consists of straight pieces. Neighbouring pieces overlap in the
bend, as child and parent, since gaps would break the street.
"""

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
_LEAST_WIDTH_M = 13.0
_PIECE_M = 18.0
"""Least length of a piece of street."""
_DOUBLE_CHANCE = 0.4
"""Probability that a street bends one way and then the other."""
_AIR_M = 10.0


@dataclass(frozen=True, slots=True)
class _Bend:
    """The middle line of a street: pieces of equal length and the turns between them."""

    pieces: tuple[Frame, ...]
    length: float
    turns: tuple[float, ...]
    """Turn from each piece to the next, rad; positive to the left."""

    def growth(self, index: int, edges: tuple[float, float]) -> tuple[float, float]:
        """Length by which a strip along a piece extends beyond its ends to close bends.

        Args:
            index: Number of the piece.
            edges: Places of the strip's two edges, m to the left of the middle line.

        Returns:
            Lengths at the beginning and at the end, m: those of the edge on the outer side of each
            bend. They are negative if the whole strip lies on the inner side.
        """
        joints = (index - 1, index)
        before, after = (
            max(-edge * tan(self.turns[joint] / 2) for edge in edges)
            if 0 <= joint < len(self.turns)
            else 0.0
            for joint in joints
        )
        return before, after


def lay_curve(site: Site, rng: np.random.Generator) -> None:
    """Lay a bent street with sidewalks, and parcels square to its pieces."""
    bend = _draw_bend(site, rng)
    _pave_bend(site, bend)
    # A builder of its own tests for overlap, because parcels are no objects of the scene.
    taken = Builder("plan")
    for strip in (*(road.placed for road in site.roads), *site.sidewalks):
        taken.reserve(strip.frame, (*strip.size[:2], _AIR_M), 0.0)
    # Frontages on the outer side of the first bend are longer: they choose first.
    outer = -1 if bend.turns[0] > 0 else 1
    for side, piece in product((outer, -outer), bend.pieces):
        for frame, width, depth in _frontages(site, bend, piece, side):
            at = site.world(frame)
            box = (width - 0.02, depth - 0.02, _AIR_M)
            if taken.is_free(at.moved(0, depth / 2), box, 0.0):
                taken.reserve(at.moved(0, depth / 2), (width, depth, _AIR_M), 0.0)
                site.parcels.append(Parcel(at, width, depth))
                break


def _draw_bend(site: Site, rng: np.random.Generator) -> _Bend:
    """Draw an arc or a double bend from the western to the eastern border."""
    count = max(2, min(5, int(2 * site.half_x / _PIECE_M)))
    turn = float(rng.choice([-1, 1])) * radians(float(rng.uniform(15, 22)))
    is_double = count > 2 and rng.random() < _DOUBLE_CHANCE
    half = (count - 1) / 2
    turns = [-turn if is_double and index >= half else turn for index in range(count - 1)]
    headings = np.concatenate([[0.0], np.cumsum(turns)])
    # Headings are balanced about the x axis, so that the street leads straight across the site.
    headings -= headings.mean()
    margin = site.road_m / 2 * abs(sin(headings[0])) + site.walk_m
    length = 2 * (site.half_x - margin) / sum(cos(heading) for heading in headings)
    corners = np.concatenate([[0.0], np.cumsum(length * np.sin(headings))])
    middle = (corners.min() + corners.max()) / 2
    x, y = -(site.half_x - margin), float(rng.uniform(-0.15, 0.15)) * site.half_y - float(middle)
    pieces: list[Frame] = []
    for heading in headings.tolist():
        dx, dy = length * cos(heading), length * sin(heading)
        pieces.append(Frame(x + dx / 2, y + dy / 2, heading))
        x, y = x + dx, y + dy
    return _Bend(tuple(pieces), length, tuple(turns))


def _pave_bend(site: Site, bend: _Bend) -> None:
    """Lay carriageways and sidewalks; each continues the last, so that bends leave no gap."""
    half = site.road_m / 2
    road: Placed | None = None
    walks: dict[int, Placed | None] = {-1: None, 1: None}
    for index, piece in enumerate(bend.pieces):
        lift = _LIFT_M * (index % 2)
        before, after = bend.growth(index, (-half, half))
        frame = piece.moved((after - before) / 2, 0)
        road = site.lay_road(frame, bend.length + before + after, after=road, height=ROAD_M + lift)
        for side in (-1, 1):
            edges = (side * half, side * (half + site.walk_m))
            before, after = bend.growth(index, edges)
            kerb = piece.moved((after - before) / 2, side * half, 0.0 if side > 0 else pi)
            walks[side] = site.lay_sidewalk(
                kerb, bend.length + before + after, after=walks[side], height=SIDEWALK_M + lift
            )


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
            # A shifted rectangle ranks lower than a centred one of the same size.
            found.append((-width * depth + abs(shift) * bend.length, frame, width, depth))
    for _, frame, width, depth in sorted(found, key=lambda row: row[0]):
        yield frame, width, depth


def _is_inside(site: Site, frame: Frame, width: float, depth: float) -> bool:
    corners = [frame.point(su * width / 2, v) for su in (-1, 1) for v in (0.0, depth)]
    return all(abs(x) <= site.half_x and abs(y) <= site.half_y for x, y in corners)
