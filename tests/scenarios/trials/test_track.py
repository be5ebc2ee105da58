"""Tracks: few points, and the way between them no farther off than said."""

import itertools
import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from scenarios.trials.measures.track import simplified, track_of


@given(st.integers(0, 2**32 - 1), st.integers(1, 30))
def test_every_point_is_near_the_simplified_way(seed, n):
    points = np.cumsum(np.random.default_rng(seed).normal(0.0, 0.1, (n, 3)), axis=0)
    kept = simplified(points, 0.2)
    assert len(kept) <= n
    assert (kept[0] == points[0]).all()
    assert (kept[-1] == points[-1]).all()
    assert all((point == points).all(axis=1).any() for point in kept)
    for point in points:
        away_m = [_away_m(point, a, b) for a, b in itertools.pairwise(kept)]
        assert min(away_m, default=0.0) <= 0.2 + 1e-9


def _away_m(point, a, b):
    # Along a fine line of points: no shared arithmetic with what is tested.
    line = a + np.linspace(0.0, 1.0, 201)[:, None] * (b - a)
    return np.linalg.norm(line - point, axis=1).min() - np.linalg.norm(b - a) / 400


@given(st.integers(0, 2**32 - 1))
def test_a_flat_way_is_simplified_as_another_library_does(seed):
    points = np.cumsum(np.random.default_rng(seed).normal(0.0, 1.0, (40, 3)), axis=0)
    points[:, 2] = 3.0
    theirs = shapely.LineString(points[:, :2]).simplify(0.5, preserve_topology=False)
    assert simplified(points, 0.5)[:, :2] == pytest.approx(np.array(theirs.coords))


def test_a_line_there_and_back_keeps_its_turn():
    way = [[x, 0.0, 1.0] for x in (0.0, 1.0, 2.0, 3.004, 2.0, 1.0, 0.5)]
    assert track_of(way) == [[0.0, 0.0, 1.0], [3.0, 0.0, 1.0], [0.5, 0.0, 1.0]]


@pytest.mark.parametrize("way", [[1.0, 2.0, 3.0], [[1.0, 2.0]], [[0.0, 0.0, math.nan]]])
def test_what_is_no_way_is_refused(way):
    with pytest.raises(ValueError, match=r"valid: finite, shape \(n, 3\)"):
        track_of(way)
