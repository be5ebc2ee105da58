"""Grades order trials: failures by how near they came, successes by their pace."""

import numpy as np
import pytest

from scenarios.trials.grade import grade, progress

FAST = {"success": True, "navigation_s": 4.0, "least_navigation_s": 2.0}
SLOW = {"success": True, "navigation_s": 20.0, "least_navigation_s": 2.0}
NEAR = {"success": False, "progress": 1.0, "fate": "safe_down"}
CRASHED_NEAR = {"success": False, "progress": 1.0, "fate": "collided"}
SAFE_HALF_WAY = {"success": False, "progress": 0.5, "fate": "safe_down"}
NO_PLAN = {"success": False}


def test_trials_are_ordered_from_a_fast_landing_to_no_flight():
    rows = (FAST, SLOW, NEAR, SAFE_HALF_WAY, CRASHED_NEAR, NO_PLAN)
    grades = [grade(row) for row in rows]
    assert grades == sorted(grades, reverse=True)
    assert len(set(grades)) == len(grades)
    assert grades == pytest.approx([0.85, 0.73, 0.5, 0.35, 0.3, 0.0])


def test_the_worst_success_is_worth_more_than_the_best_failure():
    worst = grade({"success": True})
    assert worst is not None
    assert worst > (grade(NEAR) or 0.0)


def test_what_was_not_judged_has_no_grade():
    assert grade({"success": None}) is None


def test_progress_is_the_share_of_the_way_at_the_nearest_point():
    area = np.array([10.0, 0.0, 0.0])
    way = np.array([[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    assert progress(way, area, has_reached=False) == pytest.approx(0.6)
    assert progress(way, area, has_reached=True) == 1.0
    assert progress(way[:1], area, has_reached=False) == 0.0
    assert progress(way[:0], area, has_reached=False) == 0.0
