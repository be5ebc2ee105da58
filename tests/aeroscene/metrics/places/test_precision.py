import pytest

from aeroscene.metrics.places.precision import narrow_gaps, whole_centimetres
from aeroscene.metrics.places.top_view import TopView
from tests.aeroscene.metrics.scenes import box, scene_of

ROOM = ("room", box((0, 0, 1.5), (9, 9, 3)))


def chair(x, width_m=0.5, z=0.45):
    return ("chair", box((x, 0, z), (width_m, 0.5, 0.9)), 0)


@pytest.mark.parametrize(
    ("width_m", "is_whole"), [(0.5, True), (0.51, True), (0.505, False), (0.5137, False)]
)
def test_decimals_beyond_centimetres_are_seen(width_m, is_whole):
    assert whole_centimetres(TopView(scene_of(ROOM, chair(0, width_m)))).tolist() == [is_whole]


def test_the_rounding_of_files_is_no_decimal():
    assert whole_centimetres(TopView(scene_of(ROOM, chair(0, 0.50005)))).tolist() == [True]


@pytest.mark.parametrize(
    ("gap_m", "is_narrow"), [(0.0, False), (0.003, True), (0.0049, True), (0.03, False)]
)
def test_a_gap_of_millimetres_is_narrow_and_contact_is_none(gap_m, is_narrow):
    view = TopView(scene_of(ROOM, chair(0), chair(0.5 + gap_m)))
    assert narrow_gaps(view).tolist() == [is_narrow, is_narrow]


def test_one_above_the_other_leaves_no_gap():
    assert not narrow_gaps(TopView(scene_of(ROOM, chair(0), chair(0.503, z=1.5)))).any()


def test_things_of_different_parents_are_not_compared():
    other = ("room", box((0, 0, 4.5), (9, 9, 3)))
    elsewhere = ("chair", box((0.503, 0, 0.45), (0.5, 0.5, 0.9)), 1)
    assert not narrow_gaps(TopView(scene_of(ROOM, other, chair(0), elsewhere))).any()
