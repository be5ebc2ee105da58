"""The verdict: each code has its fault, the first fault decides, and the pilot's word does not."""

from dataclasses import replace

import pytest

from scenarios.trials.contacts import Contact
from scenarios.trials.figures import Goal
from scenarios.trials.limits import LIMITS
from scenarios.trials.score import FlightScore
from scenarios.trials.verdict import SUCCESSES, Code, Ending, Verdict, judge
from tests.scenarios.trials.histories import AREA, BESIDE

GOAL = Goal(area=AREA, others=(AREA, BESIDE), navigation_limit_s=30.0)
YES, NO = Verdict(success=True, reason="landed"), Verdict(success=False, reason="nothing safe")
WELL = Ending(word=YES, is_done=True)
GOOD = FlightScore(
    lift_off_s=2.0,
    touchdown_s=20.0,
    landed_area=AREA.id,
    n_soles_inside=4,
    touchdown_error_m=0.04,
    touchdown_speed_mps=0.4,
    slide_m=0.02,
    tilt_at_rest_deg=2.0,
    is_at_rest=True,
    stopped_after_s=1.0,
    nearest_mover_m=2.0,
)
HOME = replace(GOOD, landed_area=None, n_soles_inside=0)
GATE = Contact(
    time_s=9.0,
    until_s=9.1,
    what="object 7 (gate)",
    object_id=7,
    position_enu_m=(1, 2, 3),
    speed_mps=4.0,
)


def test_a_landing_within_all_limits_succeeds_whatever_the_pilot_says():
    for word in (YES, NO):
        found = judge(GOOD, GOAL, Ending(word=word, is_done=True))
        assert found.success is True
        assert found.code is Code.LANDED
        assert found.reason == "landed on area 3, 0.04 m from the chosen point"


def test_a_flight_that_failed_says_why_the_pilot_gave_up():
    off = replace(GOOD, touchdown_error_m=0.8)
    found = judge(off, GOAL, Ending(word=NO, is_done=True))
    assert found.code is Code.OFF_TARGET
    assert found.reason.endswith("; the pilot gave up: nothing safe")
    assert "gave up" not in judge(off, GOAL, WELL).reason


FAULTS = [
    (GOOD, Ending(word=NO, is_done=False, stopped_by="SIGTERM"), Code.STOPPED, "SIGTERM: nothing"),
    (FlightScore(), Ending(word=NO, is_done=True), Code.NEVER_FLEW, "never left the ground: noth"),
    (FlightScore(), WELL, Code.NEVER_FLEW, "never left the ground"),
    (
        replace(GOOD, contacts_before_touchdown=1, touched_before=(GATE,), tilt_at_rest_deg=90.0),
        WELL,
        Code.CONTACT,
        "touched object 7 (gate) at 9.0 s and 4.0 m/s before touchdown",
    ),
    (replace(GOOD, nearest_mover_m=0.29), WELL, Code.NEAR_MISS, "came within 0.29 m"),
    (replace(GOOD, tilt_at_rest_deg=20.1), WELL, Code.FELL_OVER, "fell over: 20 degrees"),
    (HOME, Ending(word=NO, is_done=False), Code.TIME_UP, "the time was up: nothing safe"),
    (HOME, Ending(word=NO, is_done=True), Code.GAVE_UP, "nothing safe"),
    (
        replace(HOME, landed_area=BESIDE.id),
        WELL,
        Code.ALTERNATE,
        "landed on area 4 instead of 3",
    ),
    (replace(HOME, n_soles_inside=3), WELL, Code.OUTSIDE_AREA, "3 of 4 soles inside"),
    (replace(GOOD, is_at_rest=False), WELL, Code.MOVING, "still moves"),
    (replace(GOOD, stopped_after_s=None), WELL, Code.ROTORS_TURN, "rotors still turn"),
    (replace(GOOD, rotor_spin_ups=2), WELL, Code.SPUN_UP, "again 2 times"),
    (replace(GOOD, touchdown_speed_mps=1.01), WELL, Code.HARD_TOUCHDOWN, "down at 1.01 m/s"),
    (replace(GOOD, slide_m=0.31), WELL, Code.SLID, "slid 0.31 m after the touchdown; at most 0.3"),
    (replace(GOOD, touchdown_error_m=0.51), WELL, Code.OFF_TARGET, "0.51 m from the chosen"),
    (
        replace(GOOD, reached_s=(GOOD.lift_off_s or 0.0) + 30.1),
        WELL,
        Code.TOO_SLOW,
        "came above its area after 30.1 s; at most 30.0 s are allowed",
    ),
]


@pytest.mark.parametrize(("score", "ending", "code", "reason"), FAULTS)
def test_each_fault_fails_the_flight_by_its_code(score, ending, code, reason):
    found = judge(score, GOAL, ending)
    assert found.success is False
    assert found.code is code
    assert reason in found.reason


def test_every_code_of_a_failure_has_its_fault():
    assert {code for _, _, code, _ in FAULTS} == set(Code) - SUCCESSES - {Code.ENDED}


@pytest.mark.parametrize(
    "figure", ["touchdown_speed_mps", "slide_m", "touchdown_error_m", "tilt_deg", "mover_m"]
)
def test_a_figure_at_its_limit_is_good(figure):
    name = {"tilt_deg": "tilt_at_rest_deg", "mover_m": "nearest_mover_m"}.get(figure, figure)
    score = replace(GOOD, **{name: getattr(LIMITS, figure)})
    assert judge(score, GOAL, WELL).code is Code.LANDED


def test_a_way_may_take_as_long_as_one_likes_where_nobody_races():
    slow = replace(GOOD, reached_s=(GOOD.lift_off_s or 0.0) + 30.1)
    assert judge(slow, replace(GOAL, navigation_limit_s=None), WELL).code is Code.LANDED


def test_the_first_fault_decides():
    score = replace(GOOD, contacts_before_touchdown=1, slide_m=2.0, is_at_rest=False)
    assert judge(score, GOAL, WELL).code is Code.CONTACT


def test_a_signal_after_the_pilot_was_done_changes_nothing():
    stopped = replace(WELL, stopped_by="SIGINT")
    assert judge(GOOD, GOAL, stopped).code is Code.LANDED


def test_a_landing_counts_though_the_pilot_never_noticed():
    assert judge(GOOD, GOAL, Ending(word=NO, is_done=False)).code is Code.LANDED
    turning = replace(GOOD, stopped_after_s=None)
    assert judge(turning, GOAL, Ending(word=NO, is_done=False)).code is Code.ROTORS_TURN


def test_who_wants_no_area_may_touch_things_and_rest_anywhere():
    score = replace(HOME, contacts_before_touchdown=3, touchdown_error_m=None)
    assert judge(score, Goal(), WELL).code is Code.DONE
    assert judge(score, Goal(), Ending(word=NO, is_done=True)).code is Code.GAVE_UP
    assert judge(score, Goal(), Ending(word=YES, is_done=False)).code is Code.TIME_UP
    assert judge(replace(score, tilt_at_rest_deg=90.0), Goal(), WELL).code is Code.FELL_OVER
