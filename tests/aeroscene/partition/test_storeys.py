from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from aeroscene.partition import (
    Border,
    PartitionError,
    Segment,
    StoreyPartition,
    build_storeys,
    building_partitions,
    storey_lines,
)
from aeroscene.partition.cells import cells_of
from aeroscene.partition.frames import Frame
from aeroscene.partition.storeys.storey import OPEN, find_lines, storey_cells
from aeroscene.partition.tree import VOID, Leaf, Part, Slice, children, with_children
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.partition.layouts import (
    greatest_error_m,
    outline_of,
    overlap_m2,
    scene_of,
    storey_scene,
    trees,
)

FRAME = Frame(1.0, 2.0, 0.3, 30.0, 24.0)
WALL = Border((Segment("wall", Part(1.0)),))
DOOR = Border(
    (
        Segment("wall", Part(0.3)),
        Segment("door", Part(1.5, is_width=True), 0.0, 2.3),
        Segment("wall", Part(0.7)),
    ),
    "glass",
)
HATCH = Border(
    (
        Segment("open", Part(0.4)),
        Segment("wall", Part(0.2)),
        Segment("window", Part(0.9, is_width=True), 0.8, 2.0),
        Segment("wall", Part(0.4)),
    )
)


def storey_of(tree, border_of, *, level=0.15, **fields):
    """A storey with the border that a function gives for each of its lines."""
    cells = list(cells_of(tree, FRAME, level))
    lines = find_lines(cells, FRAME, has_outside=fields.get("outer_m", 0.0) > 0)
    return StoreyPartition(
        **{"frame": FRAME, "level_m": level, "tree": tree, "wall_m": 0.12, **fields},
        borders=tuple(border_of(line) for line in lines),
    )


def boxes(parts, category):
    return [part.box for part in parts if part.category == category]


def test_rooms_walls_and_openings_of_a_scene_are_built_again_within_5_mm(scene):
    for parsed in building_partitions(scene):
        built = build_storeys(parsed.storeys)
        assert not parsed.free_wall_ids
        wanted = [obj for obj in scene.objects if obj.id in parsed.object_ids]
        for category in ("room", "wall"):
            old = [obj.bbox for obj in wanted if obj.category == category]
            if old:
                assert greatest_error_m(old, boxes(built, category)) < 0.005
        old = openings((obj.bbox, obj.attributes) for obj in wanted)
        new = openings((part.box, part.openings) for part in built)
        assert len(old) == len(new)
        assert np.allclose(old, new, atol=1e-3)


def openings(walls):
    """Place, width and upper end of each door and window, in order."""
    rows = []
    for box, attributes in walls:
        for name in ("door", "window"):
            if f"{name}_m" in attributes:
                along = attributes.get(f"{name}_offset_m", 0.0)
                x, y = (
                    box.p[0] - along * math.sin(box.yaw_rad),
                    box.p[1] + along * math.cos(box.yaw_rad),
                )
                head = attributes.get(f"{name}_height_m", 2.4)
                rows.append((x, y, box.p[2], attributes[f"{name}_m"], head))
    return sorted(rows, key=lambda row: tuple(np.round(row, 2)))


def heights(tree):
    """The same tree with rooms of one height."""
    if isinstance(tree, Leaf):
        return Leaf(tree.kind, 3.0)
    return with_children(tree, tuple(heights(child) for child in children(tree)))


def is_roomy(lines):
    """Whether no two lines are nearer to each other than two walls need, and none is that short."""
    gaps = [abs(a.at - b.at) for a, b in combinations(lines, 2) if a.axis == b.axis]
    return all(not 1e-6 < gap < 0.4 for gap in gaps) and all(n.high - n.low > 0.4 for n in lines)


@given(st.one_of(trees(1), trees(2)), st.randoms(use_true_random=False))
def test_a_storey_is_read_off_what_it_builds(tree, random):
    def border(line):
        if line.high - line.low < 4.0:
            return WALL
        return random.choice((WALL, DOOR))

    storey = storey_of(heights(tree), border)
    assume(is_roomy(storey_lines(storey)))
    built = build_storeys([storey])
    if not boxes(built, "wall"):
        return
    (parsed,) = building_partitions(storey_scene(storey))
    again = build_storeys(parsed.storeys)
    for category in ("room", "wall"):
        assert greatest_error_m(boxes(built, category), boxes(again, category)) < 0.005
    assert overlap_m2(boxes(built, "wall")) < 1e-3
    assert overlap_m2([*boxes(built, "wall"), *boxes(built, "room")]) < 1e-3


def test_walls_open_stretches_and_windows_stand_where_the_border_says():
    tree = Slice("x", (Part(0.4), Part(0.6)), (Leaf("hall", 3.0), Leaf("office", 3.0)))
    storey = storey_of(tree, lambda _: HATCH)
    (wall,) = [part for part in build_storeys([storey]) if part.category == "wall"]
    open_m = 0.4 * (24.0 - 0.9)
    assert wall.box.s == pytest.approx((0.12, 24.0 - open_m, 3.0))
    assert wall.openings["window_m"] == pytest.approx(0.9)
    assert wall.openings["window_sill_m"] == 0.8
    (parsed,) = building_partitions(storey_scene(storey))
    kinds = [segment.kind for segment in parsed.storeys[0].borders[0].segments]
    assert kinds == ["open", "wall", "window", "wall"]


