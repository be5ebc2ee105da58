import pytest

from aeroscene.metrics.places.stairs import dead_end_stairs
from aeroscene.metrics.places.top_view import TopView
from tests.aeroscene.metrics.scenes import box, scene_of

LAWN = ("lawn", box((0, 0, 0.05), (60, 60, 0.1)))


def stairs(x=0.0, height=1.0, yaw_deg=0.0, base=0.1):
    """Two metres of stairs that rise towards +x."""
    return ("stairs", box((x, 0, base + height / 2), (2, 1.5, height), yaw_deg))


def is_dead_end(*rows):
    return dead_end_stairs(TopView(scene_of(LAWN, *rows))).tolist()


@pytest.mark.parametrize(
    "category", ["terrain", "deck", "floor", "roof", "plaza", "lawn", "container", "building"]
)
def test_stairs_end_at_a_level(category):
    level = (category, box((4, 0, 0.55), (6, 6, 1.1)))
    assert is_dead_end(level, stairs()) == [False]
    assert is_dead_end(level, stairs(x=-0.4)) == [False]
    assert is_dead_end(level, stairs(x=-0.6)) == [True]
    assert is_dead_end(level, stairs(height=0.8)) == [False]
    assert is_dead_end(level, stairs(height=0.7)) == [True]
    assert is_dead_end(level, stairs(height=1.3)) == [True]


def test_stairs_that_are_turned_round_lead_nowhere():
    level = ("deck", box((4, 0, 0.55), (6, 6, 1.1)))
    assert is_dead_end(level, stairs(yaw_deg=180.0)) == [True]
    assert is_dead_end(level, stairs(x=-1.0, yaw_deg=90.0)) == [True]


def test_the_ground_below_is_no_level_that_they_lead_to():
    assert is_dead_end(stairs(height=0.4)) == [True]


def test_the_underside_of_a_room_is_its_floor():
    upstairs = ("room", box((4, 0, 4.6), (6, 6, 3)))
    assert is_dead_end(upstairs, stairs(height=3.0)) == [False]
    assert is_dead_end(upstairs, stairs(height=6.0)) == [True]


def test_the_deck_of_a_bridge_is_below_its_handrail():
    bridge = ("bridge", box((4, 0, 2.65), (6, 2.4, 5.1)))
    assert is_dead_end(bridge, stairs(height=4.0)) == [False]
    assert is_dead_end(bridge, stairs(height=5.1)) == [True]


@pytest.mark.parametrize("category", ["wall", "fence", "water", "tree", "car"])
def test_what_nobody_walks_on_is_no_level(category):
    assert is_dead_end((category, box((4, 0, 0.55), (6, 6, 1.1))), stairs()) == [True]
