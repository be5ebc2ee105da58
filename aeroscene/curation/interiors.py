"""Kinds of rooms: which furniture stands where, and what lies on it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import pi

from aeroscene.curation.builder import Builder, Placed
from aeroscene.curation.draw import Draw
from aeroscene.curation.frame import QUARTER, Frame
from aeroscene.curation.shells import RoomSpace
from aeroscene.scene import AttributeValue, Vector3
from aeroscene.shapes.furniture import WOODS
from aeroscene.shapes.materials import FABRIC_COLOURS

_GAP_M = 0.03
"""Between furniture and the wall behind it."""

# Turn of the wall's frame in the room: v leads from the wall into the room.
_WALLS = {"front": QUARTER, "back": -QUARTER, "left": pi, "right": 0.0}
_TRIES = 7
_STYLED = frozenset(
    ("table", "chair", "desk", "cabinet", "shelf", "coffee_table", "nightstand", "sofa", "armchair")
)


class Interior:
    """Furnishes one room."""

    def __init__(self, builder: Builder, draw: Draw, space: RoomSpace) -> None:
        self._builder = builder
        self.draw = draw
        self.room = space.placed
        self.floor = space.floor
        # One room, one taste: furniture shares its wood and upholstery its colour.
        self._style: dict[str, AttributeValue] = {
            "wood": draw.one_of(WOODS),
            "colour": draw.one_of(FABRIC_COLOURS),
        }

    def wall(self, side: str) -> tuple[Frame, float]:
        """Frame in the middle of a wall's foot with v into the room, and the wall's length."""
        x, y, _ = self.room.size
        place: dict[str, tuple[float, float]] = {
            "front": (x / 2, 0),
            "back": (-x / 2, 0),
            "left": (0, y / 2),
            "right": (0, -y / 2),
        }
        length = y if side in {"front", "back"} else x
        return self.room.frame.moved(*place[side], _WALLS[side]), length

    def against(self, side: str, name: str, size: Vector3 | None = None) -> Placed | None:
        """Stand something with its back to a wall, where there is space."""
        size = size or self.draw.size_of(name)
        frame, length = self.wall(side)
        reach = length / 2 - size[1] / 2 - _GAP_M
        if reach < 0:
            return None
        v = size[0] / 2 + _GAP_M
        for _ in range(_TRIES):
            u = self.draw.between(-reach, reach)
            placed = self._stand(name, frame, u, v, size, QUARTER)
            if placed:
                return placed
        return None

    def anywhere(self, name: str, size: Vector3 | None = None, keep: float = 0.7) -> Placed | None:
        """Stand something freely in the room, square to it, `keep` from everything."""
        size = size or self.draw.size_of(name)
        x, y, _ = self.room.size
        reach_u, reach_v = x / 2 - size[0] / 2 - keep, y / 2 - size[1] / 2 - keep
        if min(reach_u, reach_v) < 0:
            return None
        for _ in range(_TRIES):
            u, v = self.draw.between(-reach_u, reach_u), self.draw.between(-reach_v, reach_v)
            placed = self._stand(name, self.room.frame, u, v, size, 0.0, margin=keep)
            if placed:
                return placed
        return None

    def beside(
        self,
        anchor: Placed,
        name: str,
        u: float,
        v: float,
        turn: float,
        size: Vector3 | None = None,
    ) -> Placed | None:
        """Stand something at a place in another object's frame."""
        return self._stand(name, anchor.frame, u, v, size or self.draw.size_of(name), turn)

    def in_front(self, anchor: Placed, name: str, gap: float = 0.06) -> Placed | None:
        """Stand something before an object's front, facing it."""
        size = self.draw.size_of(name)
        u = anchor.size[0] / 2 + gap + size[0] / 2
        return self._stand(name, anchor.frame, u, 0.0, size, pi)

    def on(
        self, bearer: Placed | None, name: str, u: float, v: float, turn: float = 0.0
    ) -> Placed | None:
        """Lay something on top of an object, at fractions of its half extents."""
        if bearer is None:
            return None
        size = self.draw.size_of(name)
        if size[0] > bearer.size[0] - 0.04 or size[1] > bearer.size[1] - 0.04:
            return None
        reach_u = bearer.size[0] / 2 - max(size[:2]) / 2 - 0.02
        reach_v = bearer.size[1] / 2 - max(size[:2]) / 2 - 0.02
        return self._builder.place(
            name,
            bearer.frame,
            u * max(0.0, reach_u),
            v * max(0.0, reach_v),
            size,
            base=bearer.top,
            turn=turn,
            parent=bearer,
            within=bearer,
        )

    def _stand(
        self,
        name: str,
        frame: Frame,
        u: float,
        v: float,
        size: Vector3,
        turn: float,
        margin: float = 0.02,
    ) -> Placed | None:
        return self._builder.place(
            name,
            frame,
            u,
            v,
            size,
            base=self.floor,
            turn=turn,
            parent=self.room,
            within=self.room,
            margin=margin,
            attributes=dict(self._style) if name in _STYLED else None,
        )


