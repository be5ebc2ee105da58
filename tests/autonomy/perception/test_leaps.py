"""One doubtful image does not move the map; two that agree do."""

import numpy as np
import pytest

from autonomy.perception.map_anchor import MapAnchor
from tests.autonomy.perception.test_map_anchor import YARD, matcher, seen

RIGHT = (0.0, 0.0, 0.0)
ELSEWHERE = (0.6, -0.45, 0.0)


@pytest.fixture
def anchor():
    """An anchor that knows the offset well, though the estimate claims no more than metres."""
    settled = MapAnchor(matcher(YARD))
    settled.claim(1.8)
    for n in range(6):
        settled.update(0.2 * n, seen(YARD, RIGHT))
    assert settled.sigma_m < 0.1
    return settled


def off_m(anchor, error):
    return float(np.abs(np.add(anchor.fix.offset_enu_m, error)).max())


def test_a_place_that_one_image_alone_shows_is_not_believed(anchor):
    sigma_m = anchor.sigma_m
    fix = anchor.update(1.2, seen(YARD, ELSEWHERE))
    assert (fix.accepted, fix.reason) == (False, "another place, by one image alone")
    assert off_m(anchor, RIGHT) < 0.05
    assert anchor.sigma_m < sigma_m + 0.05
    for n in range(3):
        assert anchor.update(1.4 + 0.2 * n, seen(YARD, RIGHT)).accepted
        assert off_m(anchor, RIGHT) < 0.05
    assert not anchor.update(2.0, seen(YARD, ELSEWHERE)).accepted


def test_an_estimate_that_jumped_is_believed_from_the_second_image_on(anchor):
    anchor.update(1.2, seen(YARD, ELSEWHERE))
    assert anchor.update(1.4, seen(YARD, ELSEWHERE)).accepted
    assert off_m(anchor, ELSEWHERE) < 0.1


def test_a_bare_floor_between_two_images_tells_nothing_of_the_place(anchor):
    far = (25.0, 25.0, 5.0)
    anchor.update(1.2, seen(YARD, ELSEWHERE))
    anchor.update(1.3, seen(YARD, ELSEWHERE, eye=far))
    assert anchor.update(1.4, seen(YARD, ELSEWHERE)).accepted


def test_two_images_far_apart_confirm_nothing(anchor):
    anchor.update(1.2, seen(YARD, ELSEWHERE))
    assert not anchor.update(4.0, seen(YARD, ELSEWHERE)).accepted
