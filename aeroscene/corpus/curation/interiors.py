"""Kinds of rooms: the function that furnishes each of them, under its name."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.room_space import RoomSpace
from aeroscene.corpus.curation.rooms import (
    bathrooms,
    care,
    fair,
    guests,
    home,
    public,
    storage,
    work,
)
from aeroscene.corpus.curation.rooms.extras import furnish_rest
from aeroscene.corpus.curation.rooms.interior import Interior
from aeroscene.corpus.curation.rooms.uses import USES

_SETTLED = 0.55
"""Fullness of rooms in a mixed scene when the rest of it begins to grow, relative to their use."""

FURNISHINGS: dict[str, Callable[[Interior], Iterator[None]]] = {
    "office": work.furnish_office,
    "open_office": work.furnish_open_office,
    "meeting": work.furnish_meeting,
    "workshop": work.furnish_workshop,
    "classroom": work.furnish_classroom,
    "library": work.furnish_library,
    "living": home.furnish_living,
    "bedroom": home.furnish_bedroom,
    "kitchen": home.furnish_kitchen,
    "dining": home.furnish_dining,
    "bathroom": bathrooms.furnish_bathroom,
    "washroom": bathrooms.furnish_washroom,
    "ward": care.furnish_ward,
    "practice": care.furnish_practice,
    "waiting": care.furnish_waiting,
    "cafe": guests.furnish_cafe,
    "restaurant": guests.furnish_restaurant,
    "galley": guests.furnish_galley,
    "lobby": public.furnish_lobby,
    "lounge": public.furnish_lounge,
    "corridor": public.furnish_corridor,
    "garden": public.furnish_garden,
    "gym": public.furnish_gym,
    "changing": public.furnish_changing,
    "court": public.furnish_court,
    "stand": public.furnish_stand,
    "concourse": public.furnish_concourse,
    "store": storage.furnish_store,
    "racks": storage.furnish_racks,
    "goods": storage.furnish_goods,
    "storage": storage.furnish_storage,
    "aisles": storage.furnish_aisles,
    "produce": storage.furnish_produce,
    "checkout": storage.furnish_checkout,
    "booths": fair.furnish_booths,
}
"""Furnishings of each kind of room: steps that each leave it whole, most characteristic first."""

__all__ = ["FURNISHINGS", "Interior", "furnish_room", "settle"]


def furnish_room(builder: Builder, draw: Draw, space: RoomSpace, kind: str = "") -> Iterator[None]:
    """Furnish a single room until it is full.

    Args:
        builder: Builder of the scene.
        draw: Randomness.
        space: Room; its own use decides on the furniture.
        kind: Kind of furniture for a room that has no use of its own.
    """
    kind = space.kind or kind
    room = Interior(builder, draw, space)
    yield from FURNISHINGS[kind](room)
    # The furniture of the use is exhausted first; the rest is taken from what any room may have.
    yield from furnish_rest(room, kind)


def settle(builder: Builder, space: RoomSpace, growth: Iterator[None]) -> None:
    """Let a room's furniture grow until it looks lived in, and leave the rest for later.

    Args:
        builder: Builder of the scene, whose fine objects are counted.
        space: Room.
        growth: Steps of `furnish_room`, which are not exhausted.
    """
    area = space.placed.size[0] * space.placed.size[1]
    wanted = builder.n_fine + _SETTLED * USES[space.kind].per_100_m2 * area / 100.0
    for _ in growth:
        if builder.n_fine >= wanted:
            return
