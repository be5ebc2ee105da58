"""Buildings of a place that a drone can enter."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from aeroscene.corpus.curation.builder import Attributes
from aeroscene.corpus.curation.frame import STREETWARD
from aeroscene.corpus.curation.interiors import furnish_room, settle
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.shells import RoomSpace, Shell, raise_shell
from aeroscene.scene import Vector3
from aeroscene.solids.shapes.facade import WALL_M
from aeroscene.solids.shapes.materials import WALL_COLOURS

_GATE_AIR_M = (7.0, 4.6, 3.8)
"""Air kept free in each gate of a hall."""
_CEILING_M = 0.3
"""Thickness of a hall's roof."""


def raise_furnished(
    ground: Ground,
    name: str,
    u: float,
    v: float,
    *,
    deep: float,
    length: float,
    storeys: int,
    kinds: Sequence[str],
) -> Shell | None:
    """Raise an enterable building with its door to the street.

    Args:
        ground: Parcel.
        name: Category of the shell.
        u: Middle along the street, m.
        v: Middle, m from the street.
        deep: Depth, m.
        length: Length along the street, m.
        storeys: Number of storeys.
        kinds: Kinds of its rooms, in turn.

    Returns:
        The building and its rooms, or None if it does not fit.
    """
    return raise_shell(
        ground.builder,
        ground.draw,
        ground.parcel.frame,
        (u, v),
        name=name,
        depth=deep,
        length=length,
        storeys=storeys,
        base=ground.level,
        turn=STREETWARD,
        colour=ground.draw.one_of((*WALL_COLOURS, "brick")),
        kinds=kinds,
    )


def raise_hall(ground: Ground, u: float, v: float, size: Vector3, look: Attributes) -> Shell | None:
    """Raise an enterable warehouse: one room, with the air in its two gates kept free.

    Args:
        ground: Parcel.
        u: Middle along the street, m.
        v: Middle, m from the street.
        size: Extents of the hall.
        look: Attributes of the hall.

    Returns:
        The hall and its room, or None if it does not fit.
    """
    hall = ground.erect("warehouse", u, v, size, look={**look, "is_enterable": True})
    if hall is None:
        return None
    inner = (size[0] - 2 * WALL_M, size[1] - 2 * WALL_M, round(size[2] - _CEILING_M, 2))
    look = {"finish": "concrete"}
    room = ground.builder.place(
        "room", hall.frame, inner, base=hall.base, parent=hall, domain="indoor", look=look
    )
    for sign in (-1, 1):
        at = sign * hall.size[0] / 2
        # Just above the floor, so that the floor itself does not count as in the way.
        ground.builder.reserve(hall.frame.moved(at, 0.0), _GATE_AIR_M, hall.base + 0.05)
    rooms = (RoomSpace(room),) if room else ()
    return Shell(hall, rooms, size[2])


def furnish(
    ground: Ground, rooms: Sequence[RoomSpace], kinds: Sequence[str] = ()
) -> Iterator[None]:
    """Furnish all rooms of a place.

    Rooms with a use of their own are furnished at once, so that none looks empty. The others are of
    the kinds in turn, and grow side by side with the rest of the place.

    Args:
        ground: Parcel of the building.
        rooms: Rooms.
        kinds: Kinds of furniture for rooms that have no use of their own.
    """
    growths = [
        furnish_room(ground.builder, ground.draw, space, kinds[index % len(kinds)] if kinds else "")
        for index, space in enumerate(rooms)
    ]
    if any(space.kind for space in rooms):
        for space, growth in zip(rooms, growths, strict=True):
            settle(ground.builder, space, growth)
        yield
    yield from interleave(*growths)
