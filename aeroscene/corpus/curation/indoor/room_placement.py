"""Rooms of a plan, laid between its walls."""

from __future__ import annotations

from collections.abc import Mapping

from aeroscene.corpus.curation.builder import Builder, Placed
from aeroscene.corpus.curation.indoor.zones import Side, Zone
from aeroscene.corpus.curation.room_space import RoomSpace


def lay_room(
    builder: Builder, shell: Placed, zone: Zone, margin: Mapping[Side, float], finish: str
) -> RoomSpace | None:
    """Place the room of a zone.

    Args:
        builder: Builder of the scene.
        shell: Building that contains the room.
        zone: Rectangle of the plan.
        margin: Distance of the room from each border of the zone, m.
        finish: Material of the floor.

    Returns:
        The room, or None if the builder refuses it.
    """
    x0, x1 = zone.x0 + margin["x0"], zone.x1 - margin["x1"]
    y0, y1 = zone.y0 + margin["y0"], zone.y1 - margin["y1"]
    placed = builder.place(
        "room",
        shell.frame.moved((x0 + x1) / 2, (y0 + y1) / 2),
        (x1 - x0, y1 - y0, zone.clear),
        base=zone.level,
        parent=shell,
        domain="indoor",
        look={"finish": finish, "use": zone.kind},
    )
    return RoomSpace(placed, zone.kind) if placed else None
