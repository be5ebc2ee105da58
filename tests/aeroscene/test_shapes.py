from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.catalogue import CATALOGUE, by_name
from aeroscene.geometry import quat_from_yaw
from aeroscene.scene import OrientedBox, SceneObject
from aeroscene.shapes import MATERIALS, SHAPES, object_primitives
from aeroscene.shapes.facade import (
    LINTEL_M,
    SILL_M,
    FacadePlan,
    bay_borders,
    count_bays,
    opening_width,
)
from aeroscene.voxels import bounds

SLACK_M = 0.021


def make(name, size, yaw=0.0, number=3, **attributes):
    return SceneObject(
        id=number,
        scene_id="s",
        parent_id=None,
        category_id=by_name()[name].id,
        bbox=OrientedBox((4.0, -2.0, size[2] / 2), quat_from_yaw(yaw), size),
        domain="outdoor",
        attributes=attributes,
    )


def typical(name):
    category = by_name()[name]
    spans = (category.length_m, category.width_m, category.height_m)
    return tuple((low + high) / 2 for low, high in spans)


def assert_sound(obj):
    primitives = object_primitives(obj)
    assert any(primitive.collides for primitive in primitives)
    half = np.asarray(obj.bbox.s) / 2 + SLACK_M
    for primitive in primitives:
        assert primitive.material in MATERIALS
        assert min(primitive.size_m) > 0
        assert primitive.object_id == obj.id
        assert bool(primitive.vertices_m) == (primitive.kind == "mesh")
        low, high = bounds(primitive)
        assert np.all(low >= np.asarray(obj.bbox.p) - half)
        assert np.all(high <= np.asarray(obj.bbox.p) + half)


def test_every_category_has_a_shape():
    assert set(SHAPES) == set(by_name())


@settings(max_examples=12)
@given(st.tuples(*[st.floats(0.0, 1.0)] * 3), st.integers(0, 11), st.booleans(), st.integers(1, 4))
def test_parts_stay_within_the_box_at_every_real_size(fractions, number, is_enterable, storeys):
    for category in CATALOGUE.values():
        spans = (category.length_m, category.width_m, category.height_m)
        size = tuple(lo + f * (hi - lo) for f, (lo, hi) in zip(fractions, spans, strict=True))
        obj = make(category.name, size, number=number, is_enterable=is_enterable, storeys=storeys)
        assert_sound(obj)


@settings(max_examples=12)
@given(st.tuples(*[st.floats(0.002, 90)] * 3), st.booleans())
def test_sizes_that_no_such_thing_has_still_give_something_solid(size, is_enterable):
    for name in SHAPES:
        assert_sound(make(name, size, is_enterable=is_enterable, door_m=1.2))


@pytest.mark.parametrize(
    ("name", "kind", "material", "count"),
    [
        ("car", "cylinder", "rubber", 4),
        ("truck", "cylinder", "rubber", 6),
        ("bicycle", "cylinder", "rubber", 2),
        ("tree", "cylinder", "bark", 1),
        ("canopy", "cylinder", "metal", 4),
        ("solar_panel", "box", "solar", 1),
    ],
)
def test_a_thing_has_what_makes_it_recognisable(name, kind, material, count):
    parts = object_primitives(make(name, typical(name)))
    assert sum(p.kind == kind and p.material == material for p in parts) == count


def test_a_table_stands_on_four_legs_with_air_between_them():
    size = (1.0, 2.0, 0.75)
    parts = [p for p in object_primitives(make("table", size)) if p.collides]
    legs = [p for p in parts if p.position_enu_m[2] < 0.5]
    assert len(legs) == 4
    assert all(abs(leg.position_enu_m[0] - 4.0) > 0.3 for leg in legs)


def test_turning_an_object_turns_its_parts():
    ahead = object_primitives(make("car", (4.5, 1.8, 1.5)))
    left = object_primitives(make("car", (4.5, 1.8, 1.5), yaw=np.pi / 2))
    centre = np.array([4.0, -2.0, 0.75])
    for a, b in zip(ahead, left, strict=True):
        x, y, z = np.asarray(a.position_enu_m) - centre
        assert np.allclose(np.asarray(b.position_enu_m) - centre, (-y, x, z), atol=1e-6)


def test_attributes_choose_colours_and_an_unknown_colour_falls_back():
    red = object_primitives(make("car", (4.5, 1.8, 1.5), colour="red"))
    assert any(p.material == "paint_red" for p in red)
    odd = object_primitives(make("car", (4.5, 1.8, 1.5), colour="ultraviolet"))
    assert any(p.material.startswith("paint_") for p in odd)


@given(st.floats(6, 40))
def test_openings_of_a_facade_let_a_drone_through_and_partitions_meet_piers(length):
    assert opening_width(length) >= 1.4
    assert LINTEL_M - SILL_M >= 1.6
    plan = FacadePlan(length, 1, 3.3, None, "open")
    openings = [plan.opening(bay) for bay in range(count_bays(length))]
    assert all(low > -length / 2 and high < length / 2 for low, high in openings)
    for border in bay_borders(length):
        assert all(not low - 0.1 < border < high + 0.1 for low, high in openings)
