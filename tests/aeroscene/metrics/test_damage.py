"""Scenes damaged in known order: the figures see it, in that order."""

from dataclasses import replace

import numpy as np
import pytest

from aeroscene.metrics.damage import DAMAGES, with_chairs_turned
from aeroscene.metrics.discrepancy import TooFewScenesError
from aeroscene.metrics.intervals import Figure
from aeroscene.metrics.scorecard import METRICS, Yardstick, layout_figures
from tests.aeroscene.conftest import cached_scene, sampled_scenes

JITTERS = ("jitter_0.1", "jitter_0.3", "jitter_1")


@pytest.fixture(scope="module")
def figures() -> dict[str, dict[str, Figure]]:
    yardstick = Yardstick.from_scenes(sampled_scenes())
    groups = {"none": sampled_scenes()}
    for name, damage in DAMAGES.items():
        groups[name] = [
            damage(scene, np.random.default_rng(i)) for i, scene in enumerate(sampled_scenes())
        ]
    return {
        name: layout_figures(scenes, yardstick, np.random.default_rng(0))
        for name, scenes in groups.items()
    }


@pytest.mark.parametrize("metric", ["SP", "OP", "CFC", "objects_in_strangers", "mmd"])
def test_figures_rise_with_the_jitter(figures, metric):
    values = [figures[name][metric].value for name in ("none", *JITTERS)]
    assert values == sorted(values)
    assert values[-1] > values[0]


def test_orientation_plausibility_sees_turned_chairs_and_semantic_plausibility_hardly(figures):
    real, turned = figures["none"], figures["chairs_turned"]
    n_chairs = sum(obj.category == "chair" for scene in sampled_scenes() for obj in scene.objects)
    n_objects = sum(len(scene.objects) for scene in sampled_scenes())
    rise = {key: turned[key].value - real[key].value for key in ("SP", "OP")}
    # Half of the chairs, each as surprising as a guess among 64 turns at the least.
    assert rise["OP"] > 0.25 * n_chairs / n_objects * np.log(64)
    assert rise["OP"] > 1.5 * rise["SP"]
    assert turned["averted_chairs"].value > 30 > real["averted_chairs"].value


def test_random_headings_are_worse_than_some_turned_chairs(figures):
    order = [figures[name]["OP"].value for name in ("none", "chairs_turned", "random_yaw")]
    assert order == sorted(order)
    assert figures["random_yaw"]["category_kl"].value == pytest.approx(0.0, abs=1e-12)


def test_exchanged_categories_are_implausible_and_leave_the_boxes(figures):
    real, shuffled = figures["none"], figures["shuffled_categories"]
    assert shuffled["SP"].value > real["SP"].value + 1
    assert shuffled["colliding_objects"].value >= real["colliding_objects"].value
    assert shuffled["objects"] == real["objects"]


def test_every_figure_has_an_interval_about_it(figures):
    for group in figures.values():
        assert list(group) != []
        assert set(group) == set(METRICS)
        for figure in group.values():
            if figure.n:
                assert figure.low - 1e-9 <= figure.value <= figure.high + 1e-9


def test_half_of_the_chairs_are_turned_and_nothing_else_changes():
    scene = cached_scene(311)
    turned = with_chairs_turned(scene, np.random.default_rng(0))
    changed = [
        after.category
        for before, after in zip(scene.objects, turned.objects, strict=True)
        if before.bbox != after.bbox
    ]
    n_chairs = sum(obj.category == "chair" for obj in scene.objects)
    assert n_chairs >= 4
    assert changed == ["chair"] * round(n_chairs / 2)


def test_scenes_of_one_object_are_not_judged_best():
    alone = [
        replace(scene, objects=scene.objects[:1], interaction_areas=())
        for scene in sampled_scenes()
    ]
    found = layout_figures(alone, Yardstick.from_scenes(sampled_scenes()), np.random.default_rng(0))
    assert all(np.isnan(found[key].value) for key in ("CR", "SP", "OP", "CFC"))
    assert found["category_kl"].value > 0.5


def test_too_few_scenes_are_refused_with_the_number_that_would_do():
    with pytest.raises(TooFewScenesError, match="4 scenes; valid: 5 or more"):
        Yardstick.from_scenes(sampled_scenes()[:4])
