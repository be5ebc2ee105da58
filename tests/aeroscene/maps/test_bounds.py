from __future__ import annotations

import math

import pytest

from aeroscene.maps.bounds import MAX_SIDE_M, middle_of, parse_bounds
from aeroscene.scene import SceneError
from tests.aeroscene.maps.samples import bounds_text


def test_bounds_are_read_with_their_middle_and_size():
    bounds = parse_bounds(bounds_text(100, 75))
    assert bounds.size_m == pytest.approx((200, 150), abs=0.01)
    assert (bounds.longitude_deg, bounds.latitude_deg) == pytest.approx((18, 55), abs=1e-6)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "1,2,3",
        "1,2,3,4,5",
        "a,b,c,d",
        "2,1,1,2",
        "1,2,2,1",
        "nan,1,2,2",
        "1,1,inf,2",
        "181,1,182,2",
    ],
)
def test_what_is_no_rectangle_is_refused_with_an_example(text):
    with pytest.raises(SceneError, match=r"bounds are '.*'; valid: W,S,E,N in degrees"):
        parse_bounds(text)


def test_bounds_beyond_the_largest_place_are_refused_with_ones_that_fit():
    with pytest.raises(SceneError, match="bounds are 1000 x 150 m; valid: 20 to 400 m") as caught:
        parse_bounds(bounds_text(500, 75))
    suggested = str(caught.value).rpartition("such as ")[2]
    assert max(parse_bounds(suggested).size_m) < MAX_SIDE_M


def test_the_square_in_the_middle_has_the_length_that_is_asked_for():
    square = middle_of(parse_bounds(bounds_text(190, 190)), 100.0)
    assert all(math.isclose(side, 100.0, abs_tol=2.0) for side in square.size_m)
