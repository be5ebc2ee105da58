"""Free places for units among the objects so far, by ways that their relations leave open.

Drawn places overlap now and then. A unit that overlaps something tries shifts of growing length,
first along the directions that its relation leaves free, and takes the first free one. A unit that
was read off a scene is free already and stays exactly where it is. If a unit finds no place, its
members that overlap others are left out; if all do, those that are deep in others.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from jaxtyping import Bool, Float

from aeroscene.feasibility.place_search import BLOCK, Blocks, first_free
from aeroscene.relations import Unit
from aeroscene.relations.plane import QUARTER, Rectangle
from aeroscene.relations.relation import ANY_TURN, N_SIDES, Kind, Relation
from aeroscene.scene import OrientedBox

Shift = tuple[float, float]
Ways = tuple[float, ...] | None
"""Headings along which boxes may go, forwards and backwards; None for all."""
_STILL: Shift = (0.0, 0.0)
# Shifts begin at this step, grow by this factor, and end at this length, m.
_STEP_M, _GROWTH, _MOST_M = 0.05, 1.12, 8.0
# Directions that are tried if all are open.
_SPOKES = 16
_SIDES: Mapping[Kind, tuple[int, ...]] = MappingProxyType(
    {Kind.EDGE: (0, 1, 3, 2), Kind.SIDE: (0, 2, 1, 3)}
)
"""Quarter turns about the host, the likeliest first: to the next wall, or in line with the host."""
_IN_LINE = (0, 2)
"""Quarter turns of units with their host's heading: to its other side, not before it."""
_DEEP_M = 0.004
"""Depth up to which boxes only touch, because documents round."""


class Neighbours:
    """Boxes of the objects so far, in arrays for fast tests."""

    def __init__(self) -> None:
        self._rows: list[tuple[float, ...]] = []
        self._categories: list[str] = []
        self._parents: list[int | None] = []
        self._air: list[tuple[float, ...]] = []

    def add(self, box: OrientedBox, category: str, parent: int | None) -> None:
        """Append an object; its id is its place in the order."""
        self._rows.append(_row(box))
        self._categories.append(category)
        self._parents.append(parent)

    def move(self, number: int, box: OrientedBox) -> None:
        """Replace the box of an object."""
        self._rows[number] = _row(box)

    def add_air(self, box: OrientedBox) -> None:
        """Keep a box free of all objects that come later."""
        self._air.append(_row(box))

    def taken(
        self, bearer: int | None, without: Sequence[int] = (), *, has_air: bool = True
    ) -> Blocks:
        """Return the obstacles of an object on a bearer: all objects but its ancestors.

        Args:
            bearer: Id of the bearer, which is left out together with its own bearers.
            without: Ids of further objects to leave out.
            has_air: False leaves out the air that must stay free.
        """
        is_other = np.ones(len(self._rows), dtype=bool)
        is_other[list(without)] = False
        while bearer is not None:
            is_other[bearer] = False
            bearer = self._parents[bearer]
        rows = np.array(self._rows, dtype=BLOCK)[is_other]
        return np.concatenate([rows, np.array(self._air, dtype=BLOCK)]) if has_air else rows

    def rows(self, numbers: Sequence[int]) -> Blocks:
        """Return some objects by their places in the order."""
        return np.array([self._rows[number] for number in numbers], dtype=BLOCK)

    def of(self, categories: Container[str]) -> Blocks:
        """Return all objects of some categories."""
        rows = [
            r for r, each in zip(self._rows, self._categories, strict=True) if each in categories
        ]
        return np.array(rows, dtype=BLOCK)

    def kept_free(self, category: str, clearance_m: tuple[float, float]) -> Blocks:
        """Return the space that a category keeps free of its own: ahead, behind and beside each."""
        is_alike = np.array([each == category for each in self._categories], dtype=bool)
        rows = np.array(self._rows, dtype=BLOCK)[is_alike]
        longer, wider = rows.copy(), rows.copy()
        longer["half_x_m"] += clearance_m[0]
        wider["half_y_m"] += clearance_m[1]
        return np.concatenate([longer, wider])


