"""Bathrooms of homes, and washrooms of buildings that many people use."""

from __future__ import annotations

from collections.abc import Iterator

from aeroscene.corpus.curation.builder import Attributes, Placed
from aeroscene.corpus.curation.frame import QUARTER
from aeroscene.corpus.curation.rooms.contents import CARTONS, stock, strew
from aeroscene.corpus.curation.rooms.interior import GAP_M, Interior
from aeroscene.scene import Vector3

_CLEAR_M = {"toilet": 0.6, "basin": 0.7, "bath": 0.6}
"""Depth of the floor that stays clear before each fitting, as building codes ask for."""
_ASIDE_M = {"toilet": 0.15, "basin": 0.05, "bath": GAP_M}
"""Least distance from the sides of a fitting to a wall or another object."""
_STEP_M = 0.12
"""Distance between the places along a wall that are tried."""
_BOOTH_M = 0.9
"""Distance between the middles of toilets side by side."""
_TROUGH_M2 = 14.0
"""Area from which washrooms have two troughs."""
_SMALL_M2 = 12.6
"""Area up to which bathrooms have a shower and a single basin."""
_TUB_M = 1.62
"""Shortest tub."""


def furnish_bathroom(room: Interior) -> Iterator[None]:
    """Stand a tub or a shower, a toilet and a basin; then towels on a shelf, a cabinet, a bin."""
    draw = room.draw
    # The bath needs a corner, and the toilet fits below windows.
    if room.area > _SMALL_M2:
        _stand_bath(room)
    stand_fittings(room, "toilet", _toilet_size(room), look=_toilet(room))
    if room.area <= _SMALL_M2:
        _stand_bath(room)
    wide = draw.between(0.5, 0.8)
    if room.area > _SMALL_M2 and draw.chance(0.3):
        wide = draw.between(1.2, 1.4)
    form = draw.one_of(("pedestal", "vanity")) if wide < 0.9 else "vanity"
    basin = (draw.between(0.46, 0.54), wide, 0.95)
    # The drawn basin first, then the smallest one.
    for size in (basin, (0.42, 0.46, 0.9)):
        if stand_fittings(room, "basin", size, look={"form": form}):
            break
    yield
    cabinet = room.against(room.some_side(), "cabinet", (0.35, draw.between(0.6, 0.9), 0.85))
    strew(room, cabinet, ("cup", "box", "plant", "cup"), 2)
    yield
    room.against(room.some_side(), "box", (0.4, 0.5, 0.55))
    room.against(room.some_side(), "bin", (0.35, 0.35, 0.7))
    yield
    shelf = room.against(room.some_side(), "shelf", (0.3, 0.7, 1.7))
    stock(room, shelf, CARTONS)
    yield
    room.against(room.some_side(), "plant")
    yield


