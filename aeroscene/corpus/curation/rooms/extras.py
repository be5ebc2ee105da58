"""Further objects of a room beyond those that make its kind: the long tail of furnishing."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.rooms.contents import BOOKS, CARTONS, stock, strew
from aeroscene.corpus.curation.rooms.interior import Interior
from aeroscene.corpus.curation.rooms.tables import seats
from aeroscene.scene import Vector3

_ROUNDS = 30
_PITCH_M = (2.9, 2.7)
_RIM_M = 1.6
"""Distance between free-standing objects, and their distance from the walls."""
_FREE_SIZES: dict[str, Vector3] = {
    "table": (0.95, 1.3, 0.74),
    "coffee_table": (0.9, 1.1, 0.45),
    "desk": (0.86, 1.6, 0.74),
    "counter": (0.85, 2.0, 0.95),
    "crate": (1.05, 1.05, 0.7),
    "pallet": (1.25, 1.15, 0.7),
    "landing_pad": (1.6, 1.6, 0.06),
    "planter": (0.8, 1.8, 0.9),
    "bench": (0.45, 1.8, 0.45),
}
"""Sizes of free-standing objects: wide enough for a small drone if they are level."""
_SEATED = {"table": "chair", "coffee_table": "armchair"}

# Free-standing furniture, furniture against walls, small things on top.
_Accents = tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]
_PUBLIC: _Accents = (("table", "planter"), ("bench", "plant", "bin"), ("cup", "book"))
_WORK: _Accents = ((), ("cabinet", "shelf", "plant", "box"), ("book", "cup", "box"))
_HOME: _Accents = (
    (),
    ("cabinet", "plant", "shelf", "lamp", "box", "armchair"),
    ("book", "cup", "lamp"),
)
_WASHING: _Accents = ((), ("cabinet", "shelf", "plant", "box", "bin"), ("cup", "box"))
_SEATING: _Accents = (("coffee_table",), ("armchair", "plant", "shelf", "lamp"), ("book", "cup"))
_CARE: _Accents = ((), ("cabinet", "shelf", "armchair", "bin", "plant"), ("box", "cup", "book"))
_COOKING: _Accents = ((), ("counter", "shelf", "cabinet", "box"), ("cup", "plate", "box"))
_GOODS: _Accents = (("pallet", "crate"), ("crate", "bin", "shelf", "box"), ("box",))
_SPORT: _Accents = (
    ("landing_pad", "crate", "bench"),
    ("bench", "bin", "box"),
    ("box", "book"),
)
_ACCENTS: dict[str, _Accents] = {
    **dict.fromkeys(("office", "open_office", "meeting", "classroom", "library"), _WORK),
    **dict.fromkeys(("living", "bedroom", "dining"), _HOME),
    **dict.fromkeys(("bathroom", "washroom"), _WASHING),
    **dict.fromkeys(("ward", "practice", "waiting"), _CARE),
    **dict.fromkeys(("kitchen", "galley"), _COOKING),
    "lounge": _SEATING,
    **dict.fromkeys(("store", "racks", "goods", "storage", "workshop", "aisles"), _GOODS),
    **dict.fromkeys(("gym", "court", "changing", "stand"), _SPORT),
    "booths": (("table", "crate"), ("plant", "sign", "cabinet"), ("book", "cup", "box")),
    "produce": (("crate", "pallet", "table"), ("fridge", "bin", "plant"), ("box",)),
    "checkout": (("crate", "table"), ("bin", "plant", "bench"), ("box", "cup")),
    "corridor": ((), ("plant", "cabinet", "bench"), ("book",)),
}
_STOCKS = {
    **dict.fromkeys(("bathroom", "washroom"), CARTONS),
    **dict.fromkeys(("store", "racks", "goods", "storage", "workshop", "aisles"), CARTONS),
    **dict.fromkeys(("kitchen", "galley"), ("plate", "box", "cup")),
}
"""Contents of shelves that hold no books."""


def furnish_rest(room: Interior, kind: str) -> Iterator[None]:
    """Add more objects that suit a kind of room, as long as there is space for them.

    Args:
        room: Room whose kind has been furnished.
        kind: Kind of the room; an unknown one gets what public rooms have.
    """
    free, lining, small = _ACCENTS.get(kind, _PUBLIC)
    draw = room.draw
    spots = iter(room.spots(*_PITCH_M, _RIM_M, is_tight=True))
    name = draw.one_of(free) if free else ""
    for number in range(_ROUNDS):
        # Free-standing objects in every other round, so that walls fill as well.
        if free and number % 2 == 0:
            stand = _next_in_rows(room, spots, name)
            if name in _SEATED:
                seats(room, stand, 2, _SEATED[name])
            yield
        for placed in room.lined(room.some_side(), draw.one_of(lining), 2 if free else 1, gap=0.3):
            if placed.name == "shelf":
                stock(room, placed, _STOCKS.get(kind, BOOKS))
        yield
        # Each piece of furniture has its turn in one of the rounds.
        for bearer in islice(room.bearers, number, None, _ROUNDS):
            strew(room, bearer, small, 2)
            yield


def _next_in_rows(room: Interior, spots: Iterator[tuple[float, float]], name: str) -> Placed | None:
    """Stand an object at the next free place of a grid, or return None if none is left."""
    for u, v in spots:
        placed = room.put(name, u, v, _FREE_SIZES[name], keep=0.5)
        if placed:
            return placed
    return None
