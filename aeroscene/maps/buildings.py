"""Buildings: their bodies and roofs, from outlines, parts, heights and storeys.

Maps describe a building as a whole, by parts of different heights, or both; outlines of neighbours
may overlap by mistake. Each body becomes a block with one roof. Blocks are stacked on the blocks
that carry them, and overlapping space goes to the higher one.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from zlib import crc32

import shapely

from aeroscene.layouts.mapping import building_kind
from aeroscene.maps import building_facts as facts
from aeroscene.maps.claims import areal_parts, on_grid, opened
from aeroscene.maps.document import Feature
from aeroscene.maps.site import Attributes, Framed, Site, framed, long_axis_rad
from aeroscene.maps.tags import heading_rad, tiles, wall_colour
from aeroscene.solids.shapes.materials import WALL_COLOURS
from aeroscene.solids.shapes.outline_roofs import can_be_pitched

_LEAST_M2 = 4.0
_LEAST_HEIGHT_M = 2.0
_FLAT_ROOF_M = 0.25
_PARTS_COVER = 0.9
"""Share of an outline from which its parts describe the whole building."""
_BEARS_M = 0.6
"""Height by which a part may begin above or below the block that carries it."""
_ENOUGH_KNOWN = 5
"""Number of buildings of known height from which the others take their median."""
_HIDDEN = "within other buildings"
_TINY = f"smaller than {_LEAST_M2:g} m2 within the bounds"


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """One body with one roof."""

    feature: Feature
    polygon: shapely.Polygon
    bottom_m: float
    """Height of its foot above the ground, m."""
    eaves_m: float
    """Height of the upper ends of its walls above the ground, m."""
    top_m: float
    """Height of its roof's highest point above the ground, m."""
    roof: facts.RoofForm
    has_known_height: bool


def raise_buildings(site: Site, features: Sequence[Feature]) -> None:
    """Add every building of a map; their footprints are taken from the ground.

    Args:
        site: Scene in the making.
        features: Buildings and parts of buildings.
    """
    blocks = _with_guesses(site, list(_blocks(site, features)))
    blocks = [_on_its_bearer(site, block, blocks) for block in blocks]
    numbers: list[tuple[Block, int]] = []
    kept = _apart(site, blocks)
    # From the lowest, because parents have to exist before their children.
    for block in sorted(kept, key=lambda b: b.bottom_m):
        bearer = _bearer(block, [b for b, _ in numbers])
        parent = None if bearer is None else next(n for b, n in numbers if b is bearer)
        is_built_on = any(_bearer(other, [block]) for other in kept if other.bottom_m > 0)
        numbers.append((block, _raise(site, block, parent, is_built_on=is_built_on)))


def _blocks(site: Site, features: Sequence[Feature]) -> Iterable[Block]:
    """A block for each part, and for each building the rest that its parts leave."""
    parts = [f for f in features if facts.is_part(f.tags)]
    tree = shapely.STRtree([part.geometry for part in parts])
    for feature in (f for f in features if not facts.is_part(f.tags)):
        rows = tree.query(feature.geometry, predicate="intersects")
        inside = [
            parts[k].geometry
            for k in rows
            if shapely.covers(feature.geometry, parts[k].geometry.representative_point())
        ]
        shape = feature.geometry
        if inside:
            # The outline alone would repeat its parts.
            united = shapely.union_all(inside)
            if shapely.intersection(united, shape).area >= _PARTS_COVER * shape.area:
                continue
            shape = opened(shapely.difference(shape, united), 0.5)
        yield from _cut_blocks(site, feature, shape)
    for part in parts:
        yield from _cut_blocks(site, part, part.geometry)


def _cut_blocks(
    site: Site, feature: Feature, shape: shapely.geometry.base.BaseGeometry
) -> Iterable[Block]:
    polygons = list(areal_parts(on_grid(shape), _LEAST_M2))
    if not polygons:
        site.dropped[_TINY] += 1
    for polygon in polygons:
        height = facts.heights(feature.tags, polygon)
        yield Block(feature=feature, polygon=polygon, **height)


def _with_guesses(site: Site, blocks: list[Block]) -> list[Block]:
    """Give buildings of unknown height the median of the known ones of their kind."""
    # Only bodies on the ground: parts begin at heights of their own.
    known = [b.eaves_m for b in blocks if b.has_known_height and b.bottom_m == 0]
    n_guessed = sum(not block.has_known_height for block in blocks)
    if n_guessed:
        site.notes["buildings have no height or storeys in the map; theirs is assumed"] += n_guessed
    if len(known) < _ENOUGH_KNOWN:
        return blocks
    usual_m = round(statistics.median(known), 1)
    return [
        block
        if block.has_known_height or not facts.is_ordinary(block.feature.tags)
        else replace(block, eaves_m=usual_m, top_m=usual_m + block.top_m - block.eaves_m)
        for block in blocks
    ]


def _on_its_bearer(site: Site, block: Block, blocks: Sequence[Block]) -> Block:
    """Put a part that begins above the ground on its bearer; without one, down to the ground."""
    if block.bottom_m <= 0:
        return block
    middle = block.polygon.representative_point()
    below = [
        other.top_m
        for other in blocks
        if other is not block
        and abs(other.top_m - block.bottom_m) <= _BEARS_M
        and other.polygon.covers(middle)
        and other.polygon.covers(block.polygon.centroid)
    ]
    if not below:
        site.notes["parts of buildings with nothing below them reach down to the ground"] += 1
        return replace(block, bottom_m=0.0)
    return replace(block, bottom_m=max(below))


