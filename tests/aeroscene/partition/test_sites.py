from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.partition import SitePartition, build_site, site_partition
from aeroscene.partition.tree import (
    VOID,
    Bank,
    Bend,
    Item,
    Lane,
    Leaf,
    Overlay,
    Part,
    PartitionError,
    Place,
    Slice,
    walk,
)
from aeroscene.scene import OrientedBox
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.catalogue import GROUND
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.partition.layouts import (
    FRAME,
    greatest_error_m,
    overlap_m2,
    scene_of,
    site_scene,
    trees,
)

HALVES = (Part(0.5), Part(0.5))


def boxes(site):
    return [cover.box for cover in build_site(site)]


def test_covers_of_a_scene_are_built_again_within_5_mm(scene):
    parsed = site_partition(scene)
    if parsed is None:
        assert not any(o.category in GROUND and o.domain == "outdoor" for o in scene.objects)
        return
    wanted = [obj for obj in scene.objects if obj.id in parsed.object_ids]
    built = build_site(parsed.site)
    assert greatest_error_m([obj.bbox for obj in wanted], boxes(parsed.site)) < 0.005
    assert sorted(cover.kind for cover in built) == sorted(obj.category for obj in wanted)
    roots = {o.id for o in scene.objects if o.category in GROUND and o.parent_id is None}
    assert roots <= parsed.object_ids


@given(trees())
def test_a_site_is_read_off_what_it_builds(tree):
    site = SitePartition(frame=FRAME, tree=tree)
    parsed = site_partition(site_scene(site))
    assert greatest_error_m(boxes(site), boxes(parsed.site)) < 0.004


@st.composite
def bends(draw):
    """A street of two to four pieces with sidewalks, and lawns along some of it."""
    count = draw(st.integers(2, 4))
    sign = draw(st.sampled_from((-1, 1)))
    walk_m, road_m = draw(st.floats(1.5, 3.0)), draw(st.floats(5.0, 9.0))
    heights = [(0.15,) * count, (0.04,) * count]
    lanes = (
        Lane("sidewalk", walk_m, heights[0], 2),
        Lane("road", road_m, heights[1]),
        Lane("sidewalk", walk_m, heights[0]),
    )
    low = st.floats(-0.1, 0.2)
    banks = [
        Bank(draw(low), draw(st.floats(0.7, 1.0)), draw(st.floats(8.0, 20.0)), Leaf("lawn", 0.06))
        if draw(st.booleans())
        else None
        for _ in range(2 * count)
    ]
    turns = tuple(sign * draw(st.floats(0.25, 0.45)) for _ in range(count - 1))
    lengths = tuple(draw(st.floats(25.0, 32.0)) for _ in range(count))
    return Bend((0.1, 0.4), -sum(turns) / 2, lengths, turns, lanes, tuple(banks))


@given(bends())
def test_a_bend_is_read_off_what_it_builds(bend):
    site = SitePartition(frame=FRAME, tree=bend)
    parsed = site_partition(site_scene(site))
    assert isinstance(parsed.site.tree, Bend)
    assert greatest_error_m(boxes(site), boxes(parsed.site)) < 0.005
    assert parsed.site.tree.turns_rad == pytest.approx(bend.turns_rad, abs=1e-6)


def test_no_ground_is_bare_between_the_pieces_of_a_road():
    lanes = (Lane("road", 8.0, (0.04, 0.04)),)
    for turn in (0.4, -0.4):
        bend = Bend((0.2, 0.5), 0.0, (20.0, 20.0), (turn,), lanes, (None,) * 4)
        first, second = boxes(SitePartition(frame=FRAME, tree=bend))
        outer = (FRAME.yaw_rad - math.copysign(math.pi / 2, turn)) % (2 * math.pi)
        x, y = FRAME.point(0.2 * FRAME.length_m + 20.0, 0.5 * FRAME.width_m)
        reach = 4.0 / math.cos(turn / 2) - 1e-6
        corner = (
            x + reach * math.cos(outer + turn / 2),
            y + reach * math.sin(outer + turn / 2),
        )
        assert all(_holds(box, corner) for box in (first, second))


def _holds(box: OrientedBox, point: tuple[float, float]) -> bool:
    dx, dy = point[0] - box.p[0], point[1] - box.p[1]
    c, s = math.cos(box.yaw_rad), math.sin(box.yaw_rad)
    return abs(c * dx + s * dy) <= box.s[0] / 2 and abs(c * dy - s * dx) <= box.s[1] / 2


def test_a_mound_lies_on_its_cover_at_its_own_heading():
    mound = Item(Leaf("terrain", 0.5), Place(0.3, 0.6, 0.7, (6.0, 4.0)))
    tree = Slice("x", HALVES, (Leaf("lawn", 0.06), Overlay(Leaf("parking_lot", 0.04), (mound,))))
    parsed = site_partition(site_scene(SitePartition(frame=FRAME, tree=tree)))
    found = [n for n in walk(parsed.site.tree) if isinstance(n, Overlay)]
    assert [n.items[0].place.yaw_rad for n in found] == pytest.approx([0.7])


def test_what_covers_a_terrace_divides_it():
    top = Slice("y", HALVES, (Leaf("lawn", 0.06), Leaf("plaza", 0.1)))
    site = SitePartition(frame=FRAME, tree=Overlay(Leaf("terrain", 1.0), (Item(top),)))
    rows = [("terrain", boxes(site)[0], None, {})]
    rows += [(cover.kind, cover.box, 0, {}) for cover in build_site(site)[1:]]
    parsed = site_partition(scene_of(rows))
    assert isinstance(parsed.site.tree, Overlay)
    assert greatest_error_m(boxes(site), boxes(parsed.site)) < 1e-5


def test_roads_keep_their_metres_on_a_larger_site():
    tree = Slice("y", (Part(0.4), Part(6.0, True), Part(0.6)), (Leaf("lawn", 0.1),) * 3)
    wide = SitePartition(frame=replace(FRAME, width_m=90.0), tree=tree)
    assert boxes(wide)[1].s[1] == pytest.approx(6.0)
    assert overlap_m2(boxes(wide)) < 1e-3


def test_a_gap_is_void_and_an_overlap_is_refused():
    def row(x0, x1):
        return ("lawn", OrientedBox(((x0 + x1) / 2, 0, 0.05), quat_from_yaw(0), (x1 - x0, 9, 0.1)))

    apart = site_partition(scene_of([(*row(0, 10), None, {}), (*row(10.5, 20), None, {})]))
    assert [n.kind for n in walk(apart.site.tree) if isinstance(n, Leaf)] == ["lawn", VOID, "lawn"]
    with pytest.raises(PartitionError, match="overlaps another"):
        site_partition(scene_of([(*row(0, 10), None, {}), (*row(9.5, 20), None, {})]))


def test_a_site_without_covers_has_no_partition():
    indoor = cached_scene(311)
    assert site_partition(indoor) is None
