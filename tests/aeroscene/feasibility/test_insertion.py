"""New things in a region: they find room or go, and nothing else changes."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from aeroscene.areas.landing import derive_interaction_areas
from aeroscene.feasibility.insertion import insert
from aeroscene.feasibility.region import Region
from aeroscene.scene import InteractionArea
from aeroscene.validation import validate
from tests.aeroscene.feasibility.scenes import BENCH, CUP, HOME, LAWN, TABLE, garden, thing

WEST = Region(low_enu_m=(-20.0, -20.0, -math.inf), high_enu_m=(0.0, 20.0, math.inf))
CRATE, SECOND = 20, 21


def box(number, x, y, side=1.0, base=0.06):
    return thing(number, "crate", (x, y, base + side / 2), (side, side, side), LAWN)


@pytest.fixture(scope="module")
def given():
    scene = garden()
    return replace(scene, interaction_areas=derive_interaction_areas(scene))


def inserted(given, *new, region=WEST):
    scene = replace(given, objects=(*given.objects, *new), interaction_areas=())
    return insert(scene, given, region)


def test_what_was_there_stays_and_the_new_finds_room_beside_it(given):
    made = inserted(given, box(CRATE, -6.2, -5.4), box(SECOND, -12.0, 6.0))
    assert made.report.rejection is None
    scene = made.scene
    assert scene.objects[: len(given.objects)] == given.objects
    assert set(scene.object_by_id) == {*given.object_by_id, CRATE, SECOND}
    assert scene.object_by_id[SECOND].bbox.p == (-12.0, 6.0, 0.56)
    x, y, _ = scene.object_by_id[CRATE].bbox.p
    assert 0.1 < math.dist((x, y), (-6.2, -5.4)) < 2.0
    assert validate(scene) == ()


def test_extent_and_start_stay(given):
    scene = inserted(given, box(CRATE, -6.2, -5.4)).scene
    for name in ("extent_min_enu_m", "extent_max_enu_m", "start_position_enu_m", "start_yaw_rad"):
        assert getattr(scene, name) == getattr(given, name)


def test_what_is_kept_moves_not_even_where_it_overlaps_before(given):
    """Also digits beyond those that documents have are left."""
    spots = (-6.1234567, 0.3, 0.4351), (1.2, 2.0, 0.75)
    given = replace(given, objects=garden(thing(TABLE, "table", *spots, LAWN)).objects)
    given = replace(given, objects=(*given.objects, box(30, -6.3, 0.8)), interaction_areas=())
    made = inserted(given, box(CRATE, -12.0, 6.0))
    assert made.scene.objects[: len(given.objects)] == given.objects


def test_what_lies_beside_the_region_or_has_no_room_goes(given):
    new = box(CRATE, 3.0, 0.0), box(SECOND, -12.0, 6.0, side=28.0), box(22, -9.0, 9.0)
    scene = inserted(given, *new).scene
    assert set(scene.object_by_id) - set(given.object_by_id) == {22}


def test_what_hangs_in_the_air_is_set_down(given):
    scene = inserted(given, box(CRATE, -12.0, 6.0, base=3.0)).scene
    assert scene.object_by_id[CRATE].bbox.p == (-12.0, 6.0, 0.56)


def test_the_start_stays_free_where_there_is_no_pad(given):
    """A crate on the start finds another place, whatever it would have there."""
    objects = tuple(obj for obj in given.objects if obj.id != HOME)
    bare = replace(given, objects=objects, interaction_areas=())
    bare = replace(bare, start_position_enu_m=(-10.0, 8.0, 0.06))
    bare = replace(bare, interaction_areas=derive_interaction_areas(bare))
    made = inserted(bare, box(CRATE, -10.2, 8.1))
    assert made.report.rejection is None
    x, y, _ = made.scene.object_by_id[CRATE].bbox.p
    assert max(abs(x + 10.0), abs(y - 8.0)) > 1.6
    assert validate(made.scene) == ()


def test_nothing_new_is_a_rejection(given):
    for new in ((), (box(CRATE, 3.0, 0.0),)):
        made = inserted(given, *new)
        reason = "nothing new has a place in the region -20,-20,0,20; valid: a larger region"
        assert made.report.rejection == reason
        assert made.scene.objects == given.objects


def test_areas_outside_stay_and_those_inside_are_derived_anew(given):
    """A crate where an area was takes it away; the others in the region are found again."""
    scene = inserted(given, box(CRATE, -6.2, -5.4), box(SECOND, -12.0, 6.0)).scene
    there = set(given.interaction_areas)
    east = {a for a in there if min(x for x, _, _ in a.polygon) >= 0.0}
    assert len(east) >= 2
    assert east <= set(scene.interaction_areas)
    for area in set(scene.interaction_areas) - there:
        assert all(WEST.holds(corner) for corner in area.polygon)
    assert len({area.id for area in scene.interaction_areas}) == len(scene.interaction_areas)
    assert len(scene.interaction_areas) <= len(given.interaction_areas)


def test_an_area_outside_whose_claim_no_longer_holds_goes(given):
    """A crate in the region stands within the room that an area before its border claims."""
    x, y, z = -10.0, -10.0, 0.06
    area = InteractionArea(
        id=90,
        object_id=LAWN,
        polygon=tuple(
            (x + u, y + v, z)
            for u, v in ((-0.45, -0.45), (0.45, -0.45), (0.45, 0.45), (-0.45, 0.45))
        ),
        centroid=(x, y, z),
        radius=0.44,
        drone_class="small",
        slope_rad=0.0,
        clearance_m=20.0,
        surface="grass",
    )
    given = replace(given, interaction_areas=(*given.interaction_areas, area))
    assert validate(given) == ()
    region = Region(low_enu_m=(-9.5, -20.0, -math.inf), high_enu_m=(0.0, 20.0, math.inf))
    beside, away = (inserted(given, box(CRATE, u, -10.0), region=region) for u in (-9.0, -4.0))
    assert area in away.scene.interaction_areas
    assert area not in beside.scene.interaction_areas
    assert validate(beside.scene) == ()


def test_pads_tables_and_cups_are_what_they_were(given):
    scene = inserted(given, thing(CRATE, "cup", (-6.0, -0.5, 0.86), (0.1, 0.1, 0.1), TABLE)).scene
    for number in (HOME, TABLE, CUP, BENCH):
        assert scene.object_by_id[number] == given.object_by_id[number]
    assert scene.object_by_id[CRATE].parent_id == TABLE
