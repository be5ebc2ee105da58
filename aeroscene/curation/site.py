"""The ground plan of a scene: streets, the blocks between them, and parcels to build on."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from aeroscene.curation.builder import Builder, Placed
from aeroscene.curation.frame import Frame
from aeroscene.scene import AttributeValue

ROAD_M = 0.04
SIDEWALK_M = 0.15
"""Heights of the surfaces above the ground."""

_BRIDGE_CHANCE = {"cross": 0.1, "tee": 0.2, "through": 0.5}

Side = str
"""south, east, north or west."""
_SIDES: tuple[Side, ...] = ("south", "east", "north", "west")


@dataclass(frozen=True, slots=True)
class Rectangle:
    """A rectangle along the axes of the site, m."""

    x0: float
    y0: float
    x1: float
    y1: float

    def side_frame(self, side: Side) -> tuple[Frame, float, float]:
        """Frame in the middle of a side with v inwards, the side's length, and the depth."""
        x, y = (self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2
        width, depth = self.x1 - self.x0, self.y1 - self.y0
        return {
            "south": (Frame(x, self.y0, 0.0), width, depth),
            "east": (Frame(self.x1, y, math.pi / 2), depth, width),
            "north": (Frame(x, self.y1, math.pi), width, depth),
            "west": (Frame(self.x0, y, -math.pi / 2), depth, width),
        }[side]

    def without(self, side: Side, strip: float) -> Rectangle:
        """What is left when a strip along one side is taken away."""
        x0, y0, x1, y1 = self.x0, self.y0, self.x1, self.y1
        return {
            "south": Rectangle(x0, y0 + strip, x1, y1),
            "east": Rectangle(x0, y0, x1 - strip, y1),
            "north": Rectangle(x0, y0, x1, y1 - strip),
            "west": Rectangle(x0 + strip, y0, x1, y1),
        }[side]


@dataclass(frozen=True, slots=True)
class Block:
    """Ground between streets and the border of the site."""

    area: Rectangle
    street_sides: tuple[Side, ...]


@dataclass(frozen=True, slots=True)
class Parcel:
    """Ground for one place: u along the street, v from the street (0) to the back (depth)."""

    frame: Frame
    width: float
    depth: float
    level: float = 0.0
    """Height of the ground that the place starts from."""

    def middle(self) -> Frame:
        """The same frame moved to the middle of the parcel."""
        return self.frame.moved(0.0, self.depth / 2)


@dataclass(slots=True)
class Site:
    """Streets and parcels of a scene."""

    half_x: float
    half_y: float
    roads: list[Placed] = field(default_factory=list)
    sidewalks: list[Placed] = field(default_factory=list)
    """Frames lie in the strip's middle with v leading away from the curb."""
    parcels: list[Parcel] = field(default_factory=list)
    crossings: list[Frame] = field(default_factory=list)


def lay_out_site(builder: Builder, rng: np.random.Generator) -> Site:
    """Draw streets for a scene of 60 to 84 m a side and cut the rest into parcels."""
    half_x, half_y = rng.uniform(31, 40, 2).round(1).tolist()
    site = Site(half_x, half_y)
    road = float(rng.choice([6.5, 7.0, 8.0]))
    plan = str(rng.choice(["cross", "tee", "through"], p=[0.25, 0.35, 0.4]))
    y = float(rng.uniform(-0.15, 0.15)) * half_y
    x = float(rng.uniform(-0.18, 0.18)) * half_x
    turn = plan == "through" and bool(rng.integers(2))
    blocks = _street_plan(builder, site, plan, road, (x, y), turned=turn)
    walk = round(float(rng.uniform(2.0, 2.7)), 2)
    for block in blocks:
        _pave_block(builder, site, block, walk, rng)
    if rng.random() < _BRIDGE_CHANCE[plan]:
        _bridge_road(builder, site, walk, rng)
    return site


def _bridge_road(builder: Builder, site: Site, walk: float, rng: np.random.Generator) -> None:
    """A footbridge over the longest road, from sidewalk to sidewalk, away from the middle."""
    road = max(site.roads, key=lambda road: road.size[0])
    u = float(rng.choice([-1, 1])) * float(rng.uniform(0.45, 0.7)) * road.size[0] / 2
    size = (road.size[1] + 2 * min(1.2, walk - 0.6), 2.4, 6.2)
    builder.place("bridge", road.frame, u, 0, size, base=SIDEWALK_M, turn=math.pi / 2, margin=0.3)


def _street_plan(
    builder: Builder, site: Site, plan: str, road: float, at: tuple[float, float], *, turned: bool
) -> list[Block]:
    """Roads of a plan; returns the blocks that they leave."""
    hx, hy, half = site.half_x, site.half_y, road / 2
    x, y = at
    if turned:
        _add_road(builder, site, Frame(x, 0, math.pi / 2), 2 * hy, road)
        return [
            Block(Rectangle(-hx, -hy, x - half, hy), ("east",)),
            Block(Rectangle(x + half, -hy, hx, hy), ("west",)),
        ]
    _add_road(builder, site, Frame(0, y, 0), 2 * hx, road)
    south, north = y - half, y + half
    if plan == "through":
        return [
            Block(Rectangle(-hx, -hy, hx, south), ("north",)),
            Block(Rectangle(-hx, north, hx, hy), ("south",)),
        ]
    site.crossings.append(Frame(x, y, 0))
    _add_road(builder, site, Frame(x, (north + hy) / 2, math.pi / 2), hy - north, road, -1)
    blocks = [
        Block(Rectangle(-hx, north, x - half, hy), ("south", "east")),
        Block(Rectangle(x + half, north, hx, hy), ("south", "west")),
    ]
    if plan == "tee":
        return [*blocks, Block(Rectangle(-hx, -hy, hx, south), ("north",))]
    _add_road(builder, site, Frame(x, (south - hy) / 2, math.pi / 2), hy + south, road, 1)
    return [
        *blocks,
        Block(Rectangle(-hx, -hy, x - half, south), ("north", "east")),
        Block(Rectangle(x + half, -hy, hx, south), ("north", "west")),
    ]


def _add_road(
    builder: Builder, site: Site, frame: Frame, length: float, width: float, zebra_end: int = 0
) -> None:
    """A carriageway; `zebra_end` says at which end along x people cross it, 0 for neither."""
    size = (length, width, ROAD_M)
    attributes: dict[str, AttributeValue] = {"zebra_end": zebra_end}
    road = builder.place("road", frame, 0, 0, size, base=0.0, attributes=attributes)
    if road:
        site.roads.append(road)


def _pave_block(
    builder: Builder, site: Site, block: Block, walk: float, rng: np.random.Generator
) -> None:
    """Sidewalks along the streets; the rest becomes one parcel, or two where it is long."""
    rest = block.area
    for side in block.street_sides:
        frame, length, _ = rest.side_frame(side)
        strip = builder.place("sidewalk", frame, 0, walk / 2, (length, walk, SIDEWALK_M), base=0.0)
        if strip:
            site.sidewalks.append(strip)
        rest = rest.without(side, walk)
    front = str(rng.choice(list(block.street_sides)))
    frame, width, depth = rest.side_frame(front)
    if width < 42:
        site.parcels.append(Parcel(frame, width, depth))
        return
    cut = float(rng.uniform(-0.1, 0.1)) * width
    for low, high in ((-width / 2, cut), (cut, width / 2)):
        site.parcels.append(Parcel(frame.moved((low + high) / 2, 0), high - low, depth))
