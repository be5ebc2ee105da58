"""Relations that hold between two rectangles, by their places alone.

Every test has a tolerance, and a tolerance that is too wide pins objects by chance. Where there is
little room to move, it is therefore a share of that room. The gaps were checked against the same
objects at random places (docs/scene_model.md).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Literal

from aeroscene.relations.placement import gap_middle_m
from aeroscene.relations.plane import Rectangle, nearest_quadrant, turned_reach_m
from aeroscene.relations.relation import (
    ANY_TURN,
    GAPS_M,
    LANES,
    N_SIDES,
    SEAT_GAPS_M,
    Align,
    Gap,
    Kind,
    Relation,
)

TOLERANCE_M = 0.1
"""Greatest deviation of a pinned axis from the relation's own place."""
TOLERANCE_RAD = math.radians(5.0)
_FLUSH_M = 0.06
"""Greatest deviation of ends that are in line."""
_SMALL_M = 0.03
"""Both tolerances among small objects on a top."""
_PLAY_SHARE = 0.125
_LEAST_M = 0.02
"""With little play a tolerance is `_PLAY_SHARE` of it, but at least this; otherwise all objects
would be pinned."""
_EDGE_SHARE = 0.35
"""Share of the play from the middle to a side that counts as being at the side."""
_OVERHANG_M = 3.0
"""Distance past the end of a road at which its traffic lights may stand."""
_FACING_M = 5.0
"""Greatest distance between two objects that face each other."""

HostKind = Literal["object", "path", "verge", "small"]
"""Kind of the host beside which an object stands: another object; a path or structure, along which
any place will do; a road, also past its ends; another small object on the same top, which may be
near by chance."""


def quadrant_of(turn_rad: float) -> int:
    """Return the quarter turns of a heading; `ANY_TURN` if it is off all of them."""
    quadrant, rest_rad = nearest_quadrant(turn_rad)
    return quadrant if abs(rest_rad) <= TOLERANCE_RAD else ANY_TURN


def gap_class(gap_m: float, tolerance_m: float, middles_m: Sequence[float] = GAPS_M) -> Gap:
    """Return the class of a gap; `Gap.FREE` outside of all classes.

    Args:
        gap_m: The gap; negative for an overlap.
        tolerance_m: Greatest distance from the middle of a class.
        middles_m: Middles of the classes.
    """
    index = min(range(len(middles_m)), key=lambda k: abs(gap_m - middles_m[k]))
    return Gap(index) if abs(gap_m - middles_m[index]) <= tolerance_m else Gap.FREE


def scatter(host: Rectangle, child: Rectangle, kind: Kind = Kind.SCATTER) -> Relation:
    """Return the relation that always holds: somewhere within."""
    turn_rad = host.place.local(child.place)[2]
    return Relation(kind=kind, quadrant=quadrant_of(turn_rad))


def inside(
    host: Rectangle,
    child: Rectangle,
    *,
    is_round: bool = False,
    is_top: bool = False,
    is_walled: bool = False,
) -> Iterator[Relation]:
    """Yield the edges, corners and middles of a bearer at which an object stands.

    Args:
        host: Outline of the bearer.
        child: Outline of the object.
        is_round: True if the object has no front, so that its heading does not matter.
        is_top: True if the bearer is a piece of furniture.
        is_walled: True if it has walls around it: objects stand against them or do not, so there is
            one class of gaps.
    """
    if quadrant_of(host.place.local(child.place)[2]) == ANY_TURN and not is_round:
        return
    for side in range(N_SIDES):
        u_m, v_m, turn_rad = host.from_side(side).local(child.place)
        quadrant = quadrant_of(turn_rad)
        reach_m, half_m = turned_reach_m(child.half_m, turn_rad), host.reach_m(side)
        play_m = half_m[0] - reach_m[0], half_m[1] - reach_m[1]
        tolerance_u_m, tolerance_v_m = (_tolerance_m(play) for play in play_m)
        gaps_m = GAPS_M[:1] if is_walled else _edge_gaps_m(play_m[0])
        gap = gap_class(play_m[0] - u_m, tolerance_u_m, gaps_m)
        # Middle lines are the same from opposite sides, so two sides are enough.
        if gap == Gap.FREE and side < N_SIDES // 2 and abs(u_m) <= tolerance_u_m:
            gap = Gap.MIDDLE
        if gap == Gap.FREE:
            continue
        kind = Kind.ON if is_top else Kind.CENTRE if gap == Gap.MIDDLE else Kind.EDGE
        relation = Relation(kind=kind, side=side, gap=gap, quadrant=quadrant)
        end_m = gap_middle_m(relation) or GAPS_M[Gap.TOUCH]
        align = Align.FREE
        if abs(play_m[1] - abs(v_m) - end_m) <= tolerance_v_m and (is_top or gap != Gap.MIDDLE):
            align = Align.HIGH if v_m > 0 else Align.LOW
        if abs(v_m) <= tolerance_v_m:
            align = Align.CENTRE
        yield Relation(kind=kind, side=side, gap=gap, align=align, quadrant=quadrant)


