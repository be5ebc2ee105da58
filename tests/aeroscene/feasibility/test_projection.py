from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aeroscene.feasibility import FeasibilityCfg, make_feasible
from aeroscene.feasibility.boxes import boxes_of, forbidden_overlaps
from aeroscene.feasibility.layout import layout_of
from aeroscene.feasibility.overlap_repair import cut_overlaps
from aeroscene.landform import standing_points
from aeroscene.layouts.flyable import make_flyable
from aeroscene.layouts.neutral_format import neutral_layout
from aeroscene.scene import Scene
from aeroscene.sources import load_scene
from aeroscene.validation import validate
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.feasibility.scenes import (
    BENCH,
    CUP,
    HOME,
    LAWN,
    PLAZA,
    TABLE,
    garden,
    thing,
    unsettled,
)
from tests.aeroscene.layouts.samples import house

QUICK = FeasibilityCfg(is_validated=False)


@pytest.mark.parametrize("index", [10, 44, 311])
def test_a_sound_scene_stays_as_it_is(index):
    scene = cached_scene(index)
    result = make_feasible(scene, QUICK)
    assert result.scene.objects == scene.objects
    assert result.scene.extent_max_enu_m == scene.extent_max_enu_m
    assert result.scene.start_position_enu_m == scene.start_position_enu_m
    assert result.report.mean_moved_m == 0
    assert result.report.rejection is None


@pytest.mark.parametrize(("index", "sigma_m"), [(42, 0.1), (26, 0.5), (7, 2.0)])
def test_an_unsettled_scene_becomes_sound(index, sigma_m):
    raw = unsettled(cached_scene(index), sigma_m, seed=index)
    result = make_feasible(raw, QUICK)
    assert result.report.rejection is None
    assert not validate(result.scene)
    assert not len(forbidden_overlaps(boxes_of(result.scene.objects), 0.0015).pairs)
    assert 0 < result.report.median_moved_m < 0.15 + 2 * sigma_m
    assert result.report.n_dropped <= 0.02 * len(raw.objects)
    colliding = np.unique(forbidden_overlaps(boxes_of(raw.objects), 0.01).pairs)
    assert len(colliding) > 0.1 * len(raw.objects)


def test_the_same_scene_gives_the_same_result(scene_42: Scene):
    raw = unsettled(scene_42, 0.3, seed=3)
    first, second = make_feasible(raw, QUICK), make_feasible(raw, QUICK)
    assert first.scene == second.scene
    assert first.report == second.report


def test_things_part_by_the_shorter_way_and_carry_what_stands_on_them():
    beside = thing(BENCH, "bench", (-5.3, 0.2, 0.46), (0.6, 1.8, 0.8), LAWN)
    objects = make_feasible(garden(beside), QUICK).scene.object_by_id
    table, bench, cup = (np.array(objects[i].bbox.p) for i in (TABLE, BENCH, CUP))
    assert bench[0] - table[0] == pytest.approx(0.9, abs=0.01)
    assert bench[1] == pytest.approx(0.2, abs=0.01)
    np.testing.assert_allclose(cup - table, (0.0, 0.5, 0.425), atol=0.01)


def test_feet_come_down_to_what_bears_them():
    floating = thing(CUP, "cup", (-6.0, 0.5, 1.4), (0.1, 0.1, 0.1), TABLE)
    sunk = thing(BENCH, "bench", (-6.0, -5.0, 0.2), (0.6, 1.8, 0.8), LAWN)
    objects = make_feasible(garden(floating, sunk), QUICK).scene.object_by_id
    assert objects[CUP].bbox.p[2] == pytest.approx(0.86)
    assert objects[BENCH].bbox.p[2] == pytest.approx(0.46)


@pytest.mark.parametrize(("width_m", "is_cut"), [(1.2, False), (1.6, True)])
def test_ground_is_not_cut_narrower_than_its_category_can_be(width_m, is_cut):
    pavement = thing(30, "sidewalk", (50.0, 0.0, 0.06), (6.0, width_m, 0.12))
    kiosk = thing(31, "kiosk", (50.0, width_m / 2 + 1.1, 1.4), (4.0, 3.0, 2.8))
    layout = layout_of(garden(pavement, kiosk))
    assert cut_overlaps(layout, np.ones(len(layout.objects), dtype=bool)) == is_cut
    row = next(row for row, obj in enumerate(layout.objects) if obj.id == 30)
    wanted = width_m - 0.4 if is_cut else width_m
    assert 2 * layout.boxes.half_m[row, 1] == pytest.approx(wanted, abs=0.001)


def test_ground_is_cut_and_what_stands_on_it_stays():
    long = thing(PLAZA, "plaza", (0.0, 16.0, 0.05), (30.0, 12.0, 0.1))
    scene = garden(long)
    result = make_feasible(scene, QUICK)
    before, after = scene.object_by_id, result.scene.object_by_id
    assert after[TABLE].bbox.p == pytest.approx(before[TABLE].bbox.p, abs=0.1)
    depths = [after[i].bbox.s[1] for i in (LAWN, PLAZA)]
    assert sum(depths) < 42.0 - 4.0


