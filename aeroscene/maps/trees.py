"""Trees: single ones, rows, and the trees of woods, with crowns that fit between each other."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from aeroscene.layouts.assembly import upright_box
from aeroscene.maps.document import Feature, Tags
from aeroscene.maps.site import Site
from aeroscene.maps.tags import length_m
from aeroscene.scene.catalogue import by_name

_ROW_M = 8.0
_WOOD_M = 7.0
"""Distance of trees in a row and in a wood if the map has no single ones."""
_MOST_OF_WOODS = 150
_CROWN_M = 5.0
_HEIGHT_M = 8.0
_LEAST_CROWN_M = 1.5
_GAP_M = 0.05
_WOODS = {("natural", "wood"), ("landuse", "forest"), ("landuse", "orchard")}
_NO_ROOM = "trees without room for their crowns"
_IN_WOODS = "trees of woods, which the map has as areas, are ours"
_FORMS = {"needleleaved": "conical", "broadleaved": "round"}


@dataclass(frozen=True, slots=True)
class _Tree:
    feature: Feature
    x: float
    y: float
    crown_m: float
    height_m: float


def is_tree(tags: Tags) -> bool:
    """Return true if a point is a tree, or a line a row of trees."""
    return tags.get("natural") in {"tree", "tree_row"}


def is_wood(tags: Tags) -> bool:
    """Return true if an area is full of trees."""
    return any(tags.get(key) == value for key, value in _WOODS)


def plant_trees(site: Site, features: Sequence[Feature], woods: Sequence[Feature]) -> None:
    """Add trees; each crown is as wide as walls and neighbouring trees allow.

    Args:
        site: Scene in the making.
        features: Trees as points, and rows as lines.
        woods: Areas of woods.
    """
    trees = [tree for feature in features for tree in _trees(feature)]
    grown = list(_of_woods(site, woods, trees))
    if grown:
        site.notes[_IN_WOODS] += len(grown)
    trees = _distinct([*trees, *grown])
    if not trees:
        return
    places = np.array([(tree.x, tree.y) for tree in trees])
    index = shapely.STRtree([shapely.Point(*place) for place in places.tolist()])
    for number, tree in enumerate(trees):
        room_m = _room_m(site, tree, index, number)
        _plant(site, tree, min(tree.crown_m, room_m))


def _trees(feature: Feature) -> Iterator[_Tree]:
    low, high = by_name()["tree"].height_m
    height_m = length_m(feature.tags, "height", 1.0, 60.0) or _HEIGHT_M
    height_m = min(max(height_m, low), high)
    # A stated crown counts; without one, it is in proportion to the height.
    crown_m = length_m(feature.tags, "diameter_crown", 0.5, 30.0) or min(_CROWN_M, 0.7 * height_m)
    crown_m = min(crown_m, by_name()["tree"].length_m[1])
    for part in shapely.get_parts(feature.geometry):
        if part.geom_type == "Point":
            yield _Tree(feature, part.x, part.y, crown_m, height_m)
        elif part.geom_type == "LineString":
            count = max(2, round(part.length / _ROW_M) + 1)
            for k in range(count):
                at = part.interpolate(k / (count - 1), normalized=True)
                yield _Tree(feature, at.x, at.y, crown_m, height_m)


def _of_woods(site: Site, woods: Sequence[Feature], trees: Sequence[_Tree]) -> Iterator[_Tree]:
    """Trees on a jittered grid in woods in which the map has no single ones."""
    # The seed follows from the map, so that equal maps give equal scenes.
    rng = np.random.default_rng(len(woods))
    left = _MOST_OF_WOODS
    for wood in woods:
        # Trunks keep off the wood's border.
        shape = shapely.buffer(shapely.intersection(wood.geometry, site.place.area), -1.5)
        if shape.is_empty or any(shape.covers(shapely.Point(t.x, t.y)) for t in trees):
            continue
        x0, y0, x1, y1 = shape.bounds
        for x in np.arange(x0, x1, _WOOD_M):
            for y in np.arange(y0, y1, _WOOD_M):
                dx, dy, grow = rng.uniform(-1.5, 1.5), rng.uniform(-1.5, 1.5), rng.uniform(0.7, 1.2)
                if left and shape.covers(shapely.Point(x + dx, y + dy)):
                    left -= 1
                    height_m = round(_HEIGHT_M * grow, 2)
                    yield _Tree(wood, float(x + dx), float(y + dy), 4.0 * grow, height_m)


def _distinct(trees: Sequence[_Tree]) -> list[_Tree]:
    """Trees without duplicates, which maps have in a row and as single ones."""
    kept: dict[tuple[int, int], _Tree] = {}
    for tree in trees:
        # A grid of 1.5 m: two trees in one cell are one.
        kept.setdefault((round(tree.x / 1.5), round(tree.y / 1.5)), tree)
    return list(kept.values())


def _room_m(site: Site, tree: _Tree, index: shapely.STRtree, number: int) -> float:
    """Diameter of the widest crown between walls, bounds, and half the way to other trees, m."""
    point = shapely.Point(tree.x, tree.y)
    reach = point.buffer(tree.crown_m)
    walls = site.buildings.pieces_near(reach)
    gaps = [float(shapely.distance(wall, point)) for wall in walls]
    if not site.place.area.covers(point):
        return 0.0
    gaps.append(site.place.area.exterior.distance(point))
    others = [k for k in index.query(reach) if k != number]
    gaps += [
        _gap_of_boxes(tree, shapely.get_coordinates(index.geometries[k])[0]) / 2 for k in others
    ]
    # The box of a crown along the axes extends further in its corners than along its sides.
    return 2 * (min([*gaps, math.inf]) - _GAP_M)


def _gap_of_boxes(tree: _Tree, place: np.ndarray) -> float:
    return float(max(abs(tree.x - place[0]), abs(tree.y - place[1])))


def _plant(site: Site, tree: _Tree, crown_m: float) -> None:
    point = shapely.Point(tree.x, tree.y)
    on_street = any(shapely.intersects(s, point) for s in site.carriageways.pieces_near(point))
    if crown_m < _LEAST_CROWN_M or on_street:
        site.dropped["in the middle of a street" if on_street else _NO_ROOM] += 1
        return
    ground = site.cover_at(tree.x, tree.y)
    crown_m = round(crown_m, 2)
    box = upright_box((tree.x, tree.y), 0.0, (crown_m, crown_m, tree.height_m), ground.top_m)
    form = _FORMS.get(tree.feature.tags.get("leaf_type", ""))
    site.add("tree", box, tree.feature, ground.object_id, {} if form is None else {"form": form})
