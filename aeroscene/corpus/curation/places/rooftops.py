"""Roofs of buildings, and equipment on them: machines in rows, solar arrays, gardens."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import sin

from aeroscene.corpus.curation.builder import Builder, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import QUARTER, Frame
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.seating import dine
from aeroscene.corpus.curation.places.support_surfaces import Platform
from aeroscene.solids.shapes.roofs import ROOF_SLAB_M

PARAPET_RISE_M = 0.45
_INSET_M = 0.5
"""Distance of equipment from a roof's edge: the parapet and a hand's breadth."""
_OVERHANG_M = 0.4
"""Eaves beyond the wall."""
MONOPITCH_SLOPE = 0.12
"""Rise over run of a monopitch roof, 6.8 degrees: gentle enough to land on."""
_SOLAR_M = (1.5, 3.0, 0.75)
_DECK_M = 0.15
TILES = ("roof_red", "roof_slate")
"""Tiles of pitched roofs."""


def add_flat_roof(builder: Builder, building: Placed, *, parapet: bool = True) -> Placed | None:
    """Add a slab over a building's outline, with a parapet.

    Args:
        builder: Builder of the scene.
        building: Building.
        parapet: False for a bare slab, as on houses.

    Returns:
        The roof, or None if something is in the way.
    """
    x, y, _ = building.size
    height = ROOF_SLAB_M + (PARAPET_RISE_M if parapet else 0.0)
    size = (x, y, height)
    return builder.place("roof", building.frame, size, parent=building, look={"form": "flat"})


def add_pitched_roof(builder: Builder, draw: Draw, building: Placed) -> Placed | None:
    """Add a gable or hip roof with overhanging eaves; its ridge runs along the longer side."""
    x, y, _ = building.size
    run, span = max(x, y), min(x, y)
    size = (run + 2 * _OVERHANG_M, span + 2 * _OVERHANG_M, round(0.32 * span, 2))
    look = {"form": draw.one_of(("gable", "hip")), "tiles": draw.one_of(TILES)}
    # The ridge of a roof runs along its x axis.
    spot = building.frame.moved(0, 0, 0.0 if x >= y else QUARTER)
    return builder.place("roof", spot, size, parent=building, look=look)


def add_row_roof(builder: Builder, building: Placed, tiles: str) -> Placed | None:
    """Add a gable roof for a building in a row; its ridge runs along the row.

    It ends flush with all four walls, because a neighbour may stand at either side, and the
    pavement begins at the front.
    """
    deep, length, _ = building.size
    size = (length, deep, round(0.3 * deep, 2))
    look = {"form": "gable", "tiles": tiles}
    spot = building.frame.moved(0.0, 0.0, QUARTER)
    return builder.place("roof", spot, size, parent=building, look=look)


def add_monopitch_roof(builder: Builder, building: Placed) -> Placed | None:
    """Add one plane that rises towards the building's front, gentle enough to land on.

    Returns:
        The roof, or None if something is in the way.
    """
    x, y, _ = building.size
    size = (x + 2 * _OVERHANG_M, y + 2 * _OVERHANG_M, round(0.2 + MONOPITCH_SLOPE * x, 2))
    return builder.place("roof", building.frame, size, parent=building, look={"form": "shed"})


def add_chimney(builder: Builder, draw: Draw, roof: Placed) -> None:
    """Add a stack that rises through a pitched roof near its ridge.

    Nothing happens if it does not fit.

    Args:
        builder: Builder of the scene.
        draw: Randomness.
        roof: Roof with a ridge along its x axis.
    """
    u = draw.between(-0.3, 0.3) * roof.size[0]
    # The foot is inside the roof, below its plane; the stack ends 0.8 m above the ridge.
    foot = roof.base + 0.45 * roof.size[2]
    size = (0.7, 0.7, round(0.55 * roof.size[2] + 0.8, 2))
    builder.place("chimney", roof.frame.moved(u, 0.06 * roof.size[1]), size, base=foot, parent=roof)


@dataclass(frozen=True, slots=True)
class RoofTop:
    """The walkable face of a flat roof: u along its longer side."""

    platform: Platform
    frame: Frame
    half_u: float
    half_v: float

    def at_end(self, side: int, share: float) -> tuple[float, float]:
        """Borders of a share of the roof at one end.

        Args:
            side: End, 1 or -1.
            share: Share of the roof, 0 to 1.

        Returns:
            The lower and the upper border, as u, m.
        """
        inner, outer = side * self.half_u * (1 - 2 * share), side * self.half_u
        return (min(inner, outer), max(inner, outer))


def roof_top(builder: Builder, draw: Draw, roof: Placed) -> RoofTop:
    """Face between the parapets of a flat roof, as a surface that carries things.

    Args:
        builder: Builder of the scene.
        draw: Randomness of everything that stands on it.
        roof: Flat roof.
    """
    x, y, _ = roof.size
    frame = roof.frame if x >= y else roof.frame.moved(0, 0, QUARTER)
    platform = Platform(builder, draw, roof, roof.base + ROOF_SLAB_M)
    return RoofTop(platform, frame, max(x, y) / 2 - _INSET_M, min(x, y) / 2 - _INSET_M)


def furnish_flat_roof(builder: Builder, draw: Draw, roof: Placed) -> Iterator[None]:
    """Furnish a flat roof: machines along one edge; panels, a pad or nothing at one end.

    Args:
        builder: Builder of the scene.
        draw: Randomness.
        roof: Flat roof.
    """
    top = roof_top(builder, draw, roof)
    side = 1 if draw.chance(0.5) else -1
    use = draw.one_of(("solar", "solar", "pad", "open"))
    ends = iter(())
    if use == "solar" and top.half_u > 3.5:
        # A small roof has no room for panels beside its machines.
        ends = _solar_array(top, top.at_end(side, 0.45))
    elif use == "pad":
        ends = _pad(top, side)
    yield from interleave(ends, _machines(top))


def _machines(top: RoofTop) -> Iterator[None]:
    """Air conditioners in a row along one edge, then a tank, a mast and chimneys in corners."""
    platform, draw = top.platform, top.platform.draw
    edge = 1 if draw.chance(0.5) else -1
    size = draw.size_of("ac_unit", 0.3)
    pitch = size[1] + 0.5
    # At least one machine, and a row that keeps off both ends.
    count = min(draw.count(2, 5), max(1, int(1.2 * top.half_u / pitch)))
    v = edge * (top.half_v - size[0] / 2)
    for index in range(count):
        u = (index - (count - 1) / 2) * pitch
        turn = -edge * QUARTER
        platform.stand("ac_unit", top.frame.moved(u, v, turn), size)
        if index % 2:
            yield
    yield
    corners = [(su, sv) for su in (-1, 1) for sv in (-1, 1)]
    names = ("water_tank", "chimney", "ac_unit")
    for index in draw.shuffled(range(len(corners)))[: draw.count(1, 3)]:
        name = draw.one_of(names)
        size = draw.size_of(name, 0.25)
        reach_u, reach_v = top.half_u - size[0] / 2, top.half_v - size[1] / 2
        if min(reach_u, reach_v) > 0.8:
            su, sv = corners[index]
            platform.stand(name, top.frame.moved(su * reach_u, sv * reach_v), size)
            yield


def _solar_array(top: RoofTop, span: tuple[float, float]) -> Iterator[None]:
    """Rows of panels that all lean towards the south, as far as the building allows."""
    depth, width, _ = _SOLAR_M
    # Rows run along the roof's longer side; of its two sides the more southern one is the front.
    turn = max((-QUARTER, QUARTER), key=lambda angle: -sin(top.frame.yaw + angle))
    low, high = span
    columns = max(1, int((high - low) / (width + 0.15)))
    # A passage lies between two rows.
    rows = max(1, int((2 * top.half_v - 1.2) / (depth + 0.7)))
    for row in range(min(rows, 4)):
        v = top.half_v - depth / 2 - row * (depth + 0.7)
        for column in range(min(columns, 4)):
            u = low + (column + 0.5) * (width + 0.15)
            top.platform.stand("solar_panel", top.frame.moved(u, v, turn), _SOLAR_M)
        yield


def _pad(top: RoofTop, side: int) -> Iterator[None]:
    """A landing pad towards one end."""
    length = top.platform.draw.between(2.6, 3.2)
    u = side * (top.half_u - length / 2 - 0.3)
    # The pad must leave a strip for people at both sides.
    if top.half_v > length / 2 + 0.2:
        pad = (length, length, 0.05)
        top.platform.stand("landing_pad", top.frame.moved(u, 0.0), pad, margin=0.3)
        yield


def lay_roof_deck(builder: Builder, draw: Draw, roof: Placed) -> Placed | None:
    """Lay boards over one end of a flat roof.

    Args:
        builder: Builder of the scene.
        draw: Randomness.
        roof: Flat roof.

    Returns:
        The deck, or None if the roof is too small.
    """
    top = roof_top(builder, draw, roof)
    length, width = min(6.0, 0.8 * top.half_u), min(5.5, 2 * top.half_v - 0.4)
    if min(length, width) < 3.0:
        return None
    u = (1 if draw.chance(0.5) else -1) * (top.half_u - length / 2)
    size = (round(length, 2), round(width, 2), _DECK_M)
    return top.platform.stand("deck", top.frame.moved(u, 0.0), size, margin=0.02)


def furnish_roof_deck(builder: Builder, draw: Draw, deck: Placed) -> Iterator[None]:
    """Furnish a roof deck: tables for the tenants, planters at the rim, bushes in the corners."""
    platform = Platform(builder, draw, deck, deck.top)
    x, y, _ = deck.size
    tables = [(0.0, -0.22 * y), (0.0, 0.22 * y)] if y > 4.5 else [(0.0, 0.0)]
    yield from interleave(dine(platform, deck.frame, tables, QUARTER), _greenery(platform, x, y))


def _greenery(platform: Platform, x: float, y: float) -> Iterator[None]:
    frame = platform.bearer.frame
    for sign in (-1, 1):
        size = (0.5, min(2.0, 0.4 * x), 0.95)
        platform.stand("planter", frame.moved(0.0, sign * (y / 2 - 0.3), QUARTER), size)
    yield
    for su in (-1, 1):
        size = (0.9, 0.9, platform.draw.between(0.9, 1.5))
        platform.stand("bush", frame.moved(su * (x / 2 - 0.5), y / 2 - 0.5), size)
    yield