def _edge_gaps_m(play_m: float) -> Sequence[float]:
    """Return the classes of gaps that are near a side, for the play between middle and side."""
    return [gap_m for gap_m in GAPS_M if gap_m <= max(GAPS_M[0], _EDGE_SHARE * play_m)]


def _tolerance_m(play_m: float) -> float:
    return max(_LEAST_M, min(TOLERANCE_M, _PLAY_SHARE * play_m))


def beside(
    host: Rectangle,
    child: Rectangle,
    host_kind: HostKind = "object",
    *,
    is_round: bool = False,
) -> Iterator[Relation]:
    """Yield the sides of another object at which an object stands, in line with it or not.

    Args:
        host: Outline of the other object.
        child: Outline of the object.
        host_kind: Kind of the host.
        is_round: True if the object has no front, so that its heading does not matter.
    """
    tolerance_m, flush_m, gaps_m = TOLERANCE_M, _FLUSH_M, GAPS_M
    if host_kind == "small":
        tolerance_m, flush_m, gaps_m = _SMALL_M, _SMALL_M, GAPS_M[:1]
    for side in range(N_SIDES):
        u_m, v_m, turn_rad = host.from_side(side).local(child.place)
        quadrant = quadrant_of(turn_rad)
        if quadrant == ANY_TURN and not is_round:
            return
        reach_m, half_m = turned_reach_m(child.half_m, turn_rad), host.reach_m(side)
        gap = gap_class(u_m - half_m[0] - reach_m[0], tolerance_m, gaps_m)
        if gap == Gap.FREE:
            continue
        align = Align.FREE
        if abs(abs(v_m) - abs(half_m[1] - reach_m[1])) <= flush_m and gap == Gap.TOUCH:
            # The end at which a longer object is flush lies on the other side of its middle.
            is_high = (v_m > 0) == (half_m[1] > reach_m[1])
            align = Align.HIGH if is_high else Align.LOW
        if abs(v_m) <= flush_m:
            align = Align.CENTRE
        is_along = abs(v_m) <= half_m[1] + (_OVERHANG_M if host_kind == "verge" else 0.0)
        # Without alignment, nearness means something only along ways, or if the two touch.
        if align != Align.FREE or (
            is_along and (host_kind in {"path", "verge"} or gap == Gap.TOUCH)
        ):
            yield Relation(kind=Kind.SIDE, side=side, gap=gap, align=align, quadrant=quadrant)


def over(host: Rectangle, child: Rectangle) -> Iterator[Relation]:
    """Yield the relation of a middle over a middle, if it holds."""
    u_m, v_m, turn_rad = host.place.local(child.place)
    if max(abs(u_m), abs(v_m)) <= TOLERANCE_M:
        quadrant = quadrant_of(turn_rad)
        yield Relation(kind=Kind.OVER, gap=Gap.MIDDLE, align=Align.CENTRE, quadrant=quadrant)


def facing(host: Rectangle, child: Rectangle) -> Iterator[Relation]:
    """Yield the relation before the front of another, turned to it, if it holds."""
    u_m, v_m, turn_rad = host.place.local(child.place)
    gap_m = u_m - host.half_m[0] - child.half_m[0]
    # Two quarter turns against the host: both fronts face each other.
    is_facing = quadrant_of(turn_rad) == 2 and abs(v_m) <= TOLERANCE_M
    # Nearer than that the object is beside the other.
    if is_facing and GAPS_M[-1] < gap_m <= _FACING_M:
        yield Relation(kind=Kind.FACING, align=Align.CENTRE, quadrant=2)


def lane(road: Rectangle, child: Rectangle) -> Iterator[Relation]:
    """Yield the lane of a road in which an object is headed along it.

    The side counts from the heading, so right-hand traffic is the same in both directions.
    """
    # A road runs along its longer side; each of its directions is tried.
    for side in (0, 2) if road.half_m[0] >= road.half_m[1] else (1, 3):
        u_m, v_m, turn_rad = road.from_side(side).local(child.place)
        length_m, width_m = road.reach_m(side)
        if quadrant_of(turn_rad) != 0 or abs(u_m) > length_m:
            continue
        slot = min(range(len(LANES)), key=lambda k: abs(v_m - 2.0 * width_m * LANES[k]))
        if abs(v_m - 2.0 * width_m * LANES[slot]) <= TOLERANCE_M:
            yield Relation(kind=Kind.LANE, side=side, align=Align.SLOT, slot=slot, quadrant=0)


def seat(table: Rectangle, child: Rectangle) -> tuple[int, float, float] | None:
    """Return the side of a table at which a chair stands, its place along it and its gap, m.

    None if the chair does not stand at the table.
    """
    for side in range(N_SIDES):
        u_m, v_m, turn_rad = table.from_side(side).local(child.place)
        if quadrant_of(turn_rad) != 2:
            continue
        half_m = table.reach_m(side)
        gap_m = u_m - half_m[0] - turned_reach_m(child.half_m, turn_rad)[0]
        is_near = gap_class(gap_m, TOLERANCE_M, SEAT_GAPS_M) != Gap.FREE
        if is_near and u_m > 0 and abs(v_m) <= half_m[1]:
            return side, v_m, gap_m
    return None
