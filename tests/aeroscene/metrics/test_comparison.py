"""All figures together on real scenes: they tell disturbed ones from sound ones."""

import numpy as np
import pytest

from aeroscene.metrics.comparison import Reference, comparison_table
from aeroscene.metrics.damage import jittered
from aeroscene.metrics.discrepancy import TooFewScenesError
from aeroscene.metrics.places.checks import CHECKS
from tests.aeroscene.conftest import sampled_scenes

PLACES = {check.key for check in CHECKS}


@pytest.fixture(scope="module")
def reference():
    return Reference.measure(sampled_scenes(), sampled_scenes())


@pytest.fixture(scope="module")
def rows(reference):
    rng = np.random.default_rng(0)
    groups = {"real": sampled_scenes()} | {
        f"{spread} m": [jittered(scene, rng, spread_m=spread) for scene in sampled_scenes()]
        for spread in (0.1, 0.5, 2.0)
    }
    return {row.key: row for row in comparison_table(groups, reference, rng)}


@pytest.mark.parametrize(
    "key", ["consistency", "astray", "plausibility", "plausibility_place", "mmd"]
)
def test_the_more_scenes_are_disturbed_the_worse_they_are(rows, key):
    values = list(rows[key].values.values())
    assert values == sorted(values)
    assert values[0] < values[2] < values[3]


@pytest.mark.parametrize(
    "key",
    ["collision_rate_without_family", "objects_in_strangers", "colliding_objects_without_family"],
)
def test_disturbed_scenes_collide_and_real_ones_do_not(rows, key):
    real, *disturbed = rows[key].values.values()
    assert all(value > 1.5 * real + 0.02 for value in disturbed)


def test_contents_and_skeletons_are_not_changed_by_disturbing(rows):
    for key in ("category_kl", "cooccurrence_kl", "hierarchy_kl"):
        assert list(rows[key].values.values()) == pytest.approx([0.0] * 4, abs=1e-12)
    assert set(rows["known_skeletons"].values.values()) == {100.0}


def test_disturbed_scenes_are_farther_from_training(rows):
    near = list(rows["training_distance"].values.values())
    assert near[0] == pytest.approx(0.0, abs=1e-9)
    assert near == sorted(near)


def test_every_group_has_every_figure(rows):
    for row in rows.values():
        assert list(row.values) == ["real", "0.1 m", "0.5 m", "2.0 m"]
        # Of places there are figures only where there is something to judge.
        finite = np.isfinite(list(row.values.values()))
        assert finite.all() or row.key in PLACES, row.key
    # Chairs that are 2 m off are at no table any more.
    assert np.isfinite(list(rows["averted_chairs"].values.values())[:3]).all()


def test_a_group_that_is_too_small_is_named(reference):
    with pytest.raises(TooFewScenesError, match="a set of 4 scenes"):
        comparison_table({"few": sampled_scenes()[:4]}, reference, np.random.default_rng(0))
