"""A made-up town in OpenStreetMap's XML, in metres about a place in the Baltic Sea."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

from aeroscene.scene.origin import metres_per_degree

LATITUDE_DEG, LONGITUDE_DEG = 55.0, 18.0
Point = tuple[float, float]
Tags = dict[str, str]


def degrees(x_m: float, y_m: float) -> tuple[float, float]:
    """Longitude and latitude of a point in metres."""
    north_m, east_m = metres_per_degree(LATITUDE_DEG, 0.0)
    return LONGITUDE_DEG + x_m / east_m, LATITUDE_DEG + y_m / north_m


def bounds_text(half_x_m: float = 60.0, half_y_m: float = 50.0) -> str:
    """West, south, east, north of a rectangle about the middle."""
    values = (*degrees(-half_x_m, -half_y_m), *degrees(half_x_m, half_y_m))
    return ",".join(f"{value:.9f}" for value in values)


class OsmFile:
    """Collects elements, numbers them, writes them."""

    def __init__(self) -> None:
        self._nodes: list[str] = []
        self._others: list[str] = []
        self._count = 0

    def node(self, point: Point, **tags: str) -> int:
        number = self._next()
        lon, lat = degrees(*point)
        self._nodes.append(
            f'<node id="{number}" lat="{lat:.9f}" lon="{lon:.9f}">{_tags(tags)}</node>'
        )
        return number

    def way(self, points: Sequence[Point], tags: Tags, *, is_closed: bool = False) -> int:
        nodes = [self.node(point) for point in points]
        nodes += nodes[:1] if is_closed else []
        return self.way_of(nodes, tags)

    def way_of(self, nodes: Sequence[int], tags: Tags) -> int:
        number = self._next()
        refs = "".join(f'<nd ref="{node}"/>' for node in nodes)
        self._others.append(f'<way id="{number}">{refs}{_tags(tags)}</way>')
        return number

    def area(self, points: Sequence[Point], tags: Tags) -> int:
        return self.way(points, tags, is_closed=True)

    def relation(self, members: Sequence[tuple[str, int, str]], tags: Tags) -> int:
        number = self._next()
        parts = "".join(
            f'<member type="{kind}" ref="{ref}" role="{role}"/>' for kind, ref, role in members
        )
        self._others.append(f'<relation id="{number}">{parts}{_tags(tags)}</relation>')
        return number

    def text(self) -> str:
        inner = "\n".join([*self._nodes, *self._others])
        return f'<?xml version="1.0" encoding="UTF-8"?>\n<osm version="0.6">\n{inner}\n</osm>\n'

    def write(self, path: Path) -> Path:
        path.write_text(self.text(), encoding="utf-8")
        return path

    def _next(self) -> int:
        self._count += 1
        return self._count


def _tags(tags: Tags) -> str:
    return "".join(f"<tag k={quoteattr(k)} v={quoteattr(v)}/>" for k, v in tags.items())


L_SHAPE: tuple[Point, ...] = ((-40, 15), (-20, 15), (-20, 25), (-30, 25), (-30, 35), (-40, 35))
SKEWED: tuple[Point, ...] = ((15, 14), (33, 17), (30, 33), (20, 30), (19, 38), (11, 35))
"""An outline with no two edges at a right angle."""


def town() -> OsmFile:
    """A crossroads with houses, a court, a park with a pond, trees, fences and furniture."""
    file = OsmFile()
    middle = file.node((0, 0), highway="traffic_signals")
    west, east = file.node((-90, 0)), file.node((90, 0))
    south, bend, north = file.node((0, -80)), file.node((2, 40)), file.node((20, 90))
    file.way_of([west, middle, east], {"highway": "tertiary", "name": "Long Street", "lanes": "2"})
    file.way_of([south, middle, bend, north], {"highway": "residential", "width": "5"})
    file.area(L_SHAPE, {"building": "house", "building:levels": "2", "roof:shape": "gabled"})
    file.area(SKEWED, {"building": "office", "height": "14 m"})
    outer = file.way([(10, -45), (45, -45), (45, -12)], {})
    closing = file.way([(45, -12), (10, -12), (10, -45)], {})
    inner = file.way([(20, -35), (35, -35), (35, -22), (20, -22)], {}, is_closed=True)
    file.relation(
        [("way", outer, "outer"), ("way", closing, "outer"), ("way", inner, "inner")],
        {"type": "multipolygon", "building": "apartments", "building:levels": "3"},
    )
    file.area([(-50, -45), (-10, -45), (-10, -10), (-50, -10)], {"leisure": "park"})
    file.area([(-45, -40), (-35, -42), (-30, -34), (-40, -30)], {"natural": "water"})
    file.way([(-48, -12), (-20, -25), (-12, -44)], {"highway": "footway"})
    file.way([(-44, 12), (-44, 38), (-25, 38)], {"barrier": "fence", "height": "1.2"})
    file.node((-20, -18), natural="tree", height="9")
    file.node((-17, -18), natural="tree")
    file.way([(-26, -14), (-46, -14)], {"natural": "tree_row"})
    file.node((-25, -24), amenity="bench", direction="90")
    file.node((6, 12), highway="street_lamp")
    file.node((-12, 20), amenity="waste_basket")
    file.node((-35, 20), amenity="bench")
    return file