def _chairs_around(room: Interior, table: Placed, count: int) -> list[Placed]:
    """Chairs along the long sides of a table, facing it."""
    x, y, _ = table.size
    seats: list[Placed] = []
    per_side = max(1, int(y // 0.75))
    for index in range(min(count, 2 * per_side)):
        sign = 1 if index % 2 else -1
        size = room.draw.size_of("chair")
        v = (index // 2 - (per_side - 1) / 2) * 0.75
        turn = pi if sign > 0 else 0.0
        chair = room.beside(table, "chair", sign * (x / 2 + size[0] / 2 + 0.08), v, turn, size)
        if chair:
            seats.append(chair)
    return seats


def furnish_office(room: Interior) -> Iterator[None]:
    """Desks with screens and chairs, shelves, a cabinet, a plant."""
    for side in ("left", "right", "back"):
        for _ in range(2 if room.draw.chance(0.3) else 1):
            desk = room.against(side, "desk")
            if desk is None:
                continue
            room.in_front(desk, "chair")
            if room.draw.chance(0.65):
                room.on(desk, "monitor", -0.5, room.draw.between(-0.3, 0.3))
            else:
                room.on(desk, "laptop", 0.1, room.draw.between(-0.3, 0.3))
            if room.draw.chance(0.4):
                room.on(desk, room.draw.one_of(("book", "cup", "lamp")), 0.0, 0.9)
    room.against(room.draw.one_of(("left", "right")), room.draw.one_of(("shelf", "cabinet")))
    room.against(room.draw.one_of(("left", "right")), room.draw.one_of(("plant", "bin")))
    yield


def furnish_meeting(room: Interior) -> Iterator[None]:
    """A long table with chairs, a screen on a cabinet."""
    size = (1.2, room.draw.between(1.8, 2.6), 0.74)
    table = room.anywhere("table", size, keep=0.9)
    if table:
        _chairs_around(room, table, room.draw.count(4, 6))
        room.on(table, "laptop", 0.5, 0.4)
        room.on(table, "cup", -0.6, -0.3)
    cabinet = room.against(room.draw.one_of(("left", "right")), "cabinet")
    room.on(cabinet, "television", 0.0, 0.0)
    room.against("left", "plant")
    room.against("right", "shelf")
    yield


def furnish_living(room: Interior) -> Iterator[None]:
    """Sofa, coffee table and television in line; armchair, shelf, lamp, plant."""
    side = room.draw.one_of(("left", "right"))
    sofa = room.against(side, "sofa")
    if sofa:
        table = room.in_front(sofa, "coffee_table", gap=0.45)
        room.on(table, "book", 0.1, 0.5)
        room.on(table, "cup", -0.2, -0.6)
        room.beside(sofa, "lamp", 0.0, sofa.size[1] / 2 + 0.4, 0.0, (0.45, 0.45, 1.6))
    other = "left" if side == "right" else "right"
    cabinet = room.against(other, "cabinet", (0.45, 1.6, 0.72))
    room.on(cabinet, "television", 0.0, 0.0)
    room.against(other, "shelf")
    room.against("back", "armchair")
    room.against(side, "plant")
    yield


def furnish_bedroom(room: Interior) -> Iterator[None]:
    """A bed between nightstands, wardrobe, desk with chair."""
    side = room.draw.one_of(("left", "right"))
    bed = room.against(side, "bed")
    if bed:
        for sign in (-1, 1):
            u = -bed.size[0] / 2 + 0.25
            stand = room.beside(
                bed, "nightstand", u, sign * (bed.size[1] / 2 + 0.35), 0.0, (0.42, 0.5, 0.5)
            )
            if room.draw.chance(0.6):
                room.on(stand, "lamp", 0.0, 0.0)
    other = "left" if side == "right" else "right"
    room.against(other, "wardrobe")
    desk = room.against(other, "desk")
    if desk:
        room.in_front(desk, "chair")
        room.on(desk, "laptop", 0.0, 0.0)
    room.against("back", "plant")
    yield


def furnish_kitchen(room: Interior) -> Iterator[None]:
    """Counter, stove and fridge along one wall; a table set for a meal."""
    side = room.draw.one_of(("left", "right"))
    counter = room.against(side, "counter", (0.62, room.draw.between(1.8, 2.8), 0.92))
    room.on(counter, room.draw.one_of(("plate", "cup", "box")), 0.0, 0.5)
    room.against(side, "fridge")
    room.against(side, "stove")
    table = room.anywhere("table", keep=0.75)
    if table:
        for chair in _chairs_around(room, table, 4):
            u, v = table.frame.local(chair.frame.x, chair.frame.y)
            room.on(table, "plate", 0.8 if u > 0 else -0.8, 2 * v / table.size[1])
    room.against("back", "bin", (0.4, 0.4, 0.75))
    yield


def furnish_cafe(room: Interior) -> Iterator[None]:
    """A bar along one wall and small tables with chairs."""
    side = room.draw.one_of(("left", "right"))
    bar = room.against(side, "counter", (0.7, room.draw.between(2.4, 3.6), 1.05))
    for at in (-0.6, 0.5):
        room.on(bar, room.draw.one_of(("cup", "plate", "box")), 0.0, at)
    for _ in range(3):
        table = room.anywhere("table", (0.8, 0.9, 0.74), keep=0.75)
        if table:
            _chairs_around(room, table, 2)
            room.on(table, room.draw.one_of(("cup", "plate")), 0.4, 0.3)
    room.against("back", "plant")
    yield


def furnish_store(room: Interior) -> Iterator[None]:
    """Shelves along the walls, crates and boxes on the floor."""
    for side in ("left", "right", "left"):
        room.against(side, "shelf")
    for name in ("crate", "box", "box"):
        room.against(room.draw.one_of(("left", "right", "back")), name)
    counter = room.anywhere("counter", keep=0.8)
    room.on(counter, "box", 0.0, 0.6)
    room.on(counter, "laptop", 0.0, -0.5)
    yield


FURNISHINGS: dict[str, Callable[[Interior], Iterator[None]]] = {
    "office": furnish_office,
    "meeting": furnish_meeting,
    "living": furnish_living,
    "bedroom": furnish_bedroom,
    "kitchen": furnish_kitchen,
    "cafe": furnish_cafe,
    "store": furnish_store,
}
"""What each kind of room contains."""
