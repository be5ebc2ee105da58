"""Trust in the position: what rests on nothing is told from odometry and from a poor receiver."""

import math
from itertools import pairwise

import pytest

from scenarios.pilot.trust import Trust

PERIOD_US = 200_000
LOST_M = (0.05, 0.06, 0.07, 0.10, 0.12, 0.17, 0.20, 0.27, 0.32, 0.40, 0.46, 0.55, 0.61, 0.73)
"""Deviation each half second after satellites and odometry were lost in scene 42."""


def adrift_at_s(sigma_m, seconds):
    """Times at which a course of claims is taken for one without any position."""
    trust, found = Trust(), []
    for n in range(round(seconds * 1e6) // PERIOD_US):
        trust.update(n * PERIOD_US, sigma_m(n * PERIOD_US * 1e-6))
        if trust.is_adrift:
            found.append(n * PERIOD_US * 1e-6)
    return found


def lost(time_s):
    at = min(max(time_s, 0.0) / 0.5, len(LOST_M) - 1.001)
    low, share = int(at), at % 1.0
    return LOST_M[low] + share * (LOST_M[low + 1] - LOST_M[low])


def test_without_satellites_and_odometry_the_position_is_adrift_within_five_seconds():
    found = adrift_at_s(lost, 6.5)
    assert 2.0 < found[0] < 5.0
    assert len(found) > 10, "it stays so"
    assert max(b - a for a, b in pairwise(found)) < 0.3


def test_a_position_that_is_measured_again_is_trusted_again():
    found = adrift_at_s(lambda t: lost(t) if t < 6.0 else 0.1, 10.0)
    assert found
    assert found[-1] < 6.1


@pytest.mark.parametrize(
    "sigma_m",
    [
        lambda t: math.hypot(0.04, 0.025 * math.sqrt(2.0 * 6.5 * t)),
        lambda t: 0.05 if t < 5.0 else 0.5,
        lambda t: min(0.06 + 0.4 * max(t - 5.0, 0.0), 0.36),
        lambda t: 1.8 + 0.1 * math.sin(0.1 * t),
        lambda _: math.nan,
    ],
    ids=["odometry", "a step", "ambiguous", "a poor receiver", "nothing told"],
)
def test_what_odometry_and_receivers_claim_is_no_reason_for_distrust(sigma_m):
    assert not adrift_at_s(sigma_m, 20.0)
