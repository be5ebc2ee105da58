"""Fences, walls and hedges, straight piece by straight piece."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import shapely
from shapely.geometry.base import BaseGeometry

from aeroscene.layouts.assembly import upright_box
from aeroscene.maps.document import Feature, Tags
from aeroscene.maps.site import Site
from aeroscene.maps.tags import length_m

_FORMS: Mapping[str, tuple[str, float, float]] = {
    "fence": ("rails", 0.1, 1.4),
    "wall": ("wall", 0.3, 1.6),
    "hedge": ("hedge", 0.6, 1.4),
    "railing": ("rails", 0.1, 1.1),
    "guard_rail": ("rails", 0.15, 0.8),
    "handrail": ("rails", 0.1, 1.0),
    "retaining_wall": ("wall", 0.3, 1.0),
    "city_wall": ("wall", 0.8, 4.0),
    "yes": ("rails", 0.1, 1.2),
}
"""Form, thickness and height of each kind of barrier."""
_FENCE_FORMS = {"wood": "boards", "wooden": "boards", "panel": "boards", "chain_link": "mesh",
                "wire": "mesh", "barbed_wire": "mesh", "wire_mesh": "mesh"}
_GATE_HALF_M = 1.3
_LEAST_M = 1.0
_LONGEST_M = 40.0
_CLEAR_M = 0.12
"""Gap between a barrier and the walls, streets and paths that it meets."""
_SHORT = f"is a piece of fence shorter than {_LEAST_M:g} m"


def is_barrier(tags: Tags) -> bool:
    """Whether a line is a fence, a wall or a hedge."""
    return tags.get("barrier") in _FORMS


def raise_barriers(
    site: Site, features: Sequence[Feature], ways: Sequence[BaseGeometry], gates: Sequence[Feature]
) -> None:
    """Add the barriers of a map; gates, streets, paths and buildings open them.

    Args:
        site: The site.
        features: Barriers.
        ways: Ground that people and cars pass along.
        gates: Points of gates and other entrances.
    """
    holes = [shapely.buffer(gate.geometry, _GATE_HALF_M, quad_segs=2) for gate in gates]
    walls = [shapely.buffer(shape, _CLEAR_M) for shape in ways]
    opening = shapely.union_all([*holes, *walls])
    for feature in features:
        for line in _lines(site, feature, opening):
            _raise(site, feature, line)


def _lines(site: Site, feature: Feature, opening: BaseGeometry) -> Iterator[shapely.LineString]:
    """The parts of a barrier that stand free, in the bounds, without corners that hardly turn."""
    shape = feature.geometry
    if shapely.get_dimensions(shape) == 2:
        shape = shapely.boundary(shape)
    inside = shapely.buffer(site.place.area, -0.5, join_style="mitre")
    line = shapely.intersection(shapely.simplify(shape, 0.15), inside)
    line = shapely.difference(line, opening)
    near = [shapely.buffer(s, _CLEAR_M) for s in site.buildings.pieces_near(line)]
    line = shapely.difference(line, shapely.union_all(near)) if near else line
    for part in shapely.get_parts(line):
        if isinstance(part, shapely.LineString):
            yield part


def _raise(site: Site, feature: Feature, line: shapely.LineString) -> None:
    tags = feature.tags
    form, thick_m, usual_m = _FORMS[tags["barrier"]]
    if tags["barrier"] == "fence":
        form = _FENCE_FORMS.get(tags.get("fence_type", tags.get("material", "")), form)
    height_m = length_m(tags, "height", 0.3, 12.0) or usual_m
    thick_m = length_m(tags, "width", 0.05, 2.0) or thick_m
    for (ax, ay), (bx, by) in pairwise(line.coords):
        whole = math.hypot(bx - ax, by - ay)
        n = max(1, math.ceil(whole / _LONGEST_M))
        length = whole / n - thick_m / 2
        if length < _LEAST_M:
            site.dropped[_SHORT] += 1
            continue
        heading = math.atan2(by - ay, bx - ax)
        for k in range(n):
            at = (k + 0.5) / n
            x, y = ax + at * (bx - ax), ay + at * (by - ay)
            ground = site.cover_at(x, y)
            size = (thick_m, length, height_m)
            box = upright_box((x, y), heading - math.pi / 2, size, ground.top_m)
            site.add("fence", box, feature, ground.object_id, {"form": form})
