"""Land that rises: gentle, in the green and nowhere else, the same every time."""

from collections import Counter
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import shapely

from aeroscene.areas.landing import derive_interaction_areas
from aeroscene.corpus.curation import curate_layout, curate_scene
from aeroscene.landform import raise_relief, standing_points
from aeroscene.landform.land_style import LAND_STYLES
from aeroscene.landform.relief import MOST_GRADIENT
from aeroscene.neighbourhood import NEIGHBOURHOOD_STYLES, RING_M, neighbours_of
from aeroscene.neighbourhood.streets import streets_around
from aeroscene.scene.catalogue import COVERS, LAWNS, LEAFY
from aeroscene.scene.footprint import footprint
from aeroscene.scene.io import scene_from_json, scene_to_json
from aeroscene.solids.shapes import scene_primitives
from aeroscene.solids.solids import colliding
from aeroscene.validation import validate
from aeroscene.validation.boxes import outside, overlaps
from aeroscene.validation.support import floating

LANDS = (0, 1, 4, 9, 15, 18, 25, 30, 31, 34, 36, 39, 42, 43, 45, 48, 51, 54, 57, 58)
"""Outdoor and mixed scenes of all themes that have land."""


@cache
def flat(number):
    return curate_layout(number)


@cache
def raised(number):
    return raise_relief(flat(number), np.random.default_rng(number))


def points_in(outline, spacing_m=0.5):
    x0, y0, x1, y1 = outline.bounds
    x, y = np.meshgrid(np.arange(x0, x1, spacing_m), np.arange(y0, y1, spacing_m))
    inside = np.column_stack([x.ravel(), y.ravel()])[shapely.contains_xy(outline, x, y).ravel()]
    return np.vstack([inside, shapely.get_coordinates(outline)])


def is_on_ground(scene, obj):
    return obj.parent_id is None or scene.object_by_id[obj.parent_id].category in COVERS


@pytest.mark.parametrize("number", LANDS)
def test_nothing_floats_overlaps_or_lies_outside(number):
    scene = raised(number)
    assert scene.relief is not None
    assert [*floating(scene, colliding(scene_primitives(scene)))] == []
    assert [*overlaps(scene)] == []
    assert [*outside(scene)] == []


@pytest.mark.parametrize("number", LANDS)
def test_nothing_sinks_further_than_its_outline_is_wide_on_the_slope(number):
    scene = raised(number)
    for obj in scene.objects:
        if is_on_ground(scene, obj) and obj.category not in LAWNS:
            points = standing_points(obj)
            ground_m = scene.relief.height_m(*points.T)
            wide_m = np.hypot(*np.ptp(points, axis=0))
            foot_m = obj.bbox.p[2] - obj.bbox.s[2] / 2
            assert ground_m.max() - foot_m <= MOST_GRADIENT * wide_m + 0.01, obj


@pytest.mark.parametrize("number", LANDS)
def test_what_is_paved_built_or_under_water_lies_on_level_ground(number):
    scene = raised(number)
    level = [o for o in scene.objects if o.is_coarse and o.category not in LAWNS]
    assert len(level) > 10
    for obj in level:
        assert obj == flat(number).object_by_id[obj.id]
        if not is_on_ground(scene, obj):
            continue  # Eaves may hang over land that rises.
        points = points_in(footprint(obj))
        assert not scene.relief.height_m(*points.T).any(), obj


@pytest.mark.parametrize("number", LANDS[::3])
def test_a_curated_site_with_land_is_sound(number):
    scene = curate_scene(number)
    assert scene.relief is not None
    assert validate(scene) == ()
    assert scene_from_json(scene_to_json(scene)) == scene


def test_land_is_gentle_and_trees_stand_on_it():
    slopes, n_on_land = [], 0
    for number in LANDS:
        scene = raised(number)
        slope = np.hypot(*scene.relief.gradients()).ravel()
        assert slope.max() <= MOST_GRADIENT + 0.02  # Heights are whole centimetres.
        slopes.append(slope[slope > 0.005])
        pairs = zip(scene.objects, flat(number).objects, strict=True)
        n_on_land += sum(a.bbox != b.bbox and a.category in LEAFY for a, b in pairs)
        assert scene.relief.min_m == 0.0
        assert scene.relief.max_m > 0.3
    assert np.median(np.concatenate(slopes)) < 0.08
    assert n_on_land > 30


def test_the_land_follows_the_seed_alone():
    scene, other = (raise_relief(flat(31), np.random.default_rng(seed)) for seed in (31, 32))
    assert scene == raised(31)
    assert other.relief != scene.relief
    assert curate_scene(31) == curate_scene(31)


def test_rooms_old_towns_and_scenes_with_a_relief_stay_as_they_are():
    rng = np.random.default_rng(0)
    for number in (2, 7):
        assert raise_relief(flat(number), rng) is flat(number)
    assert raise_relief(raised(31), rng) is raised(31)
    assert raise_relief(replace(flat(31), theme=""), rng).relief is None


def test_every_theme_around_which_something_stands_has_land_but_old_towns():
    assert set(LAND_STYLES) == set(NEIGHBOURHOOD_STYLES) - {"old_town"}


@pytest.mark.parametrize("number", [31, 34, 54])
def test_streets_go_on_around_the_land_as_before(number):
    streets = [
        [part for part in neighbours_of(scene) if part.material == "asphalt"]
        for scene in (flat(number), raised(number))
    ]
    assert streets[0] == streets[1] != []
    assert len(streets_around(flat(number), RING_M)) > 1


def test_a_street_that_the_land_crosses_is_left_out():
    scene = raised(34)
    relief = replace(scene.relief, heights_m=scene.relief.heights_m + 0.3)
    assert not any(p.material == "asphalt" for p in neighbours_of(replace(scene, relief=relief)))


def test_about_as_many_areas_of_each_class_are_left():
    counts = [Counter(), Counter()]
    for number in LANDS[::2]:
        for count, scene in zip(counts, (flat(number), raised(number)), strict=True):
            areas = derive_interaction_areas(scene)
            count.update(area.drone_class for area in areas if area.kind == "landing")
    for name, n_flat in counts[0].items():
        assert counts[1][name] == pytest.approx(n_flat, rel=0.15), name


def test_a_site_without_any_ground_gets_land_all_over():
    scene = raise_relief(replace(flat(31), objects=()), np.random.default_rng(1))
    assert (scene.relief.heights_m > 0.0).mean() > 0.9