def free_shift(
    group: Sequence[OrientedBox],
    taken: Blocks,
    within: Rectangle | None,
    ways_rad: Ways,
) -> Shift | None:
    """Return the least shift after which boxes are on their bearer and overlap nothing.

    Args:
        group: The boxes, which move as one.
        taken: Obstacles.
        within: Outline of the bearer. Boxes that are too long for it stay as they are along that
            axis.
        ways_rad: Headings along which they may go.

    Returns:
        East and north in m, or None if there is no such shift.
    """
    rows = np.array([_row(box) for box in group], dtype=BLOCK)
    # First onto the bearer, then away from obstacles.
    onto = np.zeros(2) if within is None else _way_onto(rows, within)
    rows["x_m"] += onto[0]
    rows["y_m"] += onto[1]
    # Obstacles that no shift can reach are removed before the search.
    taken = _near(rows, taken)
    if _is_free(rows, taken):
        return (float(onto[0]), float(onto[1]))
    shifts_m = np.array(list(_shifts(ways_rad)))
    if within is not None:
        shifts_m = shifts_m[_stays(rows, shifts_m, within)]
    number = first_free(rows, taken, shifts_m)
    if number < 0:
        return None
    x_m, y_m = (onto + shifts_m[number]).tolist()
    return x_m, y_m


def free_of(taken: Blocks, group: Sequence[OrientedBox], inner: float = 1.0) -> list[OrientedBox]:
    """Return the boxes that overlap no obstacle.

    Args:
        taken: Obstacles.
        group: The boxes.
        inner: Share of length and width about the middle that has to be free.
    """
    found: list[OrientedBox] = []
    for box in group:
        row = np.array([_row(box)], dtype=BLOCK)
        row["half_x_m"] *= inner
        row["half_y_m"] *= inner
        if _is_free(row, taken):
            found.append(box)
    return found


def open_ways(unit: Unit, host: Rectangle) -> Iterator[tuple[int, Ways]]:
    """Yield the ways that a unit may try, the least change first.

    A way is a number of quarter turns about the host, and the headings along which to shift. First
    the unit keeps everything that its relation pins. Then it goes along its side of the host, out
    of a corner along either edge. Last it goes anywhere, unless it stands at an edge.
    """
    relation = unit.relation
    is_u_pinned, is_v_pinned, _ = relation.pinned
    sides = _IN_LINE if _is_in_line(relation) else _SIDES.get(relation.kind, (0,))
    if not is_u_pinned and not is_v_pinned:
        yield 0, None
        return
    for turns in sides:
        outwards_rad = host.place.yaw_rad + (relation.side + turns) * QUARTER
        own = [outwards_rad] * (not is_u_pinned) + [outwards_rad + QUARTER] * (not is_v_pinned)
        yield turns, tuple(own)
    # With both axes pinned there was no shift above: let it slide along its side.
    if is_u_pinned and is_v_pinned:
        for turns in sides:
            outwards_rad = host.place.yaw_rad + (relation.side + turns) * QUARTER
            is_corner = relation.kind == Kind.EDGE
            yield turns, (outwards_rad + QUARTER, *([outwards_rad] * is_corner))
    if relation.kind != Kind.EDGE:
        yield 0, None


def turned(unit: Unit, turns: int) -> Unit:
    """Turn a unit by quarter turns about its host.

    A unit with its host's heading keeps it, such as a shelf in a row of shelves.
    """
    if turns == 0:
        return unit
    relation = unit.relation
    side, quadrant = (relation.side + turns) % N_SIDES, relation.quadrant
    if _is_in_line(relation):
        quadrant = (quadrant - turns) % N_SIDES
    return replace(unit, relation=replace(relation, side=side, quadrant=quadrant))


def _is_in_line(relation: Relation) -> bool:
    """True if a unit beside its host has the host's heading, as shelves along a wall have."""
    is_headed = relation.kind == Kind.SIDE and relation.quadrant != ANY_TURN
    return is_headed and (relation.side + relation.quadrant) % N_SIDES == 0


def way_onto(group: Sequence[OrientedBox], outline: Rectangle) -> Shift:
    """Return the least shift of boxes onto an outline.

    Args:
        group: The boxes, which move as one.
        outline: Where they should be. Along an axis for which they are too long, they stay.
    """
    x_m, y_m = _way_onto(np.array([_row(box) for box in group], dtype=BLOCK), outline).tolist()
    return x_m, y_m


def moved(box: OrientedBox, shift: Shift) -> OrientedBox:
    """Return a box after a shift."""
    if shift == _STILL:
        return box
    return OrientedBox((box.p[0] + shift[0], box.p[1] + shift[1], box.p[2]), box.q, box.s)


