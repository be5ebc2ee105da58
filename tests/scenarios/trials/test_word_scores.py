"""Scores of flights to goals in words: distances to the place, and the length of the way."""

from dataclasses import replace

import numpy as np
import pytest

from aeroscene.corpus.field import field_scene
from scenarios.trials.word_scores import nearest_area, score_words, spl

PAD = field_scene().interaction_areas[0]
X, Y, Z = PAD.centroid
HALF_M = PAD.radius
AWAY = replace(
    PAD,
    id=7,
    polygon=tuple((x + 40.0, y, z) for x, y, z in PAD.polygon),
    centroid=(X + 40.0, Y, Z),
)


def test_errors_count_from_the_border_of_the_nearest_area():
    flown = np.array([[X - 10, Y, Z], [X, Y, Z + 2], [X + 40 - HALF_M - 3, Y, Z]])
    one, both = score_words(flown, [PAD]), score_words(flown, [PAD, AWAY])
    assert one.navigation_error_m == pytest.approx(40 - 2 * HALF_M - 3)
    assert both.navigation_error_m == pytest.approx(3.0)
    assert one.oracle_error_m == pytest.approx(2.0)
    assert one.path_m == pytest.approx(np.linalg.norm(np.diff(flown, axis=0), axis=1).sum())
    assert nearest_area(flown[-1], [PAD, AWAY]) is AWAY


def test_height_counts():
    flown = np.array([[X, Y, Z], [X, Y, Z + 6.0]])
    assert score_words(flown, [PAD]).navigation_error_m == pytest.approx(6.0)


def test_without_a_flight_there_are_no_scores():
    assert score_words(np.empty((0, 3)), [PAD]).navigation_error_m is None


@pytest.mark.parametrize(
    ("success", "way_m", "path_m", "weight"),
    [(True, 10.0, 20.0, 0.5), (True, 10.0, 8.0, 1.0), (False, 10.0, 10.0, 0.0)],
)
def test_success_is_weighted_by_the_length_of_the_way(success, way_m, path_m, weight):
    assert spl(success=success, way_m=way_m, path_m=path_m) == pytest.approx(weight)
