"""The data of a relation: how an object or a group stands to its host, and the axes left open.

A relation pins axes of a place in the host's own frame. A pinned axis has centimetres of noise; an
open one is drawn. Each is decoded exactly, see `aeroscene.relations.placement`.

    symbol  name                                                             unit
    u       along the outward normal of the host's side                      m
    v       along that side, a quarter turn counter-clockwise from u         m

Relations are discrete on purpose: a network can choose among a few symbols without an error of a
centimetre.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from types import MappingProxyType

from aeroscene.scene import Quaternion, Vector3

# Greatest rank of a host plus one, and greatest number of rows and of columns.
MAX_HOSTS = 24
MAX_ROWS = 16
MAX_SEATS = 8
"""Greatest number of seats along one side of a table."""
N_SLOTS = 8
N_SIDES = 4
ANY_TURN = 4
"""Quadrant of an object whose heading is free."""


class Kind(IntEnum):
    """Kind of relation of an object to its host.

    The order decides between relations that pin equally many axes: the first one counts.
    """

    SEAT = 0
    """A chair, or all chairs of a table, turned to it."""
    LANE = 1
    """A vehicle on a road, headed along it."""
    EDGE = 2
    """Inside, at a side of the host; at a second side too, it is a corner."""
    CENTRE = 3
    """Inside, on a middle line of the host or on both."""
    ON = 4
    """On top of a piece of furniture, anywhere or at its side or middle."""
    OVER = 5
    """Middle over middle of an object that does not bear it."""
    SIDE = 6
    """Outside, beside the host."""
    FACING = 7
    """Some distance before the host, each turned to the other."""
    SCATTER = 8
    """Anywhere inside."""


class Gap(IntEnum):
    """Class of an object's distance from the host's side, along u."""

    TOUCH = 0
    NEAR = 1
    APART = 2
    WIDE = 3
    MIDDLE = 4
    """On the host's middle line."""
    FREE = 5


class Align(IntEnum):
    """Alignment of an object along v."""

    FREE = 0
    CENTRE = 1
    LOW = 2
    """At the end with the least v: in the corner, or flush with it outside."""
    HIGH = 3
    SLOT = 4
    """In a lane of a road; in a seat of a table."""


GAPS_M = (0.03, 0.22, 0.45, 0.65)
"""Middles of the classes of gaps between an object and a side of its host."""
SEAT_GAPS_M = (-0.35, -0.15, 0.05, 0.25)
"""Middles of the classes of gaps between a chair and its table; most are pushed in."""
LANE_RATIOS = (0.06, 0.145, 0.25, 0.31)
"""Distances of the middles of lanes from that of the road, as shares of its width: profiles with
and without parking on one or both sides."""
# Negative v is to the right of the direction of travel.
LANES = tuple(-ratio for ratio in LANE_RATIOS) + LANE_RATIOS
"""Slots along v of the direction of travel: right of the middle first, then left."""
OUTSIDE = frozenset({Kind.SEAT, Kind.SIDE, Kind.FACING})
"""Relations of objects that stand beside their host and not in it."""
HEADED = MappingProxyType({Kind.SEAT: 2, Kind.FACING: 2, Kind.LANE: 0})
"""Relations that fix the heading relative to u: 2 is against it, 0 along it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Relation:
    """The discrete part of a place."""

    kind: Kind
    host: int = 0
    """Rank among the possible hosts, see `aeroscene.relations.hosts`."""
    side: int = 0
    """Side of the host through which u leaves: its +x, +y, -x, -y."""
    gap: Gap = Gap.FREE
    align: Align = Align.FREE
    slot: int = 0
    """Number of the lane in `LANES`."""
    quadrant: int = ANY_TURN
    """Quarter turns of the heading from u; `ANY_TURN` leaves it open."""

    @property
    def pinned(self) -> tuple[bool, bool, bool]:
        """True for those of u, v and heading that are given up to noise."""
        return self.gap != Gap.FREE, self.align != Align.FREE, self.quadrant != ANY_TURN


@dataclass(frozen=True, slots=True)
class Residual:
    """Remainder of a place in the relation's frame: noise of pinned axes, places along others."""

    u_m: float = 0.0
    v_m: float = 0.0
    yaw_rad: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Array:
    """Regular places of a group: a row or grid, or the seats of a table.

    Rows go along x of the group, columns along y. At a table, `rows` are the seats along each of
    its sides +x and -x, and `columns` those along each of its sides +y and -y.
    """

    rows: int = 1
    columns: int = 1
    pitch_m: tuple[float, float] = (0.0, 0.0)
    holes: tuple[int, ...] = ()
    """Places without a member, row by row; at a table side by side."""
    turned: tuple[int, ...] = ()
    """Members that look the other way, such as cars parked backwards in a row of bays."""

    def cells(self, kind: Kind) -> list[tuple[int, int]]:
        """Return row and column of each place with a member; at a table side and seat."""
        if kind == Kind.SEAT:
            # Sides +x, +y, -x, -y in turn: opposite sides have equally many seats.
            counts = (self.rows, self.columns) * 2
            found = [(side, seat) for side, count in enumerate(counts) for seat in range(count)]
        else:
            found = [(row, column) for row in range(self.rows) for column in range(self.columns)]
        return [cell for index, cell in enumerate(found) if index not in self.holes]


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """One object of a unit, and the difference of its place from the unit's."""

    id: int
    category_id: int
    size_m: Vector3
    is_on_top: bool
    """True if its height counts from the parent's top, otherwise from the parent's underside."""
    rise_m: float
    tilt_wxyz: Quaternion | None = None
    """Attitude without the heading; None for an upright box."""
    residual: Residual = Residual()
    """Noise of a member of a group, in the frame of the group or of its side of the table."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Unit:
    """An object or a group that is drawn at once, with its relation."""

    parent_id: int | None
    host_id: int | None
    relation: Relation
    members: tuple[Member, ...]
    """Members in the order of the places of the array."""
    array: Array | None = None
    """None for one object by itself."""
    residual: Residual = Residual()

    @property
    def is_group(self) -> bool:
        """True if it has places for several objects."""
        return self.array is not None

    def pins(self, member: int) -> tuple[bool, bool, bool]:
        """Return which of a member's u, v and heading are given up to noise.

        All members of a group but the first are pinned by the array, once the first one stands.
        """
        # The array fixes all but the first: its rows and pitches give their places.
        if self.is_group and member > 0:
            return True, True, True
        return self.relation.pinned