def test_the_air_over_the_home_pad_is_free():
    tree = thing(9, "tree", (10.0, 8.0, 3.06), (3.0, 3.0, 6.0), LAWN)
    objects = make_feasible(garden(tree), QUICK).scene.object_by_id
    offset = np.abs(np.array(objects[9].bbox.p[:2]) - objects[HOME].bbox.p[:2])
    assert offset.max() >= 3.6 + 1.5 - 0.01


def test_the_home_pad_does_not_sink_into_a_ramp():
    ramp = thing(LAWN, "terrain", (0.0, 0.0, 0.7), (30.0, 30.0, 1.4), form="ramp", finish="grass")
    pad = make_feasible(garden(ramp)).scene.object_by_id[HOME]
    assert pad.parent_id == PLAZA
    assert pad.bbox.p[2] == pytest.approx(0.125, abs=0.001)


def test_what_has_no_place_is_dropped_with_what_it_bears_and_told():
    huge = thing(9, "table", (0.0, -4.0, 1.0), (1.4, 2.6, 0.8), TABLE)
    onto = thing(10, "plate", (0.0, -4.0, 1.4), (0.2, 0.2, 0.02), 9)
    blocking = thing(11, "box", (-6.0, -0.2, 0.96), (1.1, 1.3, 0.3), TABLE)
    result = make_feasible(garden(huge, onto, blocking), QUICK)
    assert 9 not in result.scene.object_by_id
    assert 10 not in result.scene.object_by_id
    assert result.report.n_dropped >= 2


def test_a_scene_without_anywhere_to_land_is_rejected():
    result = make_feasible(garden(), FeasibilityCfg(least_landing_areas=1000, is_validated=False))
    assert result.report.rejection is not None
    assert "valid: from 1000" in result.report.rejection


def test_a_layout_of_others_keeps_its_place_and_can_be_flown():
    scene, _ = make_flyable(neutral_layout(house()))
    result = make_feasible(scene)
    assert result.report.rejection is None
    assert result.report.n_dropped == 0
    assert result.report.median_moved_m < 0.01
    # The rooms stand in a yard under open sky; no building is the flight volume.
    assert result.scene.extent_min_enu_m == scene.extent_min_enu_m
    assert result.scene.extent_max_enu_m[:2] == scene.extent_max_enu_m[:2]
    assert result.scene.extent_max_enu_m[2] > scene.extent_max_enu_m[2]
    assert not validate(result.scene)


def test_a_scene_without_a_pad_gets_a_start_wherever_it_was_said_to_be():
    scene = garden()
    kept = tuple(obj for obj in scene.objects if obj.id != HOME)
    bare = replace(scene, objects=kept, start_position_enu_m=(-6.0, 0.0, 0.0))
    result = make_feasible(bare)
    assert result.report.rejection is None
    x, y, _ = result.scene.start_position_enu_m
    assert np.hypot(x + 6.0, y) > 2
    assert not validate(result.scene)


def test_a_scene_with_no_free_place_says_so():
    scene = garden(thing(9, "container", (0.0, 2.5, 1.5), (40.0, 60.0, 3.0)))
    kept = tuple(obj for obj in scene.objects if obj.id in {LAWN, 9})
    rejection = make_feasible(replace(scene, objects=kept), QUICK).report.rejection
    assert rejection is not None
    assert "no free place to start from" in rejection


def test_crowded_ground_grows_within_the_site_alone():
    """A bench in the middle of another makes the lawn a place, never beyond where ground ends."""
    crowd = thing(30, "bench", (-6.2, -5.3, 0.46), (0.6, 1.8, 0.8), LAWN)
    found = make_feasible(garden(crowd), QUICK).scene
    covers = [obj.bbox for obj in found.objects if obj.category in {"lawn", "plaza"}]
    corners = np.concatenate([box.corners()[:, :2] for box in covers])
    assert corners.min(axis=0) == pytest.approx([-15.0, -15.0], abs=0.01)
    assert corners.max(axis=0) == pytest.approx([15.0, 25.0], abs=0.01)


def test_objects_that_hang_above_a_relief_or_stick_in_it_are_set_onto_it():
    hills = load_scene("hills")
    rng = np.random.default_rng(0)

    def moved(obj):
        if obj.category == "landing_pad":
            return obj
        p = (np.array(obj.bbox.p) + rng.normal(0.0, 0.5, 3)).round(3).tolist()
        return replace(obj, bbox=replace(obj.bbox, p=tuple(p)))

    wrong = replace(hills, objects=tuple(moved(obj) for obj in hills.objects), interaction_areas=())
    assert any(finding.kind == "floating" for finding in validate(wrong))
    found = make_feasible(wrong).scene
    assert found is not None
    assert found.relief == hills.relief
    assert validate(found) == ()
    for obj in found.objects:
        lowest_m = found.relief.height_m(*standing_points(obj).T).min()
        assert obj.bbox.p[2] - obj.bbox.s[2] / 2 == pytest.approx(lowest_m, abs=0.02)
