import pytest

from aeroscene.metrics.places.screens import averted_screens
from aeroscene.metrics.places.top_view import TopView
from aeroscene.scene.catalogue import SCREENS
from tests.aeroscene.metrics.scenes import box, scene_of

DESK = ("desk", box((0, 0, 0.37), (0.8, 1.6, 0.74)))


def chair(x, yaw_deg=180, z=0.45):
    return ("chair", box((x, 0.2, z), (0.5, 0.5, 0.9), yaw_deg))


def screen(category="laptop", yaw_deg=0.0, y=0.5, parent=0):
    return (category, box((0.0, y, 0.85), (0.25, 0.35, 0.22), yaw_deg), parent)


def averted(*rows):
    return averted_screens(TopView(scene_of(*rows))).tolist()


@pytest.mark.parametrize("category", sorted(SCREENS))
@pytest.mark.parametrize(
    ("yaw_deg", "is_averted"), [(0, False), (60, False), (-60, False), (120, True), (180, True)]
)
def test_a_screen_shows_its_picture_to_who_sits_at_the_table(category, yaw_deg, is_averted):
    assert averted(DESK, chair(0.7), screen(category, yaw_deg, y=0.2)) == [is_averted]
    assert averted(DESK, chair(-0.7, 0), screen(category, yaw_deg + 180, y=0.2)) == [is_averted]


def test_the_nearest_chair_counts():
    assert averted(DESK, chair(0.9), chair(-0.7, 0), screen()) == [True]
    assert averted(DESK, chair(0.7), chair(-0.9, 0), screen()) == [False]


def test_without_a_chair_at_the_table_nothing_is_judged():
    assert averted(DESK, screen()) == []
    assert averted(DESK, chair(1.5), screen()) == []
    assert averted(DESK, chair(0.7, z=4.0), screen()) == []
    counter = ("counter", DESK[1])
    assert averted(counter, chair(0.7), screen()) == []
