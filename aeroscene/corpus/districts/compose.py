"""Composition of a district: first its streets, then all blocks side by side, then one document."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from aeroscene.areas.landing import AreaLimits, derive_interaction_areas
from aeroscene.corpus.curation.builder import Builder, Placed
from aeroscene.corpus.curation.composition import fill
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.start import NoStartError, place_start, start_yaw
from aeroscene.corpus.curation.streets import Streets
from aeroscene.corpus.districts.blocks import (
    GrowingBlock,
    begin_block,
    begin_green,
    begin_homes,
    frame_of,
    has_tower_room,
    theme_of,
)
from aeroscene.corpus.districts.network import Block, Network, lay_network
from aeroscene.corpus.districts.request import DistrictError, DistrictRequest
from aeroscene.scene import AttributeValue, Scene, SceneObject
from aeroscene.scene.catalogue import BUILDINGS
from aeroscene.scene.origin import ALTITUDE_M, LATITUDE_DEG, LONGITUDE_DEG

_SEED_SPACE = 4045
"""Entropy of districts, beside the seed."""
HEADROOM_M = 12.0
"""Height of the flight volume above the highest object."""
_STRUCTURES_SHARE = 0.55
"""Share of the objects at which structures stop growing, so that details find their place."""
_AREAS_OF_BLOCK = AreaLimits(small=7, medium=4, large=3, perching=2)
"""Most areas for each block, on average."""
_TRIES = 40
"""Number of districts that are begun until one has about as many buildings as asked for."""
_HOUSES_SHARE = 0.1
"""Share by which the number of buildings may be missed."""


@dataclass(slots=True)
class _Growth:
    """A district whose structures stand."""

    network: Network
    blocks: list[GrowingBlock]

    @property
    def builders(self) -> list[Builder]:
        return [self.network.site.builder, *(block.builder for block in self.blocks)]

    @property
    def n_objects(self) -> int:
        return sum(len(builder.objects) for builder in self.builders)

    @property
    def n_houses(self) -> int:
        return sum(obj.category in BUILDINGS for b in self.builders for obj in b.objects)


def compose_district(request: DistrictRequest, scene_id: str | None = None) -> Scene:
    """Make the district of a request; equal on every call.

    Args:
        request: Size and contents of the district.
        scene_id: Name of the scene; by default it follows from the seed.

    Raises:
        DistrictError: If the ground has no room for what is asked for.
    """
    growth = _grow_structures(request)
    # The third number names the stream: 1 for details, 2 for homes.
    rng = np.random.default_rng((_SEED_SPACE, request.seed, 1))
    pad = _place_start(growth, request, rng)
    _grow_details(growth, request.wanted_objects, rng)
    layout = _joined(growth, request, pad, scene_id or f"aeroscene-{request.seed:04d}")
    limits = _limits(len(growth.blocks), request.n_areas)
    return replace(layout, interaction_areas=derive_interaction_areas(layout, limits=limits))


def _grow_structures(request: DistrictRequest) -> _Growth:
    """Grow structures of all blocks, with about as many buildings as asked for.

    Raises:
        DistrictError: If no try has them.
    """
    found: list[int] = []
    for attempt in range(_TRIES):
        growth = _begin(request)
        # Structures must leave a part of the number for furniture, trees and cars.
        most = _STRUCTURES_SHARE * request.wanted_objects
        walks = [block.walks.structures() for block in growth.blocks]
        places = [place.structures() for block in growth.blocks for place in block.places]
        # The lambda binds its values as defaults: a closure would see those of the next attempt.
        fill([*places, *walks], lambda growth=growth, most=most: growth.n_objects >= most)
        wanted = request.n_houses
        if wanted is None:
            return growth
        _grow_homes(growth, wanted, np.random.default_rng((_SEED_SPACE, request.seed, 2, attempt)))
        if abs(growth.n_houses - wanted) <= _HOUSES_SHARE * wanted:
            return growth
        found.append(growth.n_houses)
    raise DistrictError(
        f"houses is {request.n_houses} beside outline {request.sides_m[0]:g},"
        f"{request.sides_m[1]:g}; valid: another seed, a wider outline, or a number such as "
        f"{max(found)}"
    )


def _grow_homes(growth: _Growth, wanted: int, rng: np.random.Generator) -> None:
    """Place dwellings on one parcel after another until there are enough, and green on the rest."""
    parcels = [(block, parcel) for block in growth.blocks for parcel in block.site.parcels]
    for index in rng.permutation(len(parcels)).tolist():
        block, parcel = parcels[index]
        begin = begin_homes if growth.n_houses < wanted else begin_green
        for place in begin(block, parcel, rng):
            fill([place.structures()], lambda: False)


def _begin(request: DistrictRequest) -> _Growth:
    """Lay streets and grounds of a district; parcels stay open if houses are asked for."""
    plan, choice, content = np.random.default_rng((_SEED_SPACE, request.seed)).spawn(3)
    network = lay_network(request.sides_m, plan)
    half = (request.sides_m[0] / 2, request.sides_m[1] / 2)
    streams = content.spawn(len(network.blocks))
    tower = _tower_block(network.blocks) if request.n_storeys is not None else -1
    blocks: list[GrowingBlock] = []
    for number, (block, stream) in enumerate(zip(network.blocks, streams, strict=True)):
        theme = theme_of(block, half, choice) if request.n_houses is None else None
        n_storeys = request.n_storeys if number == tower else None
        blocks.append(begin_block(block, network.site, theme, stream, n_storeys))
    return _Growth(network, blocks)


def _tower_block(blocks: Sequence[Block]) -> int:
    """Number of the block for the tower: the one nearest to the middle that has room."""
    # Without a roomy block the nearest one is taken; the tower then may not fit.
    roomy = [n for n, block in enumerate(blocks) if has_tower_room(block)] or range(len(blocks))

    def away(number: int) -> float:
        frame = frame_of(blocks[number].area)
        return float(np.hypot(frame.x, frame.y))

    return min(roomy, key=away)


def _place_start(growth: _Growth, request: DistrictRequest, rng: np.random.Generator) -> Placed:
    """Put the home pad into a block at a corner, from which flights across are long.

    Raises:
        DistrictError: If no block has an open place.
    """
    half = (request.sides_m[0] / 2, request.sides_m[1] / 2)
    areas = [block.area for block in growth.network.blocks]
    away = [-float(np.hypot(frame_of(a).x, frame_of(a).y)) for a in areas]
    for number in np.argsort(away, kind="stable").tolist():
        block = growth.blocks[number]
        try:
            return place_start(block.builder, Draw(rng), half)
        except NoStartError:
            # The block has no open place; the next one inwards may have.
            continue
    raise DistrictError(
        f"outline {request.sides_m[0]:g},{request.sides_m[1]:g} has no open place to start from "
        f"with seed {request.seed}; valid: another seed"
    )


def _grow_details(growth: _Growth, n_objects: int, rng: np.random.Generator) -> None:
    """Grow objects on the streets and in the blocks, until there are enough."""
    site = growth.network.site
    traffic = [
        Streets(site.builder, Draw(stream), replace(site, roads=[road], junctions=[])).details()
        for road, stream in zip(site.roads, rng.spawn(len(site.roads)), strict=True)
    ]
    details: list[Iterator[None]] = [*traffic]
    for block in growth.blocks:
        details += [place.details() for place in block.places]
        details.append(block.walks.details())
    fill(details, lambda: growth.n_objects >= n_objects)


def _joined(growth: _Growth, request: DistrictRequest, pad: Placed, scene_id: str) -> Scene:
    """Join streets and blocks to one document."""
    objects: list[SceneObject] = []
    for builder in growth.builders:
        first = len(objects)
        is_block = builder is not growth.network.site.builder
        for obj in builder.objects:
            parent = obj.parent_id
            # Objects that stand free in a block become children of its plate, object 0.
            if parent is None and is_block and obj.id > 0:
                parent = 0
            parent_id = None if parent is None else first + parent
            objects.append(replace(obj, id=first + obj.id, scene_id=scene_id, parent_id=parent_id))
    half_x, half_y = request.sides_m[0] / 2, request.sides_m[1] / 2
    # Over the highest object, as in every outdoor scene.
    top = max(obj.bbox.p[2] + obj.bbox.s[2] / 2 for obj in objects)
    is_mixed = any(obj.domain == "indoor" for obj in objects)
    return Scene(
        scene_id=scene_id,
        domain="mixed" if is_mixed else "outdoor",
        seed=request.seed,
        extent_min_enu_m=(-half_x, -half_y, 0.0),
        extent_max_enu_m=(half_x, half_y, float(ceil(top + HEADROOM_M))),
        start_position_enu_m=(round(pad.frame.x, 4), round(pad.frame.y, 4), round(pad.top, 4)),
        start_yaw_rad=round(start_yaw(pad), 6),
        latitude_deg=LATITUDE_DEG,
        longitude_deg=LONGITUDE_DEG,
        altitude_m=ALTITUDE_M,
        objects=tuple(objects),
        theme="urban_block",
        wishes=_wishes(request),
    )


def _wishes(request: DistrictRequest) -> dict[str, AttributeValue]:
    asked: dict[str, AttributeValue | None] = {
        "outline": request.outline_m and "{:g},{:g}".format(*request.outline_m),
        "objects": request.n_objects,
        "houses": request.n_houses,
        "storeys": request.n_storeys,
        "areas": request.n_areas,
    }
    return {name: value for name, value in asked.items() if value is not None}


def _limits(n_blocks: int, n_areas: int | None) -> AreaLimits:
    """Most areas of each class that a district keeps."""
    usual = {name: n_blocks * getattr(_AREAS_OF_BLOCK, name) for name in _AREAS_OF_BLOCK.__slots__}
    if n_areas is None:
        return AreaLimits(**usual)
    n_landing = sum(usual[name] for name in ("small", "medium", "large"))
    # All classes shrink alike; perching areas are not counted as landing areas.
    share = min(1.0, n_areas / n_landing)
    # Rounded down, so that their sum does not exceed the wish.
    return AreaLimits(**{name: int(share * count) for name, count in usual.items()})
