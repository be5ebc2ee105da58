import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.metrics.arrays import scene_arrays
from aeroscene.metrics.damage import jittered
from aeroscene.metrics.neighbours import N_NEIGHBOURS, N_PLACES, neighbours_of
from aeroscene.metrics.semantics import (
    NeighbourFrequencies,
    NeighbourFrequenciesError,
    mean_plausibility,
)
from tests.aeroscene.conftest import SAMPLE, cached_scene
from tests.aeroscene.metrics.scenes import box, moved, scene_of, turned


def beside(name, dx, dy, yaw_deg=0.0):
    return scene_of(
        ("desk", box((5, 5, 0.4), (0.8, 1.6, 0.75), yaw_deg)),
        (name, box((5 + dx, 5 + dy, 0.45), (0.5, 0.5, 0.9), yaw_deg)),
    )


DESKS = NeighbourFrequencies.fit([beside("chair", 0.6, 0.0)] * 40 + [beside("bin", 0.0, 1.2)] * 10)


def test_what_is_usual_is_more_plausible_than_what_is_not():
    usual = DESKS.plausibility(beside("chair", 0.6, 0.0))
    behind = DESKS.plausibility(beside("chair", -0.6, 0.0))
    rarer, never = (DESKS.plausibility(beside(name, 0.6, 0.0)) for name in ("bin", "tree"))
    assert usual.category == behind.category < rarer.category < never.category
    assert usual.place < behind.place
    assert usual.total == usual.category + usual.place


def test_displacement_is_seen_from_the_object():
    usual = DESKS.plausibility(beside("chair", 0.6, 0.0))
    turned_along = DESKS.plausibility(beside("chair", 0.0, 0.6, yaw_deg=90.0))
    turned_away = DESKS.plausibility(beside("chair", 0.6, 0.0, yaw_deg=90.0))
    assert turned_along == usual
    assert turned_away.place > usual.place + 1.0


def test_every_neighbour_and_place_has_a_probability_and_they_add_up():
    desk = scene_arrays(beside("chair", 1, 0)).category[0]
    assert np.exp(DESKS._log_category[desk]).sum() == pytest.approx(1.0)
    assert np.exp(DESKS._log_place[desk]).sum(axis=1) == pytest.approx(1.0)


@given(st.integers(0, 3))
def test_a_scene_as_a_whole_may_be_turned(quarters):
    scene = beside("chair", 0.55, 0.13)
    assert DESKS.plausibility(turned(scene, quarters)).total == pytest.approx(
        DESKS.plausibility(scene).total
    )


def test_neighbours_are_the_nearest():
    scene = cached_scene(42)
    arrays = scene_arrays(scene)
    near = neighbours_of(arrays)
    assert len(near.first) == N_NEIGHBOURS * arrays.n_objects
    assert 0 <= near.place.min() <= near.place.max() < N_PLACES
    row = 17
    apart = [math.dist(obj.bbox.p, scene.objects[row].bbox.p) for obj in scene.objects]
    apart[row] = math.inf
    found = sorted(apart[i] for i in near.second[near.first == row])
    assert found == pytest.approx(sorted(apart)[:N_NEIGHBOURS])


def test_disturbed_scenes_are_less_plausible_the_more_they_are():
    usual = NeighbourFrequencies.fit([cached_scene(i) for i in SAMPLE])
    rng = np.random.default_rng(0)
    totals = [
        mean_plausibility(
            [usual.plausibility(jittered(cached_scene(i), rng, spread_m=spread)) for i in SAMPLE]
        ).total
        for spread in (0.0, 0.1, 0.5, 2.0)
    ]
    assert totals[0] + 0.5 < totals[1] < totals[2] < totals[3]


def test_saved_frequencies_judge_as_before(tmp_path):
    DESKS.save(tmp_path / "neighbours.npz")
    again = NeighbourFrequencies.load(tmp_path / "neighbours.npz")
    assert np.array_equal(again.counts, DESKS.counts)
    scene = moved(beside("chair", 0.6, 0.0), [[0.1, 0.2, 0.0]] * 2)
    assert again.plausibility(scene) == DESKS.plausibility(scene)


def test_a_file_that_holds_no_frequencies_is_named(tmp_path):
    path = tmp_path / "neighbours.npz"
    with pytest.raises(NeighbourFrequenciesError, match=r"neighbours\.npz.*cannot be read"):
        NeighbourFrequencies.load(path)
    path.write_bytes(b"PK\x03\x04 cut short")
    with pytest.raises(NeighbourFrequenciesError, match=r"neighbours\.npz.*cannot be read"):
        NeighbourFrequencies.load(path)
    np.savez(path, version=1, shape=(3, 3, 3), cells=[1], counts=[1])
    with pytest.raises(NeighbourFrequenciesError, match=r"\(3, 3, 3\).*fit it again"):
        NeighbourFrequencies.load(path)


def test_a_scene_of_one_object_has_nothing_implausible():
    assert DESKS.plausibility(scene_of(("tree", box((0, 0, 3), (2, 2, 6))))).total == 0.0
