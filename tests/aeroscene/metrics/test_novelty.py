from dataclasses import replace

import numpy as np

from aeroscene.metrics.arrays import scene_arrays
from aeroscene.metrics.damage import jittered
from aeroscene.metrics.diversity import layout_distances, layout_of, sketches_of
from aeroscene.metrics.novelty import KnownSkeletons, nearness, training_distances
from tests.aeroscene.conftest import sampled_scenes
from tests.aeroscene.metrics.scenes import box, scene_of, turned


def sketches(scenes):
    return sketches_of([layout_of(scene) for scene in scenes])


def test_a_copy_is_found_however_it_is_turned():
    training = sketches(sampled_scenes())
    copies = [turned(scene, 1 + number % 3) for number, scene in enumerate(sampled_scenes())]
    assert training_distances(sketches(copies), training).max() < 1e-9


def test_distances_between_sets_are_those_within_their_union():
    some = [layout_of(scene) for scene in sampled_scenes()]
    whole = layout_distances(some)
    found = training_distances(sketches_of(some[:2]), sketches_of(some[2:]))
    assert np.allclose(found, whole[:2, 2:].min(axis=1))


def test_a_nearly_copied_scene_is_nearer_than_any_of_the_test_split():
    rng = np.random.default_rng(0)
    training, tested = sketches(sampled_scenes()[:3]), sketches(sampled_scenes()[3:])
    tests = training_distances(tested, training)
    copies = training_distances(
        sketches([jittered(sampled_scenes()[0], rng, spread_m=0.3)]), training
    )
    assert nearness(copies, tests).copied_share == 1.0
    assert nearness(tests, tests).copied_share == 0.0
    assert nearness(copies, tests).median < 0.9 * nearness(tests, tests).median


TREE, BUSH = ("tree", box((0, 0, 3), (2, 2, 6))), ("bush", box((5, 0, 1), (1, 1, 1)))
LAWN = ("lawn", box((0, 0, 0.05), (20, 20, 0.1)))
PARK = scene_of(LAWN, (*TREE, 0), (*BUSH, 0), BUSH)


def recurrence(scene):
    return KnownSkeletons.from_scenes([scene_arrays(PARK)]).recurrence([scene_arrays(scene)])


def test_a_skeleton_is_known_whatever_the_order_of_siblings_and_the_places():
    shuffled = scene_of(BUSH, LAWN, (*BUSH, 1), ("tree", box((9, 9, 2), (1, 1, 4)), 1))
    known = recurrence(shuffled)
    assert (known.content, known.tree, known.coarse_tree) == (1.0, 1.0, 1.0)


def test_the_same_things_on_other_parents_are_another_skeleton():
    known = recurrence(scene_of(LAWN, TREE, (*BUSH, 0), (*BUSH, 0)))
    assert (known.content, known.tree, known.coarse_tree) == (1.0, 0.0, 1.0)


def test_another_number_of_things_is_another_content():
    fewer = replace(PARK, objects=PARK.objects[:-1])
    assert recurrence(fewer).content == recurrence(fewer).tree == 0.0
