"""A block of a district: sidewalks along its streets, and places on the parcels within.

Each block is a scene of its own while it grows, with its own randomness and its own objects. The
test for overlap compares an object with all others of its builder, so that a district of a hundred
blocks takes a hundred times as long as one block, and not ten thousand times.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.composers.mixed import THEMES as MIXED
from aeroscene.corpus.curation.composers.outdoor import THEMES as OUTDOOR
from aeroscene.corpus.curation.composers.themes import Theme, choose_places, draw_one
from aeroscene.corpus.curation.composition import Place
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.parcels import Land, Parcel, Rectangle
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.site import Site
from aeroscene.corpus.curation.streets import Streets
from aeroscene.corpus.districts.network import Block
from aeroscene.corpus.districts.tower import LEAST_M, FurnishedTower

PLATE_M, _WALK_M = 0.1, 0.05
"""Height of a block above the ground, and of its sidewalks above that."""
_TWO_ROWS_M = 30.0
"""Depth from which a block has parcels on two sides, back to back."""
_ALWAYS_CHANCE = 0.3
"""Probability that a block has the places that its theme always has, such as a square."""

_ZONES: Sequence[tuple[float, Mapping[str, float]]] = (
    (0.4, {"urban_block": 0.5, "old_town": 0.25, "+urban_block": 0.25}),
    (
        0.72,
        {"residential_street": 0.3, "urban_block": 0.2, "+residential_street": 0.3, "park": 0.1}
        | {"+campus": 0.1},
    ),
    (
        9.0,
        {"residential_street": 0.35, "village": 0.15, "+residential_street": 0.2, "park": 0.12}
        | {"industrial_yard": 0.09, "retail_park": 0.09},
    ),
)
"""Themes of blocks and their weights, by the distance from the middle of the district as a share of
that of a corner. Those with a plus have buildings to enter."""
HOMES = Theme(weight=1.0, plans={}, others={"row_houses": 0.65, "houses": 0.35})
"""Theme of the parcels of a district that is asked for houses."""
GREEN = Theme(weight=1.0, plans={}, others={"park": 0.7, "allotments": 0.3})
"""Theme of parcels without buildings."""


@dataclass(slots=True)
class GrowingBlock:
    """A block that is being filled."""

    builder: Builder
    site: Site
    places: list[Place]
    walks: Streets
    """Street furniture on its sidewalks."""


def theme_of(block: Block, half_sides_m: tuple[float, float], rng: np.random.Generator) -> Theme:
    """Draw the theme of a block by its distance from the middle of the district.

    Args:
        block: Block.
        half_sides_m: Half sides of the district, along east and north.
        rng: Draws the theme, and whether its certain places are certain here.
    """
    area = block.area
    x, y = (area.x0 + area.x1) / 2, (area.y0 + area.y1) / 2
    # Divided by the root of two, so that a corner of the district has share 1.
    share = float(np.hypot(x / half_sides_m[0], y / half_sides_m[1]) / np.sqrt(2.0))
    name = draw_one(rng, next(weights for limit, weights in _ZONES if share <= limit))
    theme = MIXED[name[1:]] if name.startswith("+") else OUTDOOR[name]
    return theme if rng.random() < _ALWAYS_CHANCE else replace(theme, always=())


def begin_homes(block: GrowingBlock, parcel: Parcel, rng: np.random.Generator) -> list[Place]:
    """Begin dwellings on a parcel, and add them to the block's places.

    Args:
        block: Block of the parcel.
        parcel: Open parcel of the block.
        rng: Draws everything of the parcel.

    Returns:
        The places, none of whose objects stand yet.
    """
    return _begin_alone(block, parcel, HOMES, rng)


def begin_green(block: GrowingBlock, parcel: Parcel, rng: np.random.Generator) -> list[Place]:
    """Begin a place without buildings on a parcel; see `begin_homes`."""
    return _begin_alone(block, parcel, GREEN, rng)


def _begin_alone(
    block: GrowingBlock, parcel: Parcel, theme: Theme, rng: np.random.Generator
) -> list[Place]:
    site = replace(block.site, parcels=[parcel])
    places = choose_places(block.builder, site, theme, rng)
    block.places += places
    return places


def begin_block(
    block: Block,
    network: Site,
    theme: Theme | None,
    rng: np.random.Generator,
    n_storeys: int | None,
) -> GrowingBlock:
    """Lay a block's ground and sidewalks and choose its places; nothing stands yet.

    Args:
        block: Ground of the block.
        network: Site of the streets around it.
        theme: Theme that chooses its places; None leaves its parcels open.
        rng: Draws everything of the block.
        n_storeys: Storeys of a furnished tower on its widest parcel; None for no tower.
    """
    # Streams of their own, so that one part may draw more without changing the others.
    cut, choice, tower, streets = rng.spawn(4)
    builder = Builder("block")
    area = block.area
    builder.enclose((area.x0, area.y0), (area.x1, area.y1))
    site = replace(
        network, builder=builder, roads=[], sidewalks=[], verges=[], parcels=[], junctions=[]
    )
    # The plate is object 0, to which `compose` attaches all objects that stand free in the block.
    frame, width, depth = area.side_frame("south")
    look = {"form": "terrace", "finish": "paving", "wall": "concrete", "part": "block"}
    size = (width, depth, PLATE_M)
    plate = builder.place("terrain", frame.moved(0, depth / 2), size, look=look)
    land = Land(PLATE_M, plate)
    _part(site, _pave(site, block, land), land, cut)
    places: list[Place] = []
    if n_storeys is not None:
        parcel = max(site.parcels, key=_tower_room)
        site.parcels.remove(parcel)
        places.append(FurnishedTower(Ground(builder, Draw(tower), parcel), n_storeys))
    if theme is not None:
        places += choose_places(builder, site, theme, choice)
    # Footbridges would cross carriageways, which are not objects of the block.
    walks = Streets(builder, Draw(streets), site, bridge_chance=0.0)
    return GrowingBlock(builder, site, places, walks)


def has_tower_room(block: Block) -> bool:
    """Return true if a block is wide enough for a tower; the least parcel is half of it."""
    area = block.area
    return min(area.x1 - area.x0, area.y1 - area.y0) > 2 * LEAST_M[1]


def _tower_room(parcel: Parcel) -> float:
    return min(parcel.width - LEAST_M[0], parcel.depth - LEAST_M[1])


def _pave(site: Site, block: Block, land: Land) -> Rectangle:
    """Lay sidewalks along the streets, and return the rest of the ground."""
    rest = block.area
    for side in block.street_sides:
        frame, length, _ = rest.side_frame(side)
        site.lay_sidewalk(frame, length, land=land, height=_WALK_M)
        rest = rest.without(side, site.walk_m)
    return rest


def _part(site: Site, rest: Rectangle, land: Land, rng: np.random.Generator) -> None:
    """Cut the ground into parcels, in one row or in two that lie back to back."""
    width, depth = rest.x1 - rest.x0, rest.y1 - rest.y0
    is_along_x = width >= depth
    front, back = ("south", "north") if is_along_x else ("west", "east")
    across = min(width, depth)
    if across < _TWO_ROWS_M:
        site.part(rest, front, rng, land=land)
        return
    # Unequal rows, because real blocks are; centimetres, because files have no more digits.
    first = round(across * float(rng.uniform(0.44, 0.56)), 2)
    site.part(rest.without(back, across - first), front, rng, land=land)
    site.part(rest.without(front, first), back, rng, land=land)


def frame_of(area: Rectangle) -> Frame:
    """Frame in the middle of some ground."""
    return Frame((area.x0 + area.x1) / 2, (area.y0 + area.y1) / 2, 0.0)
