from dataclasses import replace

import pytest

from aeroscene.metrics.places.top_view import TopView
from aeroscene.metrics.places.walls import closed_shares, loose_wall_ends
from tests.aeroscene.metrics.scenes import box, scene_of

HOUSE = ("house", box((0, 0, 1.5), (10, 8, 3)))
"""Its outer walls are 0.25 m thick: inside it reaches from -4.75 to 4.75 and from -3.75 to 3.75."""


def wall(x, y, length, yaw_deg=0.0, z=1.5, parent=0, height=3.0):
    """A wall along north, turned."""
    return ("wall", box((x, y, z), (0.12, length, height), yaw_deg), parent)


def n_loose(*rows):
    return int(loose_wall_ends(TopView(scene_of(*rows))).sum())


def test_a_wall_from_outer_wall_to_outer_wall_has_no_loose_end():
    assert n_loose(HOUSE, wall(0, 0, 7.5)) == 0


@pytest.mark.parametrize(("short_m", "loose"), [(0.3, 0), (0.4, 0), (1.0, 2)])
def test_a_wall_cut_short_on_both_ends_has_two(short_m, loose):
    # From the rim: a quarter metre of outer wall and half of what is cut.
    assert n_loose(HOUSE, wall(0, 0, 7.5 - short_m)) == loose


def test_a_wall_meets_another_in_a_corner_and_in_a_tee():
    across = wall(-2.3, 0.5, 4.9, yaw_deg=90.0)
    assert n_loose(HOUSE, wall(0.2, 0, 7.5), across) == 0
    assert n_loose(HOUSE, wall(0.2, 0, 7.5), wall(-2.8, 0.5, 3.9, yaw_deg=90.0)) == 1
    # The corner: one ends at the face of the other, which runs as far as its far side.
    assert n_loose(HOUSE, wall(0.2, -1.6, 4.32), across) == 0


def test_a_wall_of_another_storey_does_not_count():
    above = wall(0.2, 0, 7.5, z=6.0)
    assert n_loose(HOUSE, above) == 2
    assert n_loose(HOUSE, wall(0.2, 0, 7.5), wall(-2.3, 0.5, 4.9, yaw_deg=90.0, z=6.0)) == 2


def test_a_free_wall_has_two_loose_ends_and_a_parapet_is_not_judged():
    block = ("terrain", box((0, 0, 0.5), (10, 10, 1)))
    assert n_loose(wall(0, 0, 4, parent=None)[:2]) == 2
    assert len(loose_wall_ends(TopView(scene_of(block, wall(0, 0, 4))))) == 0


def test_a_wall_that_is_long_along_x_ends_there():
    along_x = ("wall", box((0, 0, 1.5), (9.5, 0.12, 3)), 0)
    assert n_loose(HOUSE, along_x) == 0


def shares(*rows, use="office"):
    scene = scene_of(*rows)
    objects = tuple(
        replace(obj, attributes={"use": use}) if obj.category == "room" and use else obj
        for obj in scene.objects
    )
    return closed_shares(TopView(replace(scene, objects=objects))).tolist()


WEST = ("room", box((-2.4, 0, 1.4), (4.68, 7.5, 2.5)), 0)
"""The western half of the house; its sides sum up to 24.36 m."""


def test_a_room_between_outer_walls_and_a_wall_is_closed():
    assert shares(HOUSE, WEST, wall(0, 0, 7.5)) == pytest.approx([1.0])


def test_a_room_without_one_of_its_walls_is_open_there():
    # Outer walls close the last 0.35 m of the open side at either end, a wall 0.2 m beyond its own.
    assert shares(HOUSE, WEST) == pytest.approx([1 - 6.8 / 24.36])
    assert shares(HOUSE, WEST, wall(0, -1.75, 4.0)) == pytest.approx([1 - 2.95 / 24.36])


def test_a_wall_of_less_than_half_the_height_closes_nothing():
    low = wall(0, 0, 7.5, z=0.5, height=1.0)
    assert shares(HOUSE, WEST, low) == shares(HOUSE, WEST)


def test_halls_in_a_building_are_not_judged_and_rooms_in_none_are():
    assert shares(HOUSE, WEST, use="lobby") == shares(HOUSE, WEST, use=None) == []
    room = ("room", box((0, 0, 1.4), (4, 4, 2.5)))
    around = [wall(x, 0, 4, parent=None)[:2] for x in (-2.06, 2.06)]
    assert shares(room, *around, use=None) == pytest.approx([0.5 + 0.8 / 16], abs=0.002)
    around += [wall(0, y, 4, 90.0)[:2] for y in (-2.06, 2.06)]
    assert shares(room, *around, use=None) == pytest.approx([1.0])


def test_boxes_of_one_room_in_no_building_are_judged_as_one():
    boxes = [("room", box((x, 0, 1.4), (4, 4, 2.5))) for x in (-2, 2)]
    around = [wall(x, 0, 4, parent=None)[:2] for x in (-4.06, 4.06)]
    around += [wall(0, y, 8, 90.0)[:2] for y in (-2.06, 2.06)]
    assert shares(*boxes, *around, use=None) == pytest.approx([1.0])
    assert shares(*boxes, *around[1:], use=None) == pytest.approx([1 - 3.6 / 24], abs=0.002)


def test_the_whole_scene_may_be_turned():
    for yaw_deg in (0.0, 37.0):
        house = ("house", box((0, 0, 1.5), (10, 8, 3), yaw_deg))
        assert n_loose(house, ("wall", box((0, 0, 1.5), (0.12, 7.5, 3), yaw_deg), 0)) == 0
        assert n_loose(house, ("wall", box((0, 0, 1.5), (0.12, 6.5, 3), yaw_deg), 0)) == 2
