"""What stands on roofs."""

from __future__ import annotations

from aeroscene.curation.builder import Builder, Placed
from aeroscene.curation.draw import Draw
from aeroscene.curation.frame import Frame
from aeroscene.scene import AttributeValue
from aeroscene.shapes.buildings import ROOF_SLAB_M

PARAPET_RISE_M = 0.45


def add_flat_roof(builder: Builder, building: Placed, *, parapet: bool = True) -> Placed | None:
    """A slab over a building's outline, with a parapet."""
    x, y, _ = building.size
    height = ROOF_SLAB_M + (PARAPET_RISE_M if parapet else 0.0)
    return builder.place(
        "roof",
        building.frame,
        0,
        0,
        (x, y, height),
        base=building.top,
        parent=building,
        attributes={"form": "flat"},
    )


def add_pitched_roof(builder: Builder, draw: Draw, building: Placed) -> Placed | None:
    """A gable or hip roof with overhanging eaves; its ridge runs along the longer side."""
    x, y, _ = building.size
    along_x = x >= y
    run, span = (x, y) if along_x else (y, x)
    size = (run + 0.8, span + 0.8, round(0.32 * span, 2))
    attributes: dict[str, AttributeValue] = {
        "form": draw.one_of(("gable", "hip")),
        "tiles": draw.one_of(("roof_red", "roof_slate")),
    }
    turn = 0.0 if along_x else 1.5707963267948966
    return builder.place(
        "roof",
        building.frame,
        0,
        0,
        size,
        base=building.top,
        turn=turn,
        parent=building,
        attributes=attributes,
    )


def equip_flat_roof(builder: Builder, draw: Draw, roof: Placed, *, items: int) -> None:
    """Scatter machines over a flat roof, in rows along its sides, and leave room to land."""
    deck = roof.base + ROOF_SLAB_M
    x, y, _ = roof.size
    names = ["ac_unit", "ac_unit", "solar_panel", "solar_panel", "chimney", "water_tank", "antenna"]
    for _ in range(items):
        name = draw.one_of(names)
        size = draw.size_of(name, 0.25)
        room_u, room_v = x / 2 - 0.5 - size[0] / 2, y / 2 - 0.5 - size[1] / 2
        if room_u <= 0.1 or room_v <= 0.1:
            continue
        for _ in range(4):
            u = draw.between(-room_u, room_u)
            v = (1 if draw.chance(0.5) else -1) * room_v * draw.between(0.8, 1.0)
            if builder.place(
                name, roof.frame, u, v, size, base=deck, parent=roof, margin=0.25, within=roof
            ):
                break


def add_roof_pad(builder: Builder, draw: Draw, roof: Placed) -> Placed | None:
    """A landing pad on a flat roof."""
    side = draw.between(2.6, 3.2)
    x, y, _ = roof.size
    free_u, free_v = x / 2 - side / 2 - 0.8, y / 2 - side / 2 - 0.8
    if min(free_u, free_v) < 0.2:
        return None
    u, v = draw.between(-free_u, free_u), draw.between(-free_v, free_v)
    return builder.place(
        "landing_pad",
        roof.frame,
        u,
        v,
        (side, side, 0.05),
        base=roof.base + ROOF_SLAB_M,
        parent=roof,
        margin=0.3,
    )


def add_chimney(builder: Builder, draw: Draw, roof: Placed) -> None:
    """A stack that rises through a pitched roof near its ridge."""
    frame: Frame = roof.frame
    u = draw.between(-0.3, 0.3) * roof.size[0]
    foot = roof.base + 0.45 * roof.size[2]
    size = (0.7, 0.7, round(0.55 * roof.size[2] + 0.8, 2))
    builder.place("chimney", frame, u, 0.06 * roof.size[1], size, base=foot, parent=roof)