def _apart(site: Site, blocks: Sequence[Block]) -> list[Block]:
    """Separate blocks: if two share space, the higher one keeps it."""
    kept: list[Block] = []
    # Of equally high blocks the smaller one comes first, or the larger would swallow it.
    for block in sorted(blocks, key=lambda b: (-b.top_m, b.polygon.area)):
        rivals = [
            other.polygon
            for other in kept
            if min(other.top_m, block.top_m) > max(other.bottom_m, block.bottom_m)
            and other.polygon.intersects(block.polygon)
        ]
        if not rivals:
            kept.append(block)
            continue
        left = shapely.difference(block.polygon, shapely.union_all(rivals), grid_size=0.01)
        if left.area < 0.999 * block.polygon.area:
            left = opened(left)
        parts = list(areal_parts(site.within(left), _LEAST_M2))
        if not parts:
            site.dropped[_HIDDEN] += 1
        kept += [replace(block, polygon=part) for part in parts]
    return kept


def _bearer(block: Block, others: Sequence[Block]) -> Block | None:
    if block.bottom_m <= 0:
        return None
    middle = block.polygon.centroid
    return next(
        (
            other
            for other in others
            if abs(other.top_m - block.bottom_m) < 0.01 and other.polygon.covers(middle)
        ),
        None,
    )


def _raise(site: Site, block: Block, parent: int | None, *, is_built_on: bool) -> int:
    """Add the body and the roof of a block; returns the body's number."""
    base_m = _ground_m(site)
    # Only bodies on the ground take it; streets may pass below others.
    if block.bottom_m <= 0:
        site.buildings.add(block.polygon)
        site.ground.add(block.polygon)
    category = _category(block)
    # A block that carries another has no roof of its own, but a flat top.
    eaves_m = block.top_m if is_built_on else block.eaves_m
    form, rise_m = ("flat", 0.0) if is_built_on else (block.roof, block.top_m - block.eaves_m)
    frame = framed(block.polygon, 0.0, 1.0)
    if form not in {"flat", "shed"} and not can_be_pitched(frame.outline):
        site.notes[f"{form} roofs over irregular outlines are flat"] += 1
        form, eaves_m = "flat", block.top_m
    has_roof = category != "canopy" and not is_built_on
    if form == "flat":
        rise_m = _FLAT_ROOF_M if has_roof else 0.0
        eaves_m -= rise_m
    # Even under a high roof, walls of a metre remain.
    eaves_m = max(eaves_m, block.bottom_m + _LEAST_HEIGHT_M * 0.5)
    body = framed(block.polygon, base_m + block.bottom_m, base_m + eaves_m)
    number = site.add(category, body.box, block.feature, parent, _body_attributes(block, body))
    if has_roof:
        roof = framed(
            block.polygon, base_m + eaves_m, base_m + eaves_m + rise_m, _ridge_rad(block, form)
        )
        attributes = {"form": form, **roof.attributes, **_roof_attributes(block, form)}
        site.add("roof", roof.box, None, number, attributes)
    return number


def _ground_m(site: Site) -> float:
    return site.covers[0].top_m


def _category(block: Block) -> str:
    named = facts.category(block.feature.tags)
    if named is not None:
        return named
    frame = framed(block.polygon, 0.0, max(block.top_m, 1.0))
    return building_kind(frame.box.s)


def _body_attributes(block: Block, body: Framed) -> Attributes:
    storeys = max(1, round((block.eaves_m - block.bottom_m) / facts.STOREY_M))
    return {"storeys": storeys, "colour": _colour(block), **body.attributes}


def _colour(block: Block) -> str:
    """Colour of the walls: the map's, or one that follows from the building's id."""
    # Brick is twice as likely as each colour.
    drawn = (*WALL_COLOURS, "brick", "brick")
    ours = drawn[crc32(block.feature.source_id.encode()) % len(drawn)]
    return wall_colour(block.feature.tags) or ours


def _roof_attributes(block: Block, form: str) -> Attributes:
    found: Attributes = {"colour": _colour(block)}
    if form == "flat":
        covers = ("roofing", "roofing", "gravel", "concrete")
        found["cover"] = covers[crc32(b"cover" + block.feature.source_id.encode()) % len(covers)]
    elif named := tiles(block.feature.tags):
        found["tiles"] = named
    return found


def _ridge_rad(block: Block, form: str) -> float | None:
    """Heading of a roof's x axis: along the ridge of a gable, uphill on a shed."""
    tags = block.feature.tags
    downhill = heading_rad(tags, "roof:direction")
    if form == "shed":
        if downhill is not None:
            return downhill + math.pi
        return long_axis_rad(block.polygon) + math.pi / 2
    if form != "gable":
        return None
    if downhill is not None:
        # Ridges follow the walls, whereas directions in maps are rounded to whole degrees.
        axis = long_axis_rad(block.polygon)
        turns = [axis, axis + math.pi / 2]
        return min(turns, key=lambda a: abs(math.cos(a - downhill)))
    across = tags.get("roof:orientation") == "across"
    return long_axis_rad(block.polygon) + (math.pi / 2 if across else 0.0)
