"""Fences, walls and hedges, straight piece by straight piece."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import shapely
from shapely.geometry.base import BaseGeometry

from aeroscene.layouts.assembly import upright_box
from aeroscene.maps.document import Feature, Tags
from aeroscene.maps.site import Cover, Site
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
"""Form, thickness (m) and height (m) of each kind of barrier."""
_FENCE_FORMS = {
    "wood": "boards",
    "wooden": "boards",
    "panel": "boards",
    "chain_link": "mesh",
    "wire": "mesh",
    "barbed_wire": "mesh",
    "wire_mesh": "mesh",
}
_SAMPLE_M = 0.5
"""Distance between the points at which a fence finds the ground below it."""
_GATE_HALF_M = 1.3
_LEAST_M = 1.0
_LONGEST_M = 40.0
_CLEAR_M = 0.12
"""Gap between a barrier and the walls, streets and paths that it meets."""
_SHORT = f"pieces of fence shorter than {_LEAST_M:g} m"

_Point2 = tuple[float, float]


def is_barrier(tags: Tags) -> bool:
    """Return true if tags describe a fence, a wall or a hedge."""
    return tags.get("barrier") in _FORMS


def raise_barriers(
    site: Site, features: Sequence[Feature], ways: Sequence[BaseGeometry], gates: Sequence[Feature]
) -> None:
    """Add the barriers of a map; gates, streets, paths and buildings interrupt them.

    Args:
        site: Scene in the making.
        features: Barriers.
        ways: Ground on which people and cars pass.
        gates: Points of gates and other entrances.
    """
    holes = [shapely.buffer(gate.geometry, _GATE_HALF_M, quad_segs=2) for gate in gates]
    walls = [shapely.buffer(shape, _CLEAR_M) for shape in ways]
    opening = shapely.union_all([*holes, *walls])
    for feature in features:
        for line in _lines(site, feature, opening):
            _raise(site, feature, line)


def _lines(site: Site, feature: Feature, opening: BaseGeometry) -> Iterator[shapely.LineString]:
    """Free-standing parts of a barrier within the bounds, without corners that hardly turn."""
    shape = feature.geometry
    if shapely.get_dimensions(shape) == 2:
        # An area that is a barrier, such as a hedge round a garden, stands along its outline.
        shape = shapely.boundary(shape)
    # Half a metre off the border, so that no piece reaches beyond it.
    inside = shapely.buffer(site.place.area, -0.5, join_style="mitre")
    line = shapely.intersection(shapely.simplify(shape, 0.15), inside)
    line = shapely.difference(line, opening)
    # Only the pieces nearby, because a union of all buildings would be slow.
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
    corners = [(x, y) for x, y in shapely.get_coordinates(line).tolist()]
    # Straight pieces between corners become boxes of their own.
    for start, end in pairwise(corners):
        for a, b, ground in _pieces(site, start, end):
            # Shorter by half a thickness, so that neighbouring pieces do not overlap in corners.
            length = math.dist(a, b) - thick_m / 2
            if length < _LEAST_M:
                site.dropped[_SHORT] += 1
                continue
            middle = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)
            heading = math.atan2(b[1] - a[1], b[0] - a[0])
            size = (thick_m, length, height_m)
            # Fences run along their own y axis.
            box = upright_box(middle, heading - math.pi / 2, size, ground.top_m)
            site.add("fence", box, feature, ground.object_id, {"form": form})


def _pieces(site: Site, start: _Point2, end: _Point2) -> Iterator[tuple[_Point2, _Point2, Cover]]:
    """Parts of a straight fence, each on one cover and at most 40 m long."""
    length = math.dist(start, end)
    n = max(1, math.ceil(length / _SAMPLE_M))
    most = math.ceil(_LONGEST_M / _SAMPLE_M)
    middles = [_between(start, end, (k + 0.5) / n) for k in range(n)]
    covers = [site.cover_at(*middle) for middle in middles]
    first = 0
    for k in range(1, n + 1):
        if k == n or covers[k].top_m != covers[first].top_m or k - first == most:
            yield _between(start, end, first / n), _between(start, end, k / n), covers[first]
            first = k


def _between(start: _Point2, end: _Point2, share: float) -> _Point2:
    return (start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1]))
