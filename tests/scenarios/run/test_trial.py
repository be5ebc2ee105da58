"""The verdict: the pilot has to say so, and the truth has to agree."""

from dataclasses import dataclass, replace

import pytest

from scenarios.run.scoring import FlightScore
from scenarios.run.trial import Verdict, judge
from tests.scenarios.landing_scenes import ON_LAWN

LANDED = Verdict(success=True, reason="landed and disarmed")
GOOD = FlightScore(has_flown=True, is_inside_area=True, tilt_at_rest_deg=2.0)


@dataclass
class Flown:
    """A companion whose flight is over."""

    is_done: bool = True
    verdict: Verdict = LANDED
    area: object = ON_LAWN

    def update(self, time_us):
        """Nothing is left to do."""


def test_a_landing_that_pilot_and_truth_call_good_succeeds():
    assert judge(Flown(), GOOD) == LANDED


@pytest.mark.parametrize(
    ("flown", "score", "reason"),
    [
        (Flown(is_done=False, verdict=Verdict(success=True, reason="in navigate")), {}, "in nav"),
        (Flown(verdict=Verdict(success=False, reason="gave up")), {}, "gave up"),
        (Flown(), {"has_flown": False}, "never left the ground"),
        (Flown(), {"contacts_before_touchdown": 2}, "touched something 2 times"),
        (Flown(), {"is_inside_area": False}, "outside the chosen landing area"),
        (Flown(), {"tilt_at_rest_deg": 20.1}, "fell over: 20 degrees"),
    ],
)
def test_each_objection_fails_the_trial_and_is_told(flown, score, reason):
    verdict = judge(flown, replace(GOOD, **score))
    assert not verdict.success
    assert reason in verdict.reason


def test_who_wants_no_area_may_touch_things_and_rest_anywhere():
    score = replace(GOOD, contacts_before_touchdown=3, is_inside_area=False)
    assert judge(Flown(area=None), score).success
