"""Moves of which furnishing a room consists: against a wall, around a table, on a desk.

Furnishing functions describe a room by these moves and never compute coordinates. Every move
returns None if the object does not fit, so that a function can go on with the next one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import pi

from aeroscene.corpus.curation.builder import Attributes, Builder, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import QUARTER, Frame
from aeroscene.corpus.curation.room_space import RoomSpace
from aeroscene.corpus.curation.rooms.grid import grid_spots
from aeroscene.scene import Vector3
from aeroscene.solids.shapes.furniture import WOODS
from aeroscene.solids.shapes.materials import FABRIC_COLOURS

GAP_M = 0.03
"""Gap between furniture and the wall behind it, and least gap between two objects."""
# Places that are tried for an object before it is given up.
_TRIES = 8

_INDOOR_SIZES: dict[str, Vector3] = {
    "bin": (0.42, 0.42, 0.8),
    "sign": (0.2, 1.3, 2.3),
    "crate": (0.9, 0.9, 0.75),
}

SIDES = ("front", "back", "left", "right")
# Where a wall is, in half sides of the room, and its turn: v leads from the wall into the room.
_WALLS = {
    "front": (1, 0, QUARTER),
    "back": (-1, 0, -QUARTER),
    "left": (0, 1, pi),
    "right": (0, -1, 0.0),
}
_STYLED = frozenset(
    ("table", "chair", "desk", "cabinet", "shelf", "coffee_table", "nightstand", "sofa", "armchair")
)
_BEARERS = frozenset(("cabinet", "counter", "shelf", "nightstand", "desk", "table", "coffee_table"))


class Interior:
    """One room that is being furnished.

    Attributes:
        draw: Randomness.
        room: The room's box.
        floor: Height on which furniture stands, m.
        sides: Sides on which furniture can have a wall behind it.
        bearers: Furniture on which small objects can lie.
    """

    def __init__(
        self,
        builder: Builder,
        draw: Draw,
        space: RoomSpace,
        sides: Sequence[str] = SIDES,
        clear_end_m: float = 0.0,
    ) -> None:
        """Begin with an empty room.

        Args:
            builder: Builder of the scene.
            draw: Randomness.
            space: The room.
            sides: Sides that have a wall; all if empty.
            clear_end_m: Length of the longer side that rows leave free, at its positive end.
        """
        self._builder = builder
        self.draw = draw
        self.room = space.placed
        self.floor = space.floor
        self.sides = tuple(sides) or SIDES
        """Sides on which furniture can have a wall behind it."""
        self._clear_end_m = clear_end_m
        self.bearers: list[Placed] = []
        """Furniture on which small objects can lie."""
        # One room, one taste: furniture shares its wood and upholstery its colour.
        self._style = {"wood": draw.one_of(WOODS), "colour": draw.one_of(FABRIC_COLOURS)}
        # Corners bear things too, so no table is round; every other board of an open shelf is free.
        self._forms = {
            "shelf": "open",
            "nightstand": "drawers",
            "table": draw.one_of(("legs", "trestle", "pedestal")),
            "coffee_table": draw.one_of(("panels", "legs")),
            "sign": "board",
        }

    def _size_of(self, name: str) -> Vector3:
        """A size for a room; categories that are larger in streets have their own."""
        return _INDOOR_SIZES.get(name) or self.draw.size_of(name)

    @property
    def area(self) -> float:
        """Area of the floor, m2."""
        return self.room.size[0] * self.room.size[1]

    def wall(self, side: str) -> tuple[Frame, float]:
        """Frame in the middle of a wall's foot with v into the room, and the wall's length, m."""
        x, y, _ = self.room.size
        along, across, turn = _WALLS[side]
        frame = self.room.frame.moved(along * x / 2, across * y / 2, turn)
        return frame, y if along else x

    def depth(self, side: str) -> float:
        """Distance from a wall to the opposite one, m, which bounds what may stand before it."""
        x, y, _ = self.room.size
        return x if _WALLS[side][0] else y

    def some_side(self) -> str:
        """Draw a wall, all that the room has being equally likely."""
        return self.draw.one_of(self.sides)

    def against(
        self,
        side: str,
        name: str,
        size: Vector3 | None = None,
        turn: float = 0.0,
        look: Attributes | None = None,
    ) -> Placed | None:
        """Stand an object with its back to a wall, or turned from that.

        Another wall is tried if the side has no wall or no space.

        Args:
            side: Side to try first, one of `SIDES`.
            name: Category.
            size: Extents; drawn by default.
            turn: Turn from the heading that has the back to the wall, rad.
            look: Attributes.
        """
        size = size or self._size_of(name)
        # A random order, with the wanted side before all others.
        others = [self.sides[i] for i in self.draw.shuffled(range(len(self.sides)))]
        for wall in (*(s for s in others if s == side), *(s for s in others if s != side)):
            placed = self._against(wall, name, size, turn, look)
            if placed:
                return placed
        return None

    def _against(
        self, side: str, name: str, size: Vector3, turn: float, look: Attributes | None
    ) -> Placed | None:
        frame, length = self.wall(side)
        # A quarter turn exchanges depth and width.
        is_square = abs(turn) % pi < 0.1
        deep, wide = (size[0], size[1]) if is_square else (size[1], size[0])
        reach = length / 2 - wide / 2 - GAP_M
        if reach < 0:
            return None
        v = deep / 2 + GAP_M
        for _ in range(_TRIES):
            spot = frame.moved(self.draw.between(-reach, reach), v, QUARTER + turn)
            placed = self.stand(name, spot, size, GAP_M, look)
            if placed:
                return placed
        return None

    def lined(
        self, side: str, name: str, count: int, size: Vector3 | None = None, gap: float = 0.05
    ) -> list[Placed]:
        """Stand several objects of one size side by side along a wall, from a random place.

        Args:
            side: Wall to try first.
            name: Category.
            count: Most objects.
            size: Extents; drawn by default.
            gap: Distance between neighbours, m.

        Returns:
            The objects that stand, in their order along the wall.
        """
        size = size or self._size_of(name)
        first = self.against(side, name, size)
        row = [first] if first else []
        # The row grows to one side until something is in the way, and then to the other.
        for sign in (-1.0, 1.0):
            while row and len(row) < count:
                end = row[-1] if sign > 0 else row[0]
                placed = self.stand(name, end.frame.moved(0.0, sign * (size[1] + gap)), size)
                if placed is None:
                    break
                row.insert(len(row) if sign > 0 else 0, placed)
        return row

    def anywhere(
        self,
        name: str,
        size: Vector3 | None = None,
        keep: float = 0.7,
        turn: float = 0.0,
        look: Attributes | None = None,
    ) -> Placed | None:
        """Stand an object freely in the room.

        Args:
            name: Category.
            size: Extents; drawn by default.
            keep: Least distance from everything, walls too, m.
            turn: Turn in the room's frame, rad.
            look: Attributes.

        Returns:
            The object, or None if the room is too small or some tries found no place.
        """
        size = size or self._size_of(name)
        x, y, _ = self.room.size
        across, along = (size[0], size[1]) if abs(turn) % pi < 0.1 else (size[1], size[0])
        reach_u, reach_v = x / 2 - across / 2 - keep, y / 2 - along / 2 - keep
        # Too small a room for the distance on both sides.
        if min(reach_u, reach_v) < 0:
            return None
        for _ in range(_TRIES):
            u, v = self.draw.between(-reach_u, reach_u), self.draw.between(-reach_v, reach_v)
            placed = self.stand(name, self.room.frame.moved(u, v, turn), size, keep, look)
            if placed:
                return placed
        return None

    def long_side(self) -> str:
        """Name of the longest wall."""
        return max(self.sides, key=lambda side: self.wall(side)[1])

    def in_ranks(
        self, side: str, name: str, size: Vector3, ranks: int, pitch: float = 1.0, gap: float = 0.1
    ) -> Iterator[None]:
        """Stand ranks of equal objects parallel to a wall, facing the room, six a step.

        Args:
            side: Wall behind the first rank.
            name: Category.
            size: Extents.
            ranks: Number of ranks.
            pitch: Distance between ranks, m.
            gap: Distance between neighbours of a rank, m.
        """
        frame, length = self.wall(side)
        # Half a metre at both ends, to walk past.
        count = max(0, int((length - 1.0) // (size[1] + gap)))
        for rank in range(ranks):
            for index in range(count):
                u = (index - (count - 1) / 2) * (size[1] + gap)
                v = size[0] / 2 + GAP_M + rank * pitch
                self.stand(name, frame.moved(u, v, QUARTER), size)
                if index % 6 == 5:
                    yield
            yield

    def line_walls(self, names: Sequence[str], count: int) -> Iterator[None]:
        """Stand a number of objects of some categories against walls, one in each step.

        Args:
            names: Categories, drawn for each object; one that occurs twice is twice as likely.
            count: Number of objects that are tried.
        """
        for _ in range(count):
            self.against(self.some_side(), self.draw.one_of(names))
            yield

    def put(
        self,
        name: str,
        u: float,
        v: float,
        size: Vector3 | None = None,
        turn: float = 0.0,
        keep: float = GAP_M,
        look: Attributes | None = None,
    ) -> Placed | None:
        """Stand an object at a place of the room, from its middle.

        Args:
            name: Category.
            u: Place along the room's x axis, m.
            v: Place along its y axis, m.
            size: Extents; drawn by default.
            turn: Turn in the room's frame, rad.
            keep: Least distance from everything, m.
            look: Attributes.
        """
        size = size or self._size_of(name)
        return self.stand(name, self.room.frame.moved(u, v, turn), size, keep, look)

    def beside(
        self,
        anchor: Placed,
        name: str,
        u: float,
        v: float,
        turn: float,
        size: Vector3 | None = None,
    ) -> Placed | None:
        """Stand an object on the floor at a place in another object's frame, from its middle."""
        return self.stand(name, anchor.frame.moved(u, v, turn), size or self._size_of(name))

    def in_front(self, anchor: Placed | None, name: str, gap: float = 0.06) -> Placed | None:
        """Stand an object before another one's front, facing it.

        Args:
            anchor: Object; None does nothing, which saves callers a test.
            name: Category.
            gap: Distance between both, m.
        """
        if anchor is None:
            return None
        size = self._size_of(name)
        u = anchor.size[0] / 2 + gap + size[0] / 2
        return self.stand(name, anchor.frame.moved(u, 0.0, pi), size)

    def behind(self, anchor: Placed | None, name: str) -> Placed | None:
        """Stand an object behind another one, facing its back."""
        if anchor is None:
            return None
        size = self._size_of(name)
        u = -(anchor.size[0] / 2 + 0.06 + size[0] / 2)
        return self.stand(name, anchor.frame.moved(u, 0.0), size)

    def on(
        self, bearer: Placed | None, name: str, u: float, v: float, turn: float = 0.0
    ) -> Placed | None:
        """Lay an object on top of another one, at fractions of its half extents.

        Without a turn it shows its front to a person who sits before the lower object's front.
        """
        if bearer is None:
            return None
        size = self._size_of(name)
        if size[0] > bearer.size[0] - 0.04 or size[1] > bearer.size[1] - 0.04:
            return None
        # The larger side counts on both axes, because the object may be turned.
        reach_u = bearer.size[0] / 2 - max(size[:2]) / 2 - 0.02
        reach_v = bearer.size[1] / 2 - max(size[:2]) / 2 - 0.02
        return self.lie(bearer, name, u * max(0.0, reach_u), v * max(0.0, reach_v), size, turn)

    def spots(
        self,
        pitch_u: float,
        pitch_v: float,
        rim: float | tuple[float, float],
        *,
        is_tight: bool = False,
    ) -> list[tuple[float, float]]:
        """Places of a regular grid, row by row, at least a pitch apart and `rim` from the walls.

        A tight grid keeps its pitch about the middle; any other fills the room. Both leave the
        room's clear end free.
        """
        return grid_spots(
            self.room.size[:2], self._clear_end_m, (pitch_u, pitch_v), rim, is_tight=is_tight
        )

    def lie(
        self,
        bearer: Placed,
        name: str,
        u: float,
        v: float,
        size: Vector3,
        turn: float = 0.0,
        look: Attributes | None = None,
        rise: float | None = None,
    ) -> Placed | None:
        """Lay an object of a given size on another one, at a place in its frame.

        It lies on top, or on a board `rise` above the foot.
        """
        return self._builder.place(
            name,
            bearer.frame.moved(u, v, turn),
            size,
            base=None if rise is None else bearer.base + rise,
            parent=bearer,
            within=bearer,
            margin=GAP_M,
            look=look,
        )

    def is_free(self, spot: Frame, size: Vector3, *, or_reserved: bool = False) -> bool:
        """Return true if nothing of the room stands in a box on its floor.

        Reserved air, such as that before doors, counts as taken unless `or_reserved`.
        """
        return self._builder.is_free(
            spot, size, self.floor, inside=self.room, or_reserved=or_reserved
        )

    def keep_clear(self, placed: Placed, deep: float) -> None:
        """Keep the floor before an object's front clear of all that is placed from now on.

        Args:
            placed: Object.
            deep: Depth of the floor that stays clear, m.
        """
        spot = placed.frame.moved((placed.size[0] + deep) / 2, 0.0)
        self._builder.reserve(spot, (deep, placed.size[1], placed.size[2]), placed.base)

    def stand(
        self,
        name: str,
        spot: Frame,
        size: Vector3,
        margin: float = GAP_M,
        look: Attributes | None = None,
    ) -> Placed | None:
        """Stand an object on the floor at a place of the world, `margin` from everything.

        All other moves end here, which adds the room's style to the object's attributes.
        """
        # Low rooms, such as those under galleries, have no place for high furniture.
        if self.floor + size[2] > self.room.top:
            return None
        if name in _STYLED:
            # A look that is given goes before the room's style.
            look = {**self._style, **(look or {})}
        if name in self._forms:
            look = {"form": self._forms[name], **(look or {})}
        placed = self._builder.place(
            name,
            spot,
            size,
            base=self.floor,
            parent=self.room,
            within=self.room,
            margin=margin,
            look=look,
        )
        if placed and name in _BEARERS:
            self.bearers.append(placed)
        return placed
