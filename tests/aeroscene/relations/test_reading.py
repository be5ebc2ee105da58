import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.relations import Align, Gap, Kind, place, scene_relations
from aeroscene.relations.relation import LANES, MAX_HOSTS, MAX_ROWS, N_SIDES, N_SLOTS
from tests.aeroscene.metrics.scenes import box, scene_of
from tests.aeroscene.relations.rooms import ROOM, dining, office, on_floor, street


def coarse_boxes(scene):
    return {obj.id: obj.bbox for obj in scene.objects if obj.is_coarse}


def assert_same(scene, boxes):
    fine = [obj for obj in scene.objects if not obj.is_coarse]
    assert set(boxes) == {obj.id for obj in fine}
    for obj in fine:
        found = boxes[obj.id]
        assert found.s == obj.bbox.s
        assert np.allclose(found.p, obj.bbox.p, rtol=0.0, atol=1e-6)
        assert abs(np.dot(found.q, obj.bbox.q)) == pytest.approx(1.0, abs=1e-8)


def unit_of(scene, category):
    """The unit of the only object of a category, or of the group of all."""
    (unit,) = (
        unit
        for unit in scene_relations(scene)
        if scene.object_by_id[unit.members[0].id].category == category
    )
    return unit


def test_what_is_read_off_a_corpus_scene_gives_it_back(scene):
    assert_same(scene, place(scene_relations(scene), coarse_boxes(scene)))


_turn = st.one_of(st.sampled_from((0.0, 90.0, 180.0, -90.0)), st.floats(-180, 180))
_thing = st.tuples(
    st.sampled_from(("chair", "table", "desk", "bench", "car", "street_lamp", "plate")),
    st.floats(-6, 6),
    st.floats(-6, 6),
    st.tuples(st.floats(0.1, 3), st.floats(0.1, 3), st.floats(0.1, 2)),
    _turn,
    st.integers(0, 2),
)


@given(st.lists(_thing, max_size=12), st.floats(-180, 180), st.floats(-0.3, 0.3))
def test_any_boxes_come_back(things, yaw_deg, tilt_rad):
    room = ("room", box((3, -2, 1.5), (12, 10, 3), yaw_deg))
    road = ("road", box((1, 2, 0.05), (40, 8, 0.1), -yaw_deg))
    tilted = (math.cos(tilt_rad), math.sin(tilt_rad), 0.0, 0.0)
    lamp = ("lamp", box((1, 1, 2.5), (0.4, 0.4, 0.4), q=tilted), 0)
    rows = [on_floor(name, x, y, size, turn, parent) for name, x, y, size, turn, parent in things]
    scene = scene_of(room, road, lamp, *rows)
    assert_same(scene, place(scene_relations(scene), coarse_boxes(scene)))


def test_hosts_stand_before_what_refers_to_them_and_symbols_are_in_range(scene):
    standing = {None, *coarse_boxes(scene)}
    for unit in scene_relations(scene):
        assert {unit.parent_id, unit.host_id} <= standing
        standing |= {member.id for member in unit.members}
        assert unit.relation.host < MAX_HOSTS
        assert unit.relation.side in range(N_SIDES)
        assert unit.relation.slot in range(N_SLOTS)
        if unit.array:
            assert max(unit.array.rows, unit.array.columns) <= MAX_ROWS


def test_what_relations_pin_is_noise(scene):
    for unit in scene_relations(scene):
        noise = [member.residual for member in unit.members]
        pins = zip(("u_m", "v_m", "yaw_rad"), unit.relation.pinned, strict=True)
        pinned = [getattr(unit.residual, name) for name, is_pinned in pins if is_pinned]
        off = [value for r in noise for value in (r.u_m, r.v_m, r.yaw_rad)]
        assert max(map(abs, [*off, *pinned, 0.0])) < 0.21, unit


def test_only_boxes_categories_and_parents_are_read(scene):
    bare = tuple(replace(obj, attributes={}) for obj in scene.objects)
    assert scene_relations(replace(scene, objects=bare)) == scene_relations(scene)


@pytest.mark.parametrize("fault", [{"turned_deg": 50.0}, {"shift_m": 1.0}])
def test_chairs_turned_or_moved_off_their_table_are_not_seated(fault):
    def n_seated(scene):
        seats = [unit for unit in scene_relations(scene) if unit.relation.kind == Kind.SEAT]
        return sum(len(unit.members) for unit in seats)

    assert n_seated(dining()) == 4
    assert n_seated(dining(**fault)) == 2


