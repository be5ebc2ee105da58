from __future__ import annotations

import numpy as np
import pytest

from aeroscene.feasibility import FeasibilityCfg, make_feasible
from aeroscene.feasibility.boxes import boxes_of, forbidden_overlaps, strangers
from aeroscene.feasibility.layout import layout_of
from aeroscene.feasibility.tiling import fill_buildings, hold_children, make_room
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.feasibility.scenes import BENCH, LAWN, PLAZA, garden, row_of, thing

ROOMS = (20, 21)
NO_AIR = strangers(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))


def house():
    """A house of 10 m by 20 m with two rooms of 4 m by 4 m, a wall between them, and a chair."""
    return garden(
        thing(19, "house", (60.0, 0.0, 2.0), (10.0, 20.0, 4.0)),
        thing(ROOMS[0], "room", (60.0, -4.0, 1.7), (4.0, 4.0, 3.0), 19),
        thing(ROOMS[1], "room", (60.0, 4.0, 1.7), (4.0, 4.0, 3.0), 19),
        thing(22, "wall", (60.0, 1.0, 1.7), (0.12, 9.0, 3.0), 19, np.pi / 2),
    )


@pytest.mark.parametrize("index", [7, 42, 311])
def test_scenes_of_the_corpus_have_no_gaps_to_fill(index):
    layout = layout_of(cached_scene(index))
    before = layout.boxes.copy()
    hold_children(layout)
    fill_buildings(layout)
    make_room(layout, np.ones(len(before), dtype=bool), NO_AIR)
    np.testing.assert_array_equal(layout.boxes.half_m, before.half_m)
    np.testing.assert_array_equal(layout.boxes.centre_m, before.centre_m)


def test_rooms_reach_the_walls_and_the_shell_and_nothing_more():
    layout = layout_of(house())
    fill_buildings(layout)
    boxes = layout.boxes
    first, second = (row_of(layout, number) for number in ROOMS)
    shell = row_of(layout, 19)
    covered = boxes.half_m[[first, second], :2].prod(axis=1).sum() / boxes.half_m[shell, :2].prod()
    assert covered > 0.9
    corners = boxes.corners()[[first, second]] - boxes.centre_m[shell, :2]
    assert (np.abs(corners) < boxes.half_m[shell, :2]).all()
    assert not len(forbidden_overlaps(boxes, 0.0).pairs)


def test_ground_reaches_under_a_child_beside_it_unless_something_is_in_between():
    beside = thing(BENCH, "bench", (-16.0, -5.0, 0.46), (0.6, 1.8, 0.8), LAWN)
    layout = layout_of(garden(beside))
    hold_children(layout)
    low = layout.boxes.corners()[row_of(layout, LAWN)].min(axis=0)
    assert low[0] < -16.3
    assert low[1] == pytest.approx(-15.0)
    hemmed = thing(9, "plaza", (-17.0, 0.0, 0.05), (4.0, 30.0, 0.1))
    layout = layout_of(garden(beside, hemmed))
    hold_children(layout)
    assert layout.boxes.half_m[row_of(layout, LAWN), 0] == pytest.approx(15.0)


def test_crowded_ground_grows_and_other_ground_stays():
    crowd = [thing(30 + k, "planter", (0.0, 0.1 * k, 0.4), (2.0, 2.0, 0.7), LAWN) for k in range(3)]
    wide = thing(PLAZA, "plaza", (0.0, 20.0, 0.05), (40.0, 10.0, 0.1))
    layout = layout_of(garden(wide, *crowd))
    make_room(layout, np.ones(len(layout.objects), dtype=bool), NO_AIR)
    assert layout.boxes.half_m[row_of(layout, LAWN), 0] > 16.0
    assert layout.boxes.half_m[row_of(layout, PLAZA), 0] == pytest.approx(20.0)


def test_fine_objects_end_upon_a_surface_and_within_it():
    strays = [
        thing(40 + k, "bush", (x, y, 0.5), (0.8, 0.8, 0.9), LAWN)
        for k, (x, y) in enumerate([(-17.5, 3.0), (3.0, -18.5), (2.0, 19.0), (17.0, 27.0)])
    ]
    scene = make_feasible(garden(*strays), FeasibilityCfg(is_validated=False)).scene
    for stray in strays:
        obj = scene.object_by_id[stray.id]
        assert obj.parent_id is not None
        parent = scene.object_by_id[obj.parent_id].bbox
        beside = np.abs(np.array(obj.bbox.p[:2]) - parent.p[:2]) - np.array(parent.s[:2]) / 2
        assert beside.max() <= 0.01
    assert not len(forbidden_overlaps(boxes_of(scene.objects), 0.0015).pairs)
