"""Percentiles and edges of blobs, by compiled code as by numpy."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from autonomy.perception.sighting import _BESIDE_PX, _EDGE_PERCENT, _SIDES, between, goes_on

seeds = st.integers(0, 2**32 - 1)


@given(seed=seeds, n=st.integers(1, 200), percent=st.floats(0.0, 100.0))
def test_percentiles_are_those_of_numpy(seed, n, percent):
    values = np.random.default_rng(seed).normal(size=n)
    expected = np.percentile(values, [percent, 100.0 - percent])
    np.testing.assert_allclose(between(values, percent, 100.0 - percent), expected, atol=1e-12)


@given(seed=seeds, side=st.sampled_from(_SIDES))
def test_a_blob_ends_where_most_pixels_beside_its_edge_show_what_is_behind(seed, side):
    rng = np.random.default_rng(seed)
    depth = rng.choice([1.0, 3.0, 8.0, np.inf], size=(24, 32)).astype(np.float32)
    places = np.argwhere(rng.random(depth.shape) < 0.1)
    if not len(places):
        return
    behind = rng.uniform(2.0, 6.0, len(places))
    axis, sign = side
    along = sign * places[:, axis]
    edge = along >= np.percentile(along, 100.0 - _EDGE_PERCENT)
    beside = places[edge].copy()
    beside[:, axis] += sign * _BESIDE_PX
    inside = np.all((beside >= 0) & (beside < depth.shape), axis=1)
    seen = depth[tuple(beside[inside].T)]
    n_behind = np.count_nonzero(~((seen > 0.0) & (seen < behind[edge][inside])))
    assert goes_on(depth, places, behind, *side, _EDGE_PERCENT) == (2 * n_behind < edge.sum())