def test_a_gallery_has_a_void_beside_it_and_its_edge_wall_stands_lower():
    room = Slice("x", (Part(0.5), Part(0.5)), (Leaf("hall", 7.0), Leaf("office", 3.3)))
    gallery = Slice("x", (Part(0.5), Part(0.5)), (Leaf(VOID), Leaf("library", 3.0)))
    lower = storey_of(room, lambda _: DOOR)
    upper = storey_of(gallery, lambda _: WALL, level=3.75, drop_m=0.25)
    built = build_storeys([lower, upper])
    bases = [box.p[2] - box.s[2] / 2 for box in boxes(built, "wall")]
    assert bases == pytest.approx([0.15, 3.5])
    (parsed,) = building_partitions(storey_scene(lower, upper))
    assert [s.level_m for s in parsed.storeys] == pytest.approx([0.15, 3.75])
    assert parsed.storeys[1].drop_m == pytest.approx(0.25)


def test_two_doors_on_a_line_make_two_walls():
    segment = Segment("door", Part(1.0, is_width=True), 0.0, 2.2)
    plain = Segment("wall", Part(1 / 3))
    border = Border((plain, segment, plain, segment, plain))
    tree = Slice("y", (Part(0.5), Part(0.5)), (Leaf("a", 3.0), Leaf("b", 3.0)))
    walls = [p for p in build_storeys([storey_of(tree, lambda _: border)]) if p.category == "wall"]
    assert len(walls) == 2
    assert sum(wall.box.s[1] for wall in walls) == pytest.approx(30.0)
    assert all("door_m" in wall.openings for wall in walls)


@pytest.mark.parametrize("axes", ["xy", "yx"])
@pytest.mark.parametrize(
    "step", [(Part(0.5), Part(0.5)), (Part(1.0), Part(0.2, is_width=True))], ids=["half", "20 cm"]
)
def test_an_l_shaped_room_has_no_wall_inside_and_walls_all_round(step, axes):
    tree = Slice(
        axes[0],
        (Part(0.5), Part(0.5)),
        (
            Leaf("living", 3.0, merge=1),
            Slice(axes[1], step, (Leaf("living", 3.0, merge=1), Leaf(VOID))),
        ),
    )
    storey = storey_of(tree, lambda _: WALL, is_inset=False, outer_m=0.15, wall_m=0.06)
    assert len(storey_lines(storey)) == 6
    built = build_storeys([storey])
    assert overlap_m2([part.box for part in built]) < 1e-3
    floor = shapely.union_all([outline_of(box) for box in boxes(built, "room")], grid_size=1e-6)
    ring = floor.buffer(0.15, join_style="mitre").difference(floor)
    walls = shapely.union_all([outline_of(box) for box in boxes(built, "wall")])
    assert walls.symmetric_difference(ring).area < 1e-3
    rows = [(p.category, p.box, None, {"room": 0} if p.category == "room" else {}) for p in built]
    (parsed,) = building_partitions(scene_of(rows, domain="indoor"))
    assert len(boxes(build_storeys(parsed.storeys), "wall")) == 6


def test_a_wall_off_every_border_is_named_free():
    tree = Slice("x", (Part(0.4), Part(0.6)), (Leaf("hall", 3.0), Leaf("office", 3.0)))
    scene = storey_scene(storey_of(tree, lambda _: WALL))
    wall = scene.objects[-1]
    x, y, z = wall.bbox.p
    moved = replace(
        wall, bbox=replace(wall.bbox, p=(x + 3 * math.cos(0.3), y + 3 * math.sin(0.3), z))
    )
    (parsed,) = building_partitions(replace(scene, objects=(*scene.objects[:-1], moved)))
    assert parsed.free_wall_ids == {wall.id}
    assert all(border == OPEN for border in parsed.storeys[0].borders)


def test_rooms_that_overlap_and_a_missing_border_are_refused():
    tree = Slice("x", (Part(0.4), Part(0.6)), (Leaf("hall", 3.0), Leaf("office", 3.0)))
    storey = storey_of(tree, lambda _: WALL)
    with pytest.raises(PartitionError, match=r"storey.borders has 0 entries; valid: 1"):
        replace(storey, borders=())
    scene = storey_scene(storey)
    room = scene.objects[1]
    wide = replace(room, bbox=replace(room.bbox, s=(room.bbox.s[0] + 2.0, *room.bbox.s[1:])))
    broken = replace(scene, objects=(scene.objects[0], wide, *scene.objects[2:]))
    with pytest.raises(PartitionError, match="overlaps another"):
        building_partitions(broken)


def test_galleries_of_the_corpus_leave_voids():
    parsed = building_partitions(cached_scene(2))[0]
    assert len(parsed.storeys) == 2
    assert any(cell.leaf.kind == VOID for cell in storey_cells(parsed.storeys[1]))