def test_chairs_of_a_table_are_one_group():
    unit = unit_of(dining(), "chair")
    assert (unit.relation.kind, unit.relation.align) == (Kind.SEAT, Align.SLOT)
    assert len(unit.members) == 4
    # Two seats at each long side, whose one seat at each end is empty.
    assert (unit.array.rows, unit.array.columns, unit.array.holes) == (2, 1, (2, 5))
    assert unit.array.pitch_m[0] == pytest.approx(0.9)
    assert all(abs(member.residual.yaw_rad) < 1e-6 for member in unit.members)


@pytest.mark.parametrize("hole", [None, (0, 1), (1, 2)])
def test_a_grid_is_one_group_with_holes(hole):
    unit = unit_of(office(hole=hole), "desk")
    assert (unit.array.rows, unit.array.columns) == (2, 4)
    assert unit.array.pitch_m == pytest.approx((2.0, 1.8))
    assert unit.array.holes == (() if hole is None else (4 * hole[0] + hole[1],))


def test_cars_in_a_row_may_look_both_ways():
    cars = [on_floor("car", 0, 2.6 * k, (4.2, 1.8, 1.5), 180.0 * (k == 1)) for k in range(4)]
    unit = unit_of(scene_of(("lawn", box((0, 3, -0.05), (20, 20, 0.1))), *cars), "car")
    assert (unit.array.columns, unit.array.turned) == (4, (1,))
    assert all(abs(member.residual.yaw_rad) < 1e-6 for member in unit.members)


def test_a_corner_has_two_sides():
    unit = unit_of(scene_of(ROOM, on_floor("wardrobe", 5.7, 4.0, (0.54, 1.94, 2), 180)), "wardrobe")
    relation = unit.relation
    assert (relation.kind, relation.gap, relation.quadrant) == (Kind.EDGE, Gap.TOUCH, 2)
    assert (relation.side, relation.align) == (0, Align.HIGH)


@pytest.mark.parametrize(("heading_deg", "is_right"), [(0.0, True), (180.0, False)])
def test_the_side_that_vehicles_drive_on_is_read_from_the_heading(heading_deg, is_right):
    unit = unit_of(street(on_floor("car", 5, -2.0, (4.2, 1.8, 1.5), heading_deg)), "car")
    assert unit.relation.kind == Kind.LANE
    assert (LANES[unit.relation.slot] < 0) == is_right


def test_a_traffic_light_stands_at_the_road_whatever_it_stands_on():
    scene = street(on_floor("traffic_light", 10, 4.4, (0.35, 0.4, 3), parent=1))
    unit = unit_of(scene, "traffic_light")
    assert unit.relation.kind == Kind.SIDE
    assert scene.object_by_id[unit.host_id].category == "road"
    assert scene.object_by_id[unit.parent_id].category == "sidewalk"


def test_a_plate_lies_before_its_seat():
    scene = dining()
    x, y, _ = scene.objects[-1].bbox.p
    plate = replace(
        scene.objects[-1],
        id=99,
        parent_id=scene.objects[1].id,
        category_id=scene_of(("plate", box((0, 0, 0), (0.1, 0.1, 0.1)))).objects[0].category_id,
        bbox=box((x - 0.5, y, 0.75), (0.25, 0.25, 0.02)),
    )
    scene = replace(scene, objects=(*scene.objects, plate))
    unit = unit_of(scene, "plate")
    assert scene.object_by_id[unit.host_id].category == "chair"
    assert unit.relation.pinned[:2] == (True, True)


def test_a_lamp_hangs_over_its_table_and_a_sofa_comes_before_its_coffee_table():
    sofa = on_floor("sofa", -5.5, 0, (0.9, 2.0, 0.8))
    table = on_floor("coffee_table", -5.5 + 0.45 + 0.45 + 0.35, 0.0, (0.7, 1.2, 0.4), 180)
    lamp = ("lamp", box((-4.25, 0.0, 2.6), (0.4, 0.4, 0.4), 30.0), 0)
    scene = scene_of(ROOM, table, sofa, lamp)
    table_unit, lamp_unit = unit_of(scene, "coffee_table"), unit_of(scene, "lamp")
    assert scene.object_by_id[table_unit.host_id].category == "sofa"
    assert (table_unit.relation.kind, table_unit.relation.gap) == (Kind.SIDE, Gap.APART)
    assert scene.object_by_id[lamp_unit.host_id].category == "coffee_table"
    assert lamp_unit.relation.kind == Kind.OVER


def test_two_things_face_each_other():
    sofa = on_floor("sofa", -5.0, 0.3, (0.9, 2.0, 0.8))
    cabinet = on_floor("cabinet", -1.8, 0.32, (0.4, 1.6, 0.7), 180)
    unit = unit_of(scene_of(ROOM, sofa, cabinet), "cabinet")
    assert (unit.relation.kind, unit.relation.pinned) == (Kind.FACING, (False, True, True))
