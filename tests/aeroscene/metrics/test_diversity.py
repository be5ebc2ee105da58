"""Layout distance and category entropy: what they must be whatever the layouts are."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.metrics.diversity import (
    Layout,
    category_entropy_bits,
    layout_distances,
    layout_of,
    mean_nearest_among,
    nearest,
)
from tests.aeroscene.conftest import cached_scene

coordinates = st.floats(-50, 50, allow_nan=False)
things = st.tuples(st.sampled_from("abcd"), coordinates, coordinates, st.floats(0, 20))
layouts = st.lists(things, min_size=2, max_size=12).map(
    lambda rows: Layout(
        "x", tuple(name for name, *_ in rows), np.array([place for _, *place in rows])
    )
)


def moved(layout, turn, shift=(0.0, 0.0, 0.0), scale=1.0):
    flat = layout.centres_m[:, :2] @ np.array(turn, dtype=float).T
    centres = scale * np.column_stack([flat, layout.centres_m[:, 2]]) + shift
    return Layout("moved", layout.categories, centres)


def spread(layout):
    flat = layout.centres_m[:, :2]
    return float(np.linalg.norm(flat - flat.mean(axis=0), axis=1).max())


@given(st.lists(layouts, min_size=2, max_size=3))
@settings(max_examples=30)
def test_distances_are_symmetric_not_negative_and_zero_to_oneself(some):
    distances = layout_distances(some)
    assert np.array_equal(distances, distances.T)
    assert (distances >= 0).all()
    assert not distances.diagonal().any()


@given(
    layouts.filter(lambda layout: spread(layout) > 1.0),
    st.sampled_from([(1, 0, 0, 1), (0, -1, 1, 0), (-1, 0, 0, 1), (0, 1, 1, 0), (0, 1, -1, 0)]),
    st.floats(0.1, 10),
)
@settings(max_examples=40)
def test_a_layout_that_is_turned_mirrored_scaled_and_shifted_is_the_same(layout, turn, scale):
    other = moved(layout, np.reshape(turn, (2, 2)), (30.0, -7.0, 2.0), scale)
    assert layout_distances([layout, other])[0, 1] == pytest.approx(0.0, abs=1e-6)


@given(layouts, layouts)
@settings(max_examples=20)
def test_layouts_with_nothing_in_common_are_a_radius_apart(first, second):
    second = Layout("y", tuple(name.upper() for name in second.categories), second.centres_m)
    assert layout_distances([first, second])[0, 1] == pytest.approx(1.0)


def test_distance_is_the_share_that_moves_times_how_far_it_moves():
    # Corners of a square at one radius from its middle; a chair in the middle of it moves.
    corners = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]) * math.sqrt(6 / 4)
    before = np.vstack([corners, [[0, 0, 0], [0, 0, 0]]])
    names = ("tree",) * 4 + ("chair", "lamp")
    after = before.copy()
    after[4], after[5] = (0.3, 0, 0), (-0.3, 0, 0)
    distance = layout_distances([Layout("a", names, before), Layout("b", names, after)])[0, 1]
    # Two objects of six move 0.3 m in a layout of about one metre radius.
    radius_m = math.sqrt((6 + 2 * 0.09) / 6)
    trees = 4 / 6 * math.sqrt(6 / 4) * (1 - 1 / radius_m)
    assert distance == pytest.approx(2 / 6 * 0.3 / radius_m + trees, rel=0.15)


def test_a_nudge_is_nearer_than_another_scene():
    scene, other = layout_of(cached_scene(42)), layout_of(cached_scene(7))
    rng = np.random.default_rng(0)
    centres = scene.centres_m + rng.normal(0, 0.3, scene.centres_m.shape)
    nudged = Layout("nudged", scene.categories, centres)
    distances = layout_distances([scene, nudged, other])
    assert 0 < distances[0, 1] < 0.05 < 0.3 < distances[0, 2]
    distance, index = nearest(distances)
    assert index.tolist()[:2] == [1, 0]
    assert distance[0] == distances[0, 1]


def test_neighbours_among_fewer_are_farther():
    rng = np.random.default_rng(1)
    names = tuple("abcdefgh") * 2
    some = [Layout(str(n), names, rng.normal(size=(16, 3))) for n in range(30)]
    distances = layout_distances(some)
    whole = nearest(distances)[0].mean()
    few = mean_nearest_among(distances, 5, np.random.default_rng(0))
    assert few > whole
    assert mean_nearest_among(distances, 30, np.random.default_rng(0)) == pytest.approx(whole)


@given(st.integers(1, 40))
def test_entropy_of_equally_many_of_each_is_the_logarithm_of_their_number(count):
    layout = Layout("x", tuple(map(str, range(count))), np.zeros((count, 3)))
    assert category_entropy_bits([layout, layout]) == pytest.approx(math.log2(count))


def test_a_layout_of_one_object_and_one_of_none_have_distances_too():
    one = Layout("one", ("tree",), np.array([[3.0, 4.0, 5.0]]))
    none = Layout("none", (), np.zeros((0, 3)))
    distances = layout_distances([one, one, none])
    assert distances[0, 1] == 0
    assert distances[0, 2] == 1