def _row(box: OrientedBox) -> tuple[float, ...]:
    yaw_rad = box.yaw_rad
    half_m = [side / 2 for side in box.s]
    return (
        *box.p[:2],
        *half_m[:2],
        math.cos(yaw_rad),
        math.sin(yaw_rad),
        box.p[2] - half_m[2],
        box.p[2] + half_m[2],
    )


def _middles(rows: Blocks) -> Float[np.ndarray, "k 2"]:
    return np.column_stack([rows["x_m"], rows["y_m"]])


def _near(rows: Blocks, taken: Blocks) -> Blocks:
    """Return the obstacles at the height of a group that it may meet after any shift."""
    middle, reach = _middles(rows).mean(axis=0), np.hypot(rows["half_x_m"], rows["half_y_m"])
    own_m = (np.hypot(*(_middles(rows) - middle).T) + reach).max()
    away_m = np.hypot(*(_middles(taken) - middle).T) - np.hypot(
        taken["half_x_m"], taken["half_y_m"]
    )
    is_level = (taken["base_m"] < rows["top_m"].max()) & (taken["top_m"] > rows["base_m"].min())
    return taken[is_level & (away_m < own_m + _MOST_M)]


def _is_free(rows: Blocks, taken: Blocks) -> bool:
    """True if a group overlaps nothing by more than a touch."""
    less = rows.copy()
    for half_m in ("half_x_m", "half_y_m"):
        # Boxes thinner than a touch keep a least extent.
        less[half_m] = np.maximum(less[half_m] - _DEEP_M, _DEEP_M)
    less["base_m"] += _DEEP_M
    less["top_m"] -= _DEEP_M
    return first_free(less, taken, np.zeros((1, 2))) == 0


def _way_onto(rows: Blocks, within: Rectangle) -> Float[np.ndarray, " 2"]:
    """Least shift that brings a group onto an outline, along each axis that it fits on."""
    low, high, axes = _play(rows, within)
    fits = low <= high
    way = np.where(fits, np.clip(0.0, np.where(fits, low, 0.0), np.where(fits, high, 0.0)), 0.0)
    # Rounding of documents is no reason to move anything.
    way[np.abs(way) < _DEEP_M] = 0.0
    return way @ axes


def _stays(
    rows: Blocks, shifts_m: Float[np.ndarray, "s 2"], within: Rectangle
) -> Bool[np.ndarray, " s"]:
    """Mark the shifts that leave a group as far within an outline as it is."""
    low, high, axes = _play(rows, within)
    along = shifts_m @ axes.T
    is_in = (along >= np.minimum(low, 0.0) - 1e-9) & (along <= np.maximum(high, 0.0) + 1e-9)
    return np.all(is_in, axis=1)


def _play(
    rows: Blocks, within: Rectangle
) -> tuple[Float[np.ndarray, " 2"], Float[np.ndarray, " 2"], Float[np.ndarray, "2 2"]]:
    """Return the least and greatest shift along an outline's axes within it, and the axes."""
    yaw_rad = within.place.yaw_rad
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    axes = np.array([[c, s], [-s, c]])
    middle = (_middles(rows) - (within.place.x_m, within.place.y_m)) @ axes.T
    lean = np.abs(rows["cos"] * c + rows["sin"] * s)
    slant = np.abs(rows["sin"] * c - rows["cos"] * s)
    reach = np.column_stack(
        [
            lean * rows["half_x_m"] + slant * rows["half_y_m"],
            slant * rows["half_x_m"] + lean * rows["half_y_m"],
        ]
    )
    half = np.array(within.half_m)
    return -half - (middle - reach).min(axis=0), half - (middle + reach).max(axis=0), axes


def _shifts(ways_rad: Ways) -> Iterator[Shift]:
    """Yield shifts, the shortest first."""
    spokes = [spoke * math.tau / _SPOKES for spoke in range(_SPOKES)]
    if ways_rad is not None:
        spokes = [way + turn for way in ways_rad for turn in (0.0, math.pi)]
    yield _STILL
    radius_m = _STEP_M
    while radius_m < _MOST_M:
        for angle in spokes:
            yield radius_m * math.cos(angle), radius_m * math.sin(angle)
        # Fine steps near, and coarser ones further off.
        radius_m = max(radius_m + _STEP_M, radius_m * _GROWTH)
