"""What is drawn at the edge of a room stands at one that has a wall."""

import math

import numpy as np
import pytest
import shapely

from aeroscene.learning.program import encode
from aeroscene.learning.program.decoding.cfg import DecodingCfg
from aeroscene.learning.program.decoding.decode import decode
from aeroscene.learning.program.decoding.draft import Draft
from aeroscene.learning.program.decoding.draft.neighbours import Neighbours
from aeroscene.learning.program.decoding.units.backs import has_wall
from aeroscene.metrics.places.top_view import TopView
from aeroscene.relations import Kind, Relation, Unit
from aeroscene.scene import OrientedBox
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.catalogue import SHELLS, WALLS

EAST, NORTH = 0, 1
CUPBOARDS = ("cabinet", "wardrobe", "shelf", "counter")


def box(x_m, y_m, size_m=(0.5, 1.0, 2.0), z_m=1.0, yaw_rad=0.0):
    return OrientedBox((x_m, y_m, z_m), quat_from_yaw(yaw_rad), size_m)


@pytest.fixture(scope="module")
def program(scenes):
    return encode(scenes[0]).program


@pytest.fixture
def standing(program):
    """Something in a room of 10 by 8 m that has no walls of its own."""

    def stand(*boxes, category="wall"):
        draft = Draft(program)
        for name, each in (("room", ROOM), *((category, box) for box in boxes)):
            draft.add(None, name, "indoor", {}, each, parent=None, bearer=None)
        return draft

    return stand


def at_wall(boxes, side, draft):
    relation = Relation(kind=Kind.EDGE, side=side, quadrant=2)
    return has_wall(draft, Unit(parent_id=0, host_id=0, relation=relation, members=()), boxes)


ROOM = box(0.0, 0.0, (10.0, 8.0, 3.0), 1.5)
EAST_WALL = box(5.1, 1.0, (0.2, 6.0, 3.0), 1.5)


def test_a_wall_counts_at_the_side_where_it_is(standing):
    draft = standing(EAST_WALL)
    assert at_wall([box(4.7, 0.0)], EAST, draft)
    assert not at_wall([box(4.7, -3.0)], EAST, draft)
    assert not at_wall([box(0.0, 3.7)], NORTH, draft)
    assert not at_wall([box(4.4, 0.0)], EAST, draft)
    assert not at_wall([box(4.7, 0.0, z_m=5.0)], EAST, draft)
    assert not at_wall([box(4.7, 0.0)], EAST, standing())


def test_every_thing_of_the_foremost_row_has_a_wall(standing):
    row = [box(4.7, y) for y in (-1.5, 0.0, 1.5)]
    behind = [box(3.0, -3.5)]
    assert at_wall([*row, *behind], EAST, standing(EAST_WALL))
    assert not at_wall([*row, box(4.7, -3.5)], EAST, standing(EAST_WALL))


@pytest.mark.parametrize("yaw_rad", [0.0, math.pi / 2, math.pi, 0.3])
def test_the_end_towards_the_side_counts_however_a_thing_is_turned(standing, yaw_rad):
    reach_m = 0.25 * abs(math.cos(yaw_rad)) + 0.5 * abs(math.sin(yaw_rad))
    assert at_wall([box(4.95 - reach_m, 0.0, yaw_rad=yaw_rad)], EAST, standing(EAST_WALL))
    assert not at_wall([box(4.6 - reach_m, 0.0, yaw_rad=yaw_rad)], EAST, standing(EAST_WALL))


def test_the_inside_of_a_shell_is_a_wall(standing):
    house = standing(box(0.0, 0.0, (10.4, 8.4, 3.0), 1.5), category="house")
    assert at_wall([box(4.7, 0.0)], EAST, house)
    assert not at_wall([box(3.0, 0.0)], EAST, house)


@pytest.mark.parametrize("mends", [True, False])
def test_a_cupboard_at_an_open_edge_goes_to_one_with_a_wall(scenes, monkeypatch, mends):
    """The decoder is blind to the wall behind a cupboard, as if the edge were open there."""
    scene, cupboard, wall_m = _cupboard_before_a_wall(scenes)
    program = encode(scene).program
    back = _back(scene, cupboard)
    assert _away_m(back, decode(program).scene) < 0.01
    seen = Neighbours.of

    def without_the_wall(self, categories):
        rows = seen(self, categories)
        away_m = np.linalg.norm(
            np.column_stack([rows["x_m"], rows["y_m"]])[:, None] - wall_m, axis=2
        )
        return rows[np.all(away_m > 0.2, axis=1)]

    monkeypatch.setattr(Neighbours, "of", without_the_wall)
    away_m = _away_m(back, decode(program, cfg=DecodingCfg(mends=mends)).scene)
    assert (away_m > 0.3) == mends


def _cupboard_before_a_wall(scenes):
    """A scene, the row of a cupboard in it, and the middles of the walls behind that (k, 2), m."""
    for scene in scenes:
        view = TopView(scene)
        walls = view.rows(WALLS)
        for row in view.rows(CUPBOARDS):
            back = shapely.Point(*_back(scene, row))
            is_near = shapely.distance(view.outline[walls], back) < 0.3
            rims = shapely.boundary(view.outline[view.rows(SHELLS)])
            is_at_rim = bool((shapely.distance(rims, back) < 0.6).any())
            if is_near.any() and not is_at_rim:
                return scene, row, view.centre_m[walls[is_near]]
    pytest.fail("no cupboard before an inner wall")


def _away_m(back, scene):
    """Distance of the nearest cupboard's back from a place."""
    backs = np.array([_back(scene, row) for row in TopView(scene).rows(CUPBOARDS)])
    return np.linalg.norm(backs - back, axis=1).min()


def _back(scene, row):
    return TopView(scene).face(np.array([row]), 0, -1).mean(axis=1)[0]
