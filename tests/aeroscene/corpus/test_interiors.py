"""What stands in rooms, and the shapes of the walls around them."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from aeroscene.corpus.curation.builder import Builder, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.interiors import FURNISHINGS, Interior
from aeroscene.corpus.curation.rooms.extras import furnish_rest
from aeroscene.corpus.curation.rooms.tables import lay, seats
from aeroscene.corpus.curation.shells import RoomSpace, raise_shell
from aeroscene.scene import SceneObject
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.shell import FINISH_M, wall
from aeroscene.solids.shapes.storage import shelf_boards

WORLD = Frame(0.0, 0.0, 0.0)
TELLING = {
    "office": "desk", "open_office": "desk", "meeting": "table", "workshop": "counter",
    "classroom": "desk", "library": "shelf", "living": "sofa", "bedroom": "bed",
    "kitchen": "counter", "dining": "table", "cafe": "counter", "lobby": "counter",
    "lounge": "coffee_table", "corridor": "plant", "garden": "planter", "gym": "landing_pad",
    "changing": "wardrobe", "court": "bench", "stand": "bench", "concourse": "bench",
    "store": "shelf", "racks": "shelf", "goods": "pallet", "storage": "shelf",
    "bathroom": "toilet", "washroom": "toilet", "ward": "bed", "practice": "bed",
    "waiting": "chair",
    "restaurant": "plate", "galley": "stove", "aisles": "shelf", "produce": "crate",
    "checkout": "counter", "booths": "sign",
}  # fmt: skip
"""By what a person recognises each kind of room."""


def _furnished(kind: str, seed: int = 3, side: float = 12.0) -> tuple[Placed, list[SceneObject]]:
    """A room of 12 m by 9 m with everything its kind brings."""
    builder = Builder("s")
    room = builder.place("room", WORLD, (side, 0.75 * side, 3.35), base=0.15)
    assert room
    interior = Interior(builder, Draw(np.random.default_rng(seed)), RoomSpace(room))
    for _ in FURNISHINGS[kind](interior):
        pass
    for _ in furnish_rest(interior, kind):
        pass
    return room, builder.objects[1:]


@pytest.fixture(params=sorted(FURNISHINGS))
def kind(request: pytest.FixtureRequest) -> str:
    return request.param


def test_every_kind_is_recognised_by_something(kind):
    assert TELLING[kind] in {obj.category for obj in _furnished(kind)[1]}


def test_furniture_stands_inside_its_room_on_floor_or_furniture(kind):
    room, objects = _furnished(kind)
    by_id = {obj.id: obj for obj in objects}
    for obj in objects:
        corners = obj.bbox.corners()
        assert np.all(np.abs(corners[:, 0]) <= room.size[0] / 2 + 1e-6), obj
        assert np.all(np.abs(corners[:, 1]) <= room.size[1] / 2 + 1e-6), obj
        assert corners[:, 2].max() <= room.top
        foot = corners[:, 2].min()
        bearer = by_id.get(obj.parent_id) if obj.parent_id is not None else None
        levels = [room.base + FINISH_M] if bearer is None else _levels(bearer)
        assert min(abs(foot - level) for level in levels) <= 2e-4, obj


def _levels(bearer: SceneObject) -> list[float]:
    """Heights on furniture at which things may lie: its top, and the boards of an open shelf."""
    heights = bearer.bbox.corners()[:, 2]
    is_open = bearer.attributes.get("form") == "open"
    boards = shelf_boards(bearer.bbox.s[2]) if is_open else ()
    return [heights.max(), *(heights.min() + board for board in boards)]


def test_chairs_face_the_table_that_they_stand_at(kind):
    _, objects = _furnished(kind)
    boards = [obj for obj in objects if obj.category in {"table", "desk", "counter"}]
    for chair in (obj for obj in objects if obj.category == "chair"):
        near = [b for b in boards if _gap(b, chair) < 0.35]
        if near:
            heading = np.array([math.cos(chair.bbox.yaw_rad), math.sin(chair.bbox.yaw_rad)])
            assert any(_is_ahead(chair, heading, board) for board in near), chair


def _gap(board: SceneObject, chair: SceneObject) -> float:
    """Distance between the chair's middle and the board's outline, less half a chair, m."""
    u, v = Frame(*board.bbox.p[:2], board.bbox.yaw_rad).local(*chair.bbox.p[:2])
    outside = np.maximum(np.abs([u, v]) - np.array(board.bbox.s[:2]) / 2, 0)
    return float(np.hypot(*outside)) - chair.bbox.s[0] / 2


def _is_ahead(chair: SceneObject, heading: np.ndarray, board: SceneObject) -> bool:
    ahead = np.array(chair.bbox.p[:2]) + heading * (chair.bbox.s[0] / 2 + 0.25)
    u, v = Frame(*board.bbox.p[:2], board.bbox.yaw_rad).local(*ahead)
    return bool(abs(u) <= board.bbox.s[0] / 2 + 0.1 and abs(v) <= board.bbox.s[1] / 2 + 0.1)


def test_a_set_table_has_a_cup_with_each_plate():
    for kind in ("dining", "kitchen", "living", "cafe"):
        builder = Builder("s")
        room = builder.place("room", WORLD, (9, 7, 3.35), base=0.15)
        assert room
        interior = Interior(builder, Draw(np.random.default_rng(1)), RoomSpace(room))
        table = interior.put("table", 0.0, 0.0, (1.0, 2.2, 0.74))
        chairs = seats(interior, table, 4)
        lay(interior, table, chairs)
        found = Counter(obj.category for obj in builder.objects)
        assert found["chair"] == found["plate"] == found["cup"] == 4, kind


def test_rooms_grow_in_small_steps_that_begin_at_once(kind):
    builder = Builder("s")
    room = builder.place("room", WORLD, (12, 9, 3.35), base=0.15)
    assert room
    interior = Interior(builder, Draw(np.random.default_rng(3)), RoomSpace(room))
    counts = [0, *(builder.n_fine for _ in FURNISHINGS[kind](interior))]
    assert len(counts) >= 4
    assert counts[1] > 0
    assert max(np.diff(counts)) <= 9


def test_furnishing_repeats_itself_exactly(kind):
    assert _furnished(kind, seed=8)[1] == _furnished(kind, seed=8)[1]
    assert _furnished(kind, seed=8)[1] != _furnished(kind, seed=9)[1]


def test_a_room_too_small_for_its_kind_stays_as_it_is(kind):
    room, objects = _furnished(kind, side=2.4)
    assert len(objects) <= 24
    for obj in objects:
        assert np.all(np.abs(obj.bbox.corners()[:, 0]) <= room.size[0] / 2 + 1e-6)


def test_furniture_leans_on_walls_only():
    builder = Builder("s")
    room = builder.place("room", WORLD, (10, 8, 3.35), base=0.15)
    assert room
    draw = Draw(np.random.default_rng(2))
    interior = Interior(builder, draw, RoomSpace(room), ("back",))
    for name in ("cabinet", "shelf", "sofa"):
        placed = interior.against("front", name)
        assert placed
        assert placed.frame.x - placed.size[0] / 2 == pytest.approx(-5.0, abs=0.05)
        assert math.cos(placed.frame.yaw) == pytest.approx(1.0)


@pytest.mark.parametrize("storeys", [1, 2])
def test_a_shell_has_rooms_on_every_storey_inside_its_walls(storeys):
    builder = Builder("s")
    shell = raise_shell(
        builder,
        Draw(np.random.default_rng(4)),
        WORLD,
        (0.0, 0.0),
        name="building",
        depth=9.0,
        length=15.0,
        storeys=storeys,
        base=0.1,
        turn=0.0,
        colour="sand",
        kinds=("living", "kitchen", "bedroom", "bathroom"),
    )
    assert shell
    assert len(shell.rooms) >= storeys
    for space in shell.rooms:
        assert space.placed.top <= shell.building.top + 1e-9
        assert space.placed.size[2] >= 2.6


# A strip of 0.01 m is left beside the door.
@example(3.0, 2.6, 1.6, 1.0, "plain")
@example(4.0, 2.6, 2.0, 1.0, "plain")
@example(7.0, 3.0, 1.9, -1.0, "glass")
@given(
    st.floats(3.0, 16.0),
    st.floats(2.6, 7.0),
    st.floats(1.6, 2.75),
    st.floats(-1.0, 1.0),
    st.sampled_from(("plain", "glass")),
)
def test_a_door_in_a_wall_is_open_and_the_rest_is_closed(length, height, door, at, form):
    middle = at * max(0.0, length / 2 - door / 2 - 0.01)
    attributes = {"door_m": door, "door_offset_m": middle, "door_height_m": 2.25, "form": form}
    parts = [part for part in wall(Look((0.12, length, height), attributes, 0)) if part.collides]
    assert not _covers(parts, middle, 1.0)
    assert not _covers(parts, middle + 0.49 * door, 2.2)
    assert _covers(parts, middle, (2.25 + height) / 2)
    for y in np.linspace(-length / 2 + 0.005, length / 2 - 0.005, 15):
        if abs(y - middle) > door / 2 + 0.005:
            assert _covers(parts, float(y), 0.05)
            assert _covers(parts, float(y), 1.5)


def _covers(parts, y: float, z: float) -> bool:
    return any(
        abs(part.position_m[1] - y) <= part.size_m[1] / 2
        and abs(part.position_m[2] - z) <= part.size_m[2] / 2
        for part in parts
    )
