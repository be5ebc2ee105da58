"""Objects set onto a relief and back: exactly where they were."""

from dataclasses import replace

import numpy as np
import pytest

from aeroscene.corpus.curation import curate_layout, curate_scene
from aeroscene.feasibility import FeasibilityCfg, make_feasible
from aeroscene.landform import level, on_relief, raise_relief
from aeroscene.learning.paper.layouts import flat_layout
from aeroscene.learning.program import encode
from aeroscene.learning.symmetry import mirrored
from aeroscene.learning.wishes import Wish
from aeroscene.metrics.arrays import scene_arrays
from aeroscene.metrics.damage import DAMAGES
from aeroscene.metrics.diversity import layout_of
from aeroscene.metrics.places.top_view import TopView
from aeroscene.scene import OrientedBox, Relief, SceneObject
from aeroscene.scene.catalogue import category_id
from aeroscene.scene.io import scene_from_json, scene_to_json
from aeroscene.sources import load_scene
from tests.flightsim.handmade import empty_scene, incline

RISEN = (0, 10, 31, 34, 48, 54)


def thing(number, category, p, s, parent=None, **attributes):
    box = OrientedBox(p, (1.0, 0.0, 0.0, 0.0), s)
    named = {"scene_id": "relief", "domain": "outdoor", "attributes": attributes}
    return SceneObject(
        id=number, parent_id=parent, category_id=category_id(category), bbox=box, **named
    )


def garden(*objects):
    named = {"scene_id": "relief", "objects": objects, "start_position_enu_m": (20.0, 0.0, 0.0)}
    return replace(empty_scene(), **named)


@pytest.mark.parametrize("number", RISEN)
def test_a_raised_scene_comes_back_to_where_it_was(number):
    flat = curate_layout(number)
    raised = raise_relief(flat, np.random.default_rng(number))
    assert raised.objects != flat.objects
    again = level(scene_from_json(scene_to_json(raised)))
    for one, two in zip(again.objects, flat.objects, strict=True):
        assert one.bbox.p == pytest.approx(two.bbox.p, abs=1e-9)
    assert again == flat


def test_level_is_the_inverse_in_both_orders_whatever_the_relief():
    hills = load_scene("hills")
    bare = replace(hills, interaction_areas=())
    flat = level(hills)
    assert flat.relief is None
    feet = [obj.bbox.p[2] - obj.bbox.s[2] / 2 for obj in flat.objects]
    assert feet == pytest.approx([0.0] * len(feet), abs=0.35)
    assert on_relief(flat, hills.relief) == bare
    assert level(flat) is flat


def test_a_scene_on_flat_ground_keeps_its_areas():
    scene = curate_scene(7)
    assert level(scene) is scene


def test_an_object_rises_by_the_least_height_below_it_and_carries_what_it_bears():
    scene = garden(
        thing(0, "table", (0.0, 0.0, 0.4), (2.0, 2.0, 0.8)),
        thing(1, "cup", (0.5, 0.0, 0.85), (0.1, 0.1, 0.1), 0),
        thing(2, "tree", (10.0, 0.0, 2.0), (4.0, 4.0, 4.0)),
    )
    raised = on_relief(scene, incline(0.1, 0.0, height_m=4.0))
    rises = [a.bbox.p[2] - b.bbox.p[2] for a, b in zip(raised.objects, scene.objects, strict=True)]
    # The middle is 4 m high; the table reaches 1 m west of it, the trunk of the tree 0.3 m.
    assert rises == pytest.approx([3.9, 3.9, 4.97], abs=1e-6)
    assert raised.start_position_enu_m[2] == pytest.approx(6.0)


def test_an_object_on_a_lawn_rises_from_where_the_land_comes_through_it():
    heights = np.zeros((81, 81))
    heights[41:, 41:] = 0.5
    relief = Relief((-40.0, -40.0), 1.0, heights)
    scene = garden(
        thing(0, "lawn", (0.0, 0.0, 0.1), (30.0, 30.0, 0.2)),
        thing(1, "bench", (8.0, 8.0, 0.6), (0.6, 1.8, 0.8), 0),
        thing(2, "bench", (-8.0, -8.0, 0.6), (0.6, 1.8, 0.8), 0),
        thing(3, "bin", (10.0, 10.0, 0.7), (0.5, 0.5, 1.0)),
    )
    raised = on_relief(scene, relief)
    bottoms = [obj.bbox.p[2] - obj.bbox.s[2] / 2 for obj in raised.objects]
    assert bottoms == pytest.approx([0.0, 0.5, 0.2, 0.5], abs=1e-9)
    assert level(raised) == scene
    settled = make_feasible(replace(raised, objects=(*scene.objects,))).scene
    bottoms = [obj.bbox.p[2] - obj.bbox.s[2] / 2 for obj in settled.objects]
    assert bottoms == pytest.approx([0.0, 0.5, 0.2, 0.5], abs=1e-3)


@pytest.mark.parametrize("number", RISEN[::2])
def test_what_is_learnt_and_measured_is_the_flat_layout(number):
    flat, raised = curate_layout(number), curate_scene(number)
    assert raised.relief is not None
    one, two = encode(flat), encode(raised)
    assert one.program.kinds == two.program.kinds
    np.testing.assert_array_equal(one.program.channels, two.program.channels)
    wish = Wish.from_scene(flat)
    lists = [flat_layout(scene, wish, has_regions=True) for scene in (flat, raised)]
    np.testing.assert_array_equal(lists[0].center_enu_m, lists[1].center_enu_m)
    arrays = [scene_arrays(scene) for scene in (flat, raised)]
    np.testing.assert_array_equal(arrays[0].centre_enu_m, arrays[1].centre_enu_m)
    layouts = [layout_of(scene) for scene in (flat, raised)]
    np.testing.assert_array_equal(layouts[0].centres_m, layouts[1].centres_m)
    assert TopView(flat).units == TopView(raised).units


def test_a_projected_scene_gets_land_where_it_is_asked_for():
    scene = curate_layout(31)
    found = [make_feasible(scene, FeasibilityCfg(land_seed=seed)) for seed in (None, 5, 5)]
    assert [each.report.rejection for each in found] == [None] * 3
    assert found[0].scene.relief is None
    assert found[1].scene.relief is not None
    assert found[1].scene == found[2].scene
    assert level(found[1].scene) == replace(found[0].scene, interaction_areas=())


def test_damage_and_mirror_images_are_of_the_flat_layout():
    raised = curate_scene(31)
    seeded = [
        lambda scene, damage=damage: damage(scene, np.random.default_rng(0))
        for damage in DAMAGES.values()
    ]
    for change in (mirrored, *seeded):
        first, second = change(raised), change(level(raised))
        assert first.relief is None
        assert first == second
