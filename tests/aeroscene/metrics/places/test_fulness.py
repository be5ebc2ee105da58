from dataclasses import replace

import pytest

from aeroscene.metrics.places.fulness import (
    built_shares,
    dwelling_fill,
    ordinary_bedrooms,
    work_fill,
)
from aeroscene.metrics.places.top_view import TopView
from tests.aeroscene.metrics.scenes import box, scene_of

GROUND = ("lawn", box((0, 0, 0.05), (40, 50, 0.1)))


def used_as(use, *rows):
    """A room of 5 m by 4 m of some use, and rows whose parent it is."""
    room = ("room", box((0, 0, 1.5), (5, 4, 3)))
    scene = scene_of(room, *rows)
    first = replace(scene.objects[0], attributes={"use": use} if use else {})
    return TopView(replace(scene, objects=(first, *scene.objects[1:])))


def chair(x):
    return ("chair", box((x, 0, 0.5), (0.5, 0.5, 0.9)), 0)


def test_a_room_of_20_m2_with_two_chairs_has_ten_objects_on_100_m2():
    view = used_as("bedroom", chair(-1), chair(1))
    assert dwelling_fill(view).tolist() == pytest.approx([10.0])
    assert work_fill(view).tolist() == []


def test_what_lies_on_furniture_counts_and_coarse_structures_do_not():
    table = ("table", box((0, 0, 0.4), (0.9, 1.6, 0.75)), 0)
    cup = ("cup", box((0, 0, 0.8), (0.08, 0.08, 0.1)), 1)
    stairs = ("stairs", box((1.5, 1, 0.5), (1.0, 1.0, 1.0)), 0)
    assert work_fill(used_as("office", table, cup, stairs)).tolist() == pytest.approx([10.0])


def test_rooms_without_a_use_are_not_judged():
    assert dwelling_fill(used_as(None, chair(0))).tolist() == []
    assert ordinary_bedrooms(used_as(None)).tolist() == []


@pytest.mark.parametrize(
    ("length_m", "is_ordinary"), [(2.0, False), (2.3, True), (6.2, True), (6.4, False)]
)
def test_a_bedroom_is_ordinary_between_9_and_25_m2(length_m, is_ordinary):
    view = used_as("bedroom")
    bedroom = view.scene.objects[0]
    narrow = replace(bedroom, bbox=replace(bedroom.bbox, s=(length_m, 4.0, 3.0)))
    found = ordinary_bedrooms(TopView(replace(view.scene, objects=(narrow,))))
    assert found.tolist() == [is_ordinary]


def town(theme, *rows):
    return built_shares(TopView(replace(scene_of(GROUND, *rows), theme=theme))).tolist()


def test_buildings_cover_their_share_of_a_towns_ground_once():
    house = ("building", box((-10, 0, 5), (20, 25, 10)))
    assert town("urban_block", house) == pytest.approx([0.25])
    tower = ("tower", box((-10, 0, 15), (10, 10, 20)), 1)
    assert town("old_town", house, tower) == pytest.approx([0.25])
    assert town("urban_block") == pytest.approx([0.0])


def test_other_themes_are_not_judged():
    assert town("park", ("building", box((0, 0, 5), (20, 20, 10)))) == []
