"""What a relation is: how an object or a group of them stands to its host, and what it leaves open.

A relation pins axes of a place in the host's own frame; what it pins is noise of centimetres, what
it leaves open is drawn. Each is decoded exactly, see `aeroscene.relations.placing`.

| symbol | name | unit |
|---|---|---|
| u | along the outward normal of the host's side | m |
| v | along that side, a quarter turn counter-clockwise from u | m |
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from types import MappingProxyType

from aeroscene.scene import Quaternion, Vector3

MAX_HOSTS = 24
MAX_ROWS = 16
MAX_SEATS = 8
"""Most seats along one side of a table."""
N_SLOTS = 8
N_SIDES = 4
ANY_TURN = 4
"""The quadrant of an object whose heading is free."""


class Kind(IntEnum):
    """What an object is to its host."""

    SEAT = 0
    """A chair, or all chairs of a table, turned to it."""
    LANE = 1
    """A vehicle on a road, headed along it."""
    EDGE = 2
    """Inside, at a side of the host; at a second one too it is a corner."""
    CENTRE = 3
    """Inside, on a middle line of the host or on both."""
    ON = 4
    """Somewhere on top of a piece of furniture, or at its side or middle."""
    OVER = 5
    """Middle over middle of what does not bear it."""
    SIDE = 6
    """Outside, beside the host."""
    FACING = 7
    """Some way before the host, each turned to the other."""
    SCATTER = 8
    """Somewhere inside."""


class Gap(IntEnum):
    """Where an object is along u."""

    TOUCH = 0
    NEAR = 1
    APART = 2
    WIDE = 3
    MIDDLE = 4
    """On the host's middle line."""
    FREE = 5


class Align(IntEnum):
    """Where an object is along v."""

    FREE = 0
    CENTRE = 1
    LOW = 2
    """At the end where v is least: in the corner, or flush with it outside."""
    HIGH = 3
    SLOT = 4
    """In a lane of a road; in a seat of a table."""


GAPS_M = (0.03, 0.22, 0.45, 0.65)
"""Middles of the classes of gaps between an object and a side of its host."""
SEAT_GAPS_M = (-0.35, -0.15, 0.05, 0.25)
"""The same between a chair and its table: most are pushed in."""
LANE_RATIOS = (0.06, 0.145, 0.25, 0.31)
"""Middles of lanes, from that of the road, as shares of its width: profiles with and without
parking on one or both sides."""
LANES = tuple(-ratio for ratio in LANE_RATIOS) + LANE_RATIOS
"""Slots along v of the direction of travel: right of the middle first, then left."""
OUTSIDE = frozenset({Kind.SEAT, Kind.SIDE, Kind.FACING})
"""Relations of what stands beside its host and not in it."""
HEADED = MappingProxyType({Kind.SEAT: 2, Kind.FACING: 2, Kind.LANE: 0})
"""Relations that fix the heading, from u: against it, or along it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Relation:
    """What is discrete of a place."""

    kind: Kind
    host: int = 0
    """Rank among the possible hosts, see `aeroscene.relations.hosts`."""
    side: int = 0
    """Side of the host that u leaves through: its +x, +y, -x, -y."""
    gap: Gap = Gap.FREE
    align: Align = Align.FREE
    slot: int = 0
    """Number of the lane in `LANES`."""
    quadrant: int = ANY_TURN
    """Quarter turns of the heading from u; `ANY_TURN` leaves it open."""

    @property
    def pinned(self) -> tuple[bool, bool, bool]:
        """Whether u, v and the heading are given but for noise."""
        return self.gap != Gap.FREE, self.align != Align.FREE, self.quadrant != ANY_TURN


@dataclass(frozen=True, slots=True)
class Residual:
    """What a relation leaves, in its own frame: noise where it pins, the place where not."""

    u_m: float = 0.0
    v_m: float = 0.0
    yaw_rad: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Array:
    """Equal places of a group: a row or grid, or the seats of a table.

    Rows go along x of the group, columns along y. At a table they are the seats along each of its
    sides +x and -x, and along each of its sides +y and -y.
    """

    rows: int = 1
    columns: int = 1
    pitch_m: tuple[float, float] = (0.0, 0.0)
    holes: tuple[int, ...] = ()
    """Places without a member, row by row; at a table side by side."""
    turned: tuple[int, ...] = ()
    """Members that look the other way: cars with their noses out of a row of bays."""

    def cells(self, kind: Kind) -> list[tuple[int, int]]:
        """Row and column of each place with a member; side and seat at a table."""
        if kind == Kind.SEAT:
            counts = (self.rows, self.columns) * 2
            found = [(side, seat) for side, count in enumerate(counts) for seat in range(count)]
        else:
            found = [(row, column) for row in range(self.rows) for column in range(self.columns)]
        return [cell for index, cell in enumerate(found) if index not in self.holes]


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """One object of a unit: what it is, and what its place adds to the unit's."""

    id: int
    category_id: int
    size_m: Vector3
    is_on_top: bool
    """Whether its height counts from the parent's top, else from the parent's underside."""
    rise_m: float
    tilt_wxyz: Quaternion | None = None
    """What is left of the attitude without the heading; None for an upright box."""
    residual: Residual = Residual()
    """Noise of a member of a group, in the frame of the group or of its side of the table."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Unit:
    """What is drawn at once: an object or a group of them, with its relation."""

    parent_id: int | None
    host_id: int | None
    relation: Relation
    members: tuple[Member, ...]
    """In the order of the places of the array."""
    array: Array | None = None
    """None for one object by itself."""
    residual: Residual = Residual()

    @property
    def is_group(self) -> bool:
        """Whether it has places for several objects."""
        return self.array is not None

    def pins(self, member: int) -> tuple[bool, bool, bool]:
        """What of a member's place is given but for noise, once the unit's first one stands."""
        if self.is_group and member > 0:
            return True, True, True
        return self.relation.pinned
