"""Coarse structures that stand in halls: stalls, stages, seating steps, containers, nets."""

from __future__ import annotations

from collections.abc import Callable
from math import pi

from aeroscene.corpus.curation.builder import Attributes, Placed
from aeroscene.corpus.curation.rooms.interior import SIDES, Interior
from aeroscene.scene import Vector3
from aeroscene.solids.shapes.materials import PAINT_COLOURS

_LANDING_M = (3.0, 0.9)
"""Depth and height of the landing above seating steps."""


def _painted(room: Interior) -> Attributes:
    return {"colour": room.draw.one_of(PAINT_COLOURS)}


def _tucked(
    room: Interior, name: str, size: Vector3, look: Attributes | None = None
) -> Placed | None:
    """Place an object along one of the walls."""
    return room.against(room.some_side(), name, size, look=look)


def _kiosk(room: Interior) -> Placed | None:
    return _tucked(room, "kiosk", (2.2, room.draw.between(2.4, 2.8), 2.5), _painted(room))


def _garden(room: Interior) -> Placed | None:
    size = (room.draw.between(2.4, 3.2), room.draw.between(2.6, 4.0), 0.25)
    lawn = _tucked(room, "lawn", size)
    if lawn:
        # Two bushes at opposite corners leave the middle free.
        half = (size[0] / 2 - 0.8, size[1] / 2 - 0.8)
        room.lie(lawn, "bush", half[0] * 0.8, -half[1] * 0.8, (1.2, 1.2, 1.3))
        room.lie(lawn, "bush", -half[0] * 0.8, half[1] * 0.8, (1.0, 1.0, 1.6))
    return lawn


def _pond(room: Interior) -> Placed | None:
    return _tucked(room, "water", (3.0, room.draw.between(3.0, 3.6), 0.4))


def _podium(room: Interior) -> Placed | None:
    size = (room.draw.between(3.0, 3.6), room.draw.between(3.0, 4.0), room.draw.between(0.2, 0.45))
    return _tucked(room, "deck", size)


def _platform(room: Interior) -> Placed | None:
    x, y, _ = room.room.size
    return _tucked(room, "deck", (3.0, room.draw.between(6.0, max(6.1, 0.8 * max(x, y))), 0.55))


def _dock(room: Interior) -> Placed | None:
    return _tucked(room, "deck", (3.0, room.draw.between(3.5, 6.0), 0.9))


def _bleachers(room: Interior) -> Placed | None:
    """Seating steps that climb to a landing along the wall."""
    width, rise = room.draw.between(4.0, 7.5), _LANDING_M[1]
    size = (_LANDING_M[0], width, rise)
    landing = room.against(room.long_side(), "deck", size)
    if landing:
        # The stairs' run is twice their rise, a slope that people climb.
        run = 2 * rise
        at = (landing.size[0] + run) / 2
        room.beside(landing, "stairs", at, 0.0, pi, (run, width, rise))
        count = int(width // 2.1)
        for index in range(count):
            v = (index - (count - 1) / 2) * 2.1
            room.lie(landing, "bench", -0.9, v, (0.45, 1.9, 0.85))
    return landing


def _net(room: Interior) -> Placed | None:
    """A net or a rail between this zone and the one into which it opens."""
    size = (0.1, room.draw.between(3.0, 7.0), room.draw.between(1.1, 2.0))
    for side in SIDES:
        # A walled side needs no net.
        if side in room.sides:
            continue
        frame, _ = room.wall(side)
        # Just inside the border; the fence runs along it.
        u, v = room.room.frame.local(*frame.point(0.0, 0.3))
        turn = frame.yaw + pi / 2 - room.room.frame.yaw
        net = room.put("fence", u, v, size, turn, look={"form": "rails"})
        if net:
            return net
    return None


def _screen(room: Interior) -> Placed | None:
    """A low wall that stands out from a wall, as between seats."""
    size = (0.1, room.draw.between(2.0, 3.0), 1.5)
    colour = room.draw.one_of(("sky", "sage", "ochre", "slate"))
    return room.against(room.some_side(), "wall", size, turn=pi / 2, look={"colour": colour})


def _shelter(room: Interior) -> Placed | None:
    return _tucked(room, "canopy", (2.2, room.draw.between(3.0, 4.5), 2.8), _painted(room))


def _pavilion(room: Interior) -> Placed | None:
    size = (room.draw.between(2.8, 3.4), room.draw.between(3.2, 4.6), 2.9)
    return _tucked(room, "canopy", size, _painted(room))


def _stall(room: Interior) -> Placed | None:
    """A stand of a fair: a stage with a coloured wall behind it."""
    width = room.draw.between(3.2, 4.2)
    stage = _tucked(room, "deck", (3.0, width, 0.16))
    if stage:
        colour = room.draw.one_of(("sky", "sage", "ochre", "rose", "slate"))
        room.lie(stage, "wall", -1.4, 0.0, (0.12, width - 0.1, 2.5), look={"colour": colour})
    return stage


def _container(room: Interior) -> Placed | None:
    size = (6.06, 2.44, 2.59)
    side = room.some_side()
    # The long side lies along the wall more often than across it.
    turn = pi / 2 if room.draw.chance(0.8) else 0.0
    box = room.against(side, "container", size, turn, _painted(room))
    # A second container on top needs a hall that leaves air above it.
    if box and room.room.size[2] > 7.0 and room.draw.chance(0.3):
        room.lie(box, "container", 0.0, 0.0, size, look=_painted(room))
    return box


def _cabin(room: Interior) -> Placed | None:
    """A foreman's hut."""
    return _tucked(room, "kiosk", (2.6, 3.2, 2.8), {"colour": "white"})


FEATURES: dict[str, Callable[[Interior], Placed | None]] = {
    "kiosk": _kiosk,
    "garden": _garden,
    "pond": _pond,
    "podium": _podium,
    "platform": _platform,
    "dock": _dock,
    "bleachers": _bleachers,
    "net": _net,
    "screen": _screen,
    "shelter": _shelter,
    "pavilion": _pavilion,
    "stall": _stall,
    "container": _container,
    "cabin": _cabin,
}
"""Functions that place one structure in a zone each, or return None if none fits."""

_PLACES: dict[str, frozenset[str]] = {
    name: frozenset(kinds.split())
    for name, kinds in (
        ("kiosk", "lobby lounge concourse cafe booths stand garden checkout produce court gym"),
        ("garden", "lobby lounge garden concourse cafe library booths"),
        ("pond", "garden lobby lounge concourse"),
        (
            "podium",
            "lobby lounge booths cafe gym library garden open_office living stand classroom",
        ),
        ("platform", "concourse"),
        ("dock", "goods"),
        ("bleachers", "court lobby stand gym"),
        ("net", "court goods racks gym concourse storage"),
        ("screen", "open_office lounge library cafe booths classroom lobby living workshop"),
        ("shelter", "court concourse garden"),
        ("pavilion", "garden lounge booths lobby cafe concourse produce"),
        ("stall", "booths lobby produce checkout"),
        ("container", "goods racks"),
        ("cabin", "goods racks workshop"),
    )
}
"""Kinds of zones for each structure."""


def suits(feature: str, kind: str) -> bool:
    """Return true if a structure belongs in a kind of zone.

    Args:
        feature: Name of `FEATURES`.
        kind: Kind of a zone.
    """
    return kind in _PLACES[feature]