def furnish_washroom(room: Interior) -> Iterator[None]:
    """Stand toilets along one wall and troughs to wash at along another, then bins and a shelf."""
    draw = room.draw
    side = room.long_side()
    count = max(1, min(5, int(room.wall(side)[1] // 1.3)))
    stand_fittings(room, "toilet", _toilet_size(room), count, _BOOTH_M, side, _toilet(room))
    n_troughs = 2 if room.area > _TROUGH_M2 else 1
    trough = (0.5, draw.between(1.2, 1.5), 1.0)
    look: Attributes = {"form": draw.one_of(("trough", "vanity"))}
    others = [each for each in room.sides if each != side] or [side]
    other = draw.one_of(others)
    if not stand_fittings(room, "basin", trough, n_troughs, trough[1] + 0.06, other, look):
        single: Attributes = {"form": "pedestal"}
        stand_fittings(room, "basin", (0.42, 0.48, 0.9), 2, 0.7, other, single)
    yield
    room.lined(room.some_side(), "bin", 2, (0.4, 0.4, 0.8))
    yield
    cabinet = room.against(room.some_side(), "cabinet", (0.4, draw.between(0.7, 1.1), 0.9))
    strew(room, cabinet, ("box", "plant", "cup"), 2)
    yield
    shelf = room.against(room.some_side(), "shelf", (0.34, 0.8, 1.8))
    stock(room, shelf, CARTONS)
    yield
    room.against(room.some_side(), "box", (0.4, 0.5, 0.5))
    room.against(room.some_side(), "plant")
    yield


def _stand_bath(room: Interior) -> None:
    """A tub along a wall, or a shower if the tub has no space, and sometimes by chance."""
    draw = room.draw
    if room.area > _SMALL_M2 and draw.chance(0.6):
        tub = (draw.between(0.72, 0.8), draw.between(_TUB_M, 1.8), draw.between(0.55, 0.6))
        if stand_fittings(room, "bath", tub, look={"form": draw.one_of(("tub", "tub", "oval"))}):
            return
    shower = (draw.between(0.8, 0.95), draw.between(0.8, 1.2), 2.05)
    for size in (shower, (0.75, 0.8, 2.05)):
        if stand_fittings(room, "bath", size, look={"form": "shower"}):
            return


def _toilet_size(room: Interior) -> Vector3:
    """A size whose cistern ends below a window's sill."""
    return (room.draw.between(0.6, 0.68), 0.38, 0.74)


def _toilet(room: Interior) -> Attributes:
    """The form that all toilets of a room share."""
    return {"form": room.draw.one_of(("cistern", "panel", "open"))}


def stand_fittings(
    room: Interior,
    name: str,
    size: Vector3,
    count: int = 1,
    pitch: float = 0.0,
    side: str | None = None,
    look: Attributes | None = None,
) -> list[Placed]:
    """Stand fittings with their backs to a wall, and keep the floor before them clear.

    Tries the corners first, then the places between them, along the walls in a random order with
    `side` first. If no wall has space for a row, the row gets one fitting less.

    Args:
        room: Room to furnish.
        name: Category.
        size: Extents of one fitting, m.
        count: Most fittings in the row.
        pitch: Distance between the middles of neighbours, m.
        side: Wall to try first.
        look: Attributes of each fitting.

    Returns:
        The fittings that stand, at most `count`.
    """
    walls = [room.sides[i] for i in room.draw.shuffled(range(len(room.sides)))]
    walls.sort(key=lambda wall: wall != side)
    for number in range(count, 0, -1):
        for wall in walls:
            row = _stand_row(room, wall, name, size, number, pitch, look)
            if row:
                return row
    return []


def _stand_row(
    room: Interior,
    wall: str,
    name: str,
    size: Vector3,
    count: int,
    pitch: float,
    look: Attributes | None,
) -> list[Placed]:
    frame, length = room.wall(wall)
    clear, aside = _CLEAR_M[name], _ASIDE_M[name]
    long = (count - 1) * pitch + size[1] + 2 * aside
    deep = size[0] + GAP_M + clear
    play = length - long
    if play < 0 or room.depth(wall) < deep:
        return []
    n_steps = int(play // _STEP_M)
    between = room.draw.shuffled(range(1, n_steps)) if n_steps > 1 else []
    first = -length / 2 + long / 2
    # Both corners first, then random places between them.
    for start in (first, first + play, *(first + step * play / n_steps for step in between)):
        # The wall itself bounds the space at the back and at the sides. People stand before
        # fittings where they walk through doors, too, and before two fittings at one place.
        taken, floor = (frame.moved(start, far / 2 + 0.01, QUARTER) for far in (size[0], deep))
        is_free = room.is_free(taken, (size[0], long - 0.02, size[2]))
        if not is_free or not room.is_free(
            floor, (deep - 0.02, long - 0.02, size[2]), or_reserved=True
        ):
            continue
        row: list[Placed] = []
        for index in range(count):
            at = start + (index - (count - 1) / 2) * pitch
            spot = frame.moved(at, size[0] / 2 + GAP_M, QUARTER)
            placed = room.stand(name, spot, size, 0.0, look)
            row += [placed] if placed else []
        for placed in row:
            room.keep_clear(placed, clear)
        if row:
            return row
    return []
