"""Streets: carriageways, their junctions, and the pavements along them.

The carriageway of a straight stretch is a road of ours, a box with its markings, so that traffic
can drive along it. Junctions and bends are roads with an outline, without traffic.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from aeroscene.maps import street_facts as facts
from aeroscene.maps.claims import GRID_M, areal, areal_parts, on_grid, opened, split
from aeroscene.maps.document import Feature
from aeroscene.maps.site import Cover, Site, framed
from aeroscene.scene import AttributeValue

ROAD_M = 0.02
KERB_M = 0.12
"""Height of pavements above the base of streets: a kerb of 10 cm."""
_SIMPLIFY_M = 0.2
_LEAST_STRETCH_M = 8.0
"""Length up to which a stretch is part of the junction or bend beside it."""
_LEAST_ROAD_M2 = 2.0
_LEAST_PAVEMENT_M2 = 2.0
_NODE_M = 0.05
"""Distance up to which ends of streets meet."""
_Point2 = tuple[float, float]


@dataclass(frozen=True, slots=True)
class _Line:
    feature: Feature
    points: tuple[_Point2, ...]
    width_m: float


def lay_streets(site: Site, features: Sequence[Feature]) -> None:
    """Add the carriageways of streets; buildings keep their ground.

    Args:
        site: Scene in the making.
        features: Streets, as lines.
    """
    lines = list(_lines(features))
    carriageway = site.ground.unclaimed_part(_carriageway(site, lines))
    site.carriageways.add(carriageway)
    n_at = _meetings(lines)
    shape = areal(shapely.intersection(carriageway, site.place.area, grid_size=GRID_M))
    # Wide streets first: at a crossing the narrower one is interrupted.
    for line in sorted(lines, key=lambda each: -each.width_m):
        for stretch in _stretches(line, n_at):
            shape = _lay_stretch(site, line, stretch, shape)
    # Junctions have the surface of most streets.
    finish = Counter(facts.finish(line.feature.tags, "asphalt") for line in lines)
    attributes: dict[str, AttributeValue] = {}
    if finish:
        attributes["finish"] = finish.most_common(1)[0][0]
    for piece in split(opened(shape, 0.2), _LEAST_ROAD_M2):
        _lay(site, "road", shapely.set_precision(piece, GRID_M), ROAD_M, None, attributes)


def lay_pavements(site: Site, features: Sequence[Feature], footways: Sequence[Feature]) -> None:
    """Add pavements beside streets, and footways that are mapped on their own.

    Args:
        site: Scene in the making.
        features: Streets, which may have pavements.
        footways: Lines of separate sidewalks.
    """
    strips: list[BaseGeometry] = []
    for feature in features:
        sides, width = facts.pavements(feature.tags), facts.pavement_width_m(feature.tags)
        for line in _lines([feature]) if sides else ():
            centre = shapely.LineString(line.points)
            # The strip is as wide as street and pavements together; the street is cut out below.
            reach = line.width_m / 2 + width
            if len(sides) == 2:
                strips.append(
                    shapely.buffer(
                        centre, reach, cap_style="flat", join_style="mitre", mitre_limit=2.0
                    )
                )
            else:
                # Positive distances are to the left of a line, in shapely as in the map.
                signed = reach if "left" in sides else -reach
                strips.append(shapely.buffer(centre, signed, single_sided=True))
    for feature in footways:
        half = facts.path_width_m(feature.tags) / 2
        strips.append(
            shapely.buffer(
                feature.geometry, half, cap_style="flat", join_style="mitre", mitre_limit=2.0
            )
        )
    if not strips:
        return
    shape = shapely.intersection(shapely.union_all(strips), site.place.area)
    # Carriageways were claimed before, so only the rims of the strips are left.
    shape = opened(site.ground.unclaimed_part(on_grid(shape)), 0.3)
    for piece in split(shape, _LEAST_PAVEMENT_M2):
        _lay(site, "sidewalk", shapely.set_precision(piece, GRID_M), KERB_M, None, {})


def _lay(
    site: Site,
    category: str,
    polygon: BaseGeometry,
    thickness_m: float,
    feature: Feature | None,
    attributes: dict[str, AttributeValue],
) -> None:
    """Add pieces of ground with outlines."""
    for part in areal_parts(site.within(polygon), 0.5):
        base_m = site.covers[0].top_m
        frame = framed(part, base_m, base_m + thickness_m)
        number = site.add(category, frame.box, feature, None, {**frame.attributes, **attributes})
        site.ground.add(part)
        is_open = category != "road"
        site.covers.append(Cover(part, base_m + thickness_m, number, is_open))


def _lines(features: Sequence[Feature]) -> Iterator[_Line]:
    """Lines of streets, without corners that hardly turn, but with those at which they meet."""
    parts = [
        (feature, [(round(x, 2), round(y, 2)) for x, y in shapely.get_coordinates(part).tolist()])
        for feature in features
        for part in shapely.get_parts(feature.geometry)
    ]
    # A point that two lines have is a junction, and must not be simplified away.
    counts = Counter(_key(point) for _, points in parts for point in dict.fromkeys(points))
    for feature, points in parts:
        kept = _simplified(points, {key for key, count in counts.items() if count > 1})
        if len(kept) >= 2:
            yield _Line(feature, tuple(kept), facts.street_width_m(feature.tags))


def _simplified(points: Sequence[_Point2], fixed: AbstractSet[tuple[int, int]]) -> list[_Point2]:
    kept = [points[0]]
    first = 0
    for k in range(1, len(points)):
        if k == len(points) - 1 or _key(points[k]) in fixed:
            line = shapely.simplify(shapely.LineString(points[first : k + 1]), _SIMPLIFY_M)
            corners = [(x, y) for x, y in shapely.get_coordinates(line)[1:].tolist()]
            kept += [corner for corner in corners if math.dist(corner, kept[-1]) > _NODE_M]
            first = k
    return kept


def _carriageway(site: Site, lines: Sequence[_Line]) -> BaseGeometry:
    """Ground on which cars drive: bands along the lines, with a disc where several meet."""
    if not lines:
        return shapely.Polygon()
    bands = [
        shapely.buffer(
            shapely.LineString(line.points),
            line.width_m / 2,
            cap_style="flat",
            join_style="mitre",
            mitre_limit=2.0,
        )
        for line in lines
    ]
    discs = [
        shapely.buffer(shapely.Point(end), line.width_m / 2, quad_segs=3)
        for line in lines
        for end in (line.points[0], line.points[-1])
    ]
    united = shapely.union_all([*bands, *discs])
    # A little beyond the bounds, so that streets are not narrowed at the border.
    reach = shapely.buffer(site.place.area, 10.0, join_style="mitre")
    return on_grid(shapely.intersection(united, reach))


def _meetings(lines: Sequence[_Line]) -> Counter[tuple[int, int]]:
    """Number of stretches that meet at each corner of the lines."""
    counts: Counter[tuple[int, int]] = Counter()
    for line in lines:
        for number, point in enumerate(line.points):
            is_end = number in {0, len(line.points) - 1}
            # A line that goes on counts as two stretches.
            counts[_key(point)] += 1 if is_end else 2
    return counts


def _key(point: _Point2) -> tuple[int, int]:
    return (round(point[0] / _NODE_M), round(point[1] / _NODE_M))


def _stretches(line: _Line, n_at: Counter[tuple[int, int]]) -> Iterator[tuple[_Point2, _Point2]]:
    """Straight parts of a line without the junctions and bends at their ends."""
    for number, (a, b) in enumerate(pairwise(line.points)):
        length = math.dist(a, b)
        before = _trim_m(line, number, n_at)
        after = _trim_m(line, number + 1, n_at)
        if length - before - after < _LEAST_STRETCH_M:
            continue
        u = np.subtract(b, a) / length
        start, end = np.add(a, before * u), np.subtract(b, after * u)
        yield (float(start[0]), float(start[1])), (float(end[0]), float(end[1]))


def _trim_m(line: _Line, number: int, n_at: Counter[tuple[int, int]]) -> float:
    """Length that a junction or a bend takes from each stretch that meets there, m."""
    points = line.points
    meeting = n_at[_key(points[number])]
    if meeting > 2:
        # Half of the crossing street, and the curve of the kerb.
        return line.width_m / 2 + 2.0
    if number in {0, len(points) - 1}:
        return 0.0
    a, b, c = points[number - 1 : number + 2]
    turn = math.atan2(c[1] - b[1], c[0] - b[0]) - math.atan2(b[1] - a[1], b[0] - a[0])
    half = abs(math.remainder(turn, 2 * math.pi)) / 2
    # In a bend the inner edges meet before the corner: half a width times the tangent of half the
    # turn.
    return min(line.width_m, line.width_m / 2 * math.tan(min(half, 1.2)))


def _lay_stretch(
    site: Site, line: _Line, stretch: tuple[_Point2, _Point2], free: BaseGeometry
) -> BaseGeometry:
    """Add a straight road if the carriageway is whole and free; return the rest of it."""
    tags = line.feature.tags
    (ax, ay), (bx, by) = stretch
    centre = shapely.LineString([stretch[0], stretch[1]])
    centre = shapely.intersection(centre, site.place.area)
    if centre.geom_type != "LineString" or centre.length < _LEAST_STRETCH_M:
        return free
    band = shapely.buffer(centre, line.width_m / 2, cap_style="flat")
    # Slightly smaller, because cuts on the grid move borders by a centimetre.
    inner = shapely.buffer(band, -0.05, join_style="mitre")
    if not shapely.covers(free, inner):
        return free
    finish = facts.finish(tags, "asphalt")
    base_m = site.covers[0].top_m
    frame = framed(band, base_m, base_m + ROAD_M, math.atan2(by - ay, bx - ax))
    attributes: dict[str, AttributeValue] = {"lanes": max(1, round(line.width_m / facts.LANE_M))}
    if finish == "asphalt" and facts.has_markings(tags):
        attributes["form"] = "dashed"
    else:
        attributes |= {**frame.attributes, "finish": finish}
    number = site.add("road", frame.box, line.feature, None, attributes)
    site.ground.add(shapely.set_precision(band, GRID_M))
    site.covers.append(Cover(band, base_m + ROAD_M, number, is_open=False))
    return areal(shapely.difference(free, band, grid_size=GRID_M))
