"""Trees at random, and scenes made of what partitions build."""

from __future__ import annotations

import math

import numpy as np
import shapely
from hypothesis import strategies as st
from scipy.spatial import KDTree

from aeroscene.partition import build_site, build_storeys
from aeroscene.partition.frames import Frame
from aeroscene.partition.tree import Cross, Leaf, Node, Part, Pinwheel, Slice
from aeroscene.scene import OrientedBox, Scene, SceneObject
from aeroscene.scene.catalogue import category_id

KINDS = ("lawn", "plaza", "parking_lot", "road", "sidewalk", "water")
FRAME = Frame(3.0, -2.0, 0.4, 70.0, 55.0)


def shares(count: int) -> st.SearchStrategy[tuple[Part, ...]]:
    """Shares of which none is below a sixth of the mean."""
    numbers = st.lists(st.floats(0.2, 1.0), min_size=count, max_size=count)
    return numbers.map(lambda n: tuple(Part(value / sum(n)) for value in n))


@st.composite
def leaves(draw: st.DrawFn) -> Leaf:
    """A cover of any kind, height and heading."""
    return Leaf(draw(st.sampled_from(KINDS)), draw(st.floats(0.02, 0.3)), draw(st.integers(0, 3)))


@st.composite
def trees(draw: st.DrawFn, depth: int = 2) -> Node:
    """A tree of slices, crosses and pinwheels."""
    form = draw(st.sampled_from(("leaf", "slice", "cross", "pinwheel"))) if depth else "leaf"
    below = trees(depth - 1)
    match form:
        case "slice":
            count = draw(st.integers(2, 4))
            children = tuple(draw(below) for _ in range(count))
            return Slice(draw(st.sampled_from(("x", "y"))), draw(shares(count)), children)
        case "cross":
            n, m = draw(st.integers(2, 3)), draw(st.integers(2, 3))
            cells = tuple(draw(below) for _ in range(n * m))
            return Cross(draw(shares(n)), draw(shares(m)), cells)
        case "pinwheel":
            low, high = st.floats(0.2, 0.4), st.floats(0.6, 0.8)
            cuts = (draw(low), draw(high), draw(low), draw(high))
            south, east, north, west, middle = (draw(below) for _ in range(5))
            return Pinwheel(draw(st.booleans()), cuts, (south, east, north, west), middle)
        case _:
            return draw(leaves())


def scene_of(rows, *, domain="outdoor") -> Scene:
    """Rows are category, box, parent's row or None, and attributes."""
    objects = tuple(
        SceneObject(
            id=number,
            scene_id="made",
            parent_id=parent,
            category_id=category_id(category),
            bbox=box,
            domain=domain,
            attributes=attributes,
        )
        for number, (category, box, parent, attributes) in enumerate(rows)
    )
    return Scene(
        scene_id="made",
        domain="outdoor",
        seed=0,
        extent_min_enu_m=(-90.0, -90.0, 0.0),
        extent_max_enu_m=(90.0, 90.0, 40.0),
        start_position_enu_m=(0.0, 0.0, 0.0),
        start_yaw_rad=0.0,
        latitude_deg=0.0,
        longitude_deg=0.0,
        altitude_m=0.0,
        objects=objects,
    )


def site_scene(site) -> Scene:
    """A scene of the covers that a site's partition builds, none with a parent."""
    return scene_of([(cover.kind, cover.box, None, {}) for cover in build_site(site)])


def storey_scene(*storeys) -> Scene:
    """A shell with the rooms and walls of its storeys."""
    frame = storeys[0].frame
    shell = Frame(*(getattr(frame, n) for n in ("x_enu_m", "y_enu_m", "yaw_rad")), 40.0, 40.0)
    rows = [("building", shell.box(0, 0.0, 9.0), None, {})]
    for part in build_storeys(storeys):
        look = {"use": part.kind} if part.category == "room" else {"form": part.kind}
        rows.append((part.category, part.box, 0, look | part.openings))
    return scene_of(rows, domain="indoor")


def greatest_error_m(wanted: list[OrientedBox], found: list[OrientedBox]) -> float:
    """Farthest that a corner of any box lies from the nearest box's, m; boxes are as many."""
    assert len(wanted) == len(found)
    nearest = KDTree([box.p for box in found]).query([box.p for box in wanted])[1]
    return max(_error_m(a, found[i]) for a, i in zip(wanted, nearest, strict=True))


def _error_m(a: OrientedBox, b: OrientedBox) -> float:
    gaps = np.abs(a.corners()[:, None] - b.corners()[None]).max(axis=2)
    return float(gaps.min(axis=1).max())


def outline_of(box: OrientedBox) -> shapely.Polygon:
    """A box seen from above."""
    return shapely.Polygon(box.corners()[[0, 1, 3, 2], :2])


def overlap_m2(boxes: list[OrientedBox]) -> float:
    """Area that two of the boxes share, seen from above."""
    outlines = [outline_of(box) for box in boxes]
    total = sum(outline.area for outline in outlines)
    return total - shapely.union_all(outlines, grid_size=1e-6).area


def is_close(a: float, b: float) -> bool:
    """Equal but for rounding."""
    return math.isclose(a, b, abs_tol=1e-6)
