import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays as counts_of

from aeroscene.metrics.arrays import scene_arrays
from aeroscene.metrics.frequencies import divergences, frequencies, kl_divergence
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.metrics.scenes import box, scene_of

counts = counts_of(float, 6, elements=st.integers(0, 50).map(float))


@given(counts, counts)
def test_divergence_is_never_negative_and_zero_from_itself(first, second):
    assert kl_divergence(first, second) >= -1e-12
    assert kl_divergence(first, first) == pytest.approx(0.0, abs=1e-12)


def test_divergence_of_large_counts_is_that_of_their_shares():
    p, q = np.array([0.5, 0.5]), np.array([0.25, 0.75])
    exact = float((p * np.log(p / q)).sum())
    assert kl_divergence(1e7 * p, 3e7 * q) == pytest.approx(exact, rel=1e-5)


def test_what_is_missing_costs_much_and_not_everything():
    assert 1.0 < kl_divergence(np.array([100.0, 100.0]), np.array([200.0, 0.0])) < 10.0


def test_pairs_are_counted_once_a_scene_and_children_once_an_object():
    tree, bush = ("tree", box((0, 0, 3), (2, 2, 6))), ("bush", box((5, 0, 1), (1, 1, 1)))
    lawn = ("lawn", box((0, 0, 0.05), (20, 20, 0.1)))
    found = frequencies([scene_arrays(scene_of(lawn, (*tree, 0), (*tree, 0), bush))])
    assert sorted(found.category[found.category > 0]) == [1, 1, 2]
    # Lawn with tree, lawn with bush, tree with bush, tree with tree.
    assert found.cooccurrence.sum() == 4
    # Trees on the lawn; lawn and bush on nothing.
    assert sorted(found.hierarchy[found.hierarchy > 0]) == [1, 1, 2]


def test_other_contents_diverge_and_equal_ones_do_not():
    outdoor, indoor = scene_arrays(cached_scene(7)), scene_arrays(cached_scene(311))
    same = divergences(frequencies([outdoor]), frequencies([outdoor]))
    other = divergences(frequencies([indoor]), frequencies([outdoor]))
    for name in ("category", "cooccurrence", "hierarchy"):
        assert getattr(same, name) == pytest.approx(0.0, abs=1e-12)
        assert getattr(other, name) > 0.3
