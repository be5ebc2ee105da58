"""Shelves that are drawn back to back stand so, wherever the first were put, and in their room."""

import math
from itertools import combinations

import pytest

from aeroscene.learning.program import encode
from aeroscene.learning.program.decoding.decode import decode
from aeroscene.learning.program.decoding.draft import Draft
from aeroscene.learning.program.decoding.draft.supports import is_on_any
from aeroscene.learning.program.decoding.units.groups import back_to_back, backed_by
from aeroscene.learning.program.kinds import CATEGORY_IDS
from aeroscene.learning.program.program import PITCH
from aeroscene.relations import Array, Kind, Member, Relation, Unit
from aeroscene.relations.plane import footprint
from aeroscene.relations.relation import Align, Gap
from aeroscene.scene import OrientedBox
from aeroscene.scene.box import quat_from_yaw
from tests.aeroscene.conftest import cached_scene

ROOM = OrientedBox((0.0, 0.0, 1.5), quat_from_yaw(0.0), (10.0, 8.0, 3.0))
SIZE_M = (0.5, 2.0, 2.0)
PITCH_M = 3.0
ROWS, COLUMNS = 2, 2


def shelf(x_m, y_m):
    return OrientedBox((x_m, y_m, 1.0), quat_from_yaw(math.pi), SIZE_M)


def behind(pitch_m=PITCH_M, **changes):
    """As many shelves at the backs of the first of those that stand."""
    said = {"kind": Kind.SIDE, "side": 2, "gap": Gap.TOUCH, "align": Align.LOW, "quadrant": 0}
    member = Member(
        id=0, category_id=CATEGORY_IDS["shelf"], size_m=SIZE_M, is_on_top=False, rise_m=0.0
    )
    return Unit(
        parent_id=0,
        host_id=1,
        relation=Relation(**said | changes),
        members=(member,) * (ROWS * COLUMNS),
        array=Array(rows=ROWS, columns=COLUMNS, pitch_m=(pitch_m, 2.0)),
    )


@pytest.fixture
def rows(scenes):
    """Two rows of shelves with their backs to the east; as near to a room's end as asked for."""

    def stand(east_m):
        program = encode(scenes[0]).program
        token = next(i for i, kind in enumerate(program.kinds) if kind.node == "unit")
        draft = Draft(program)
        draft.add(None, "room", "indoor", {}, ROOM, parent=None, bearer=None)
        for x_m in (east_m - PITCH_M, east_m):
            for y_m in (-1.0, 1.0):
                draft.add(token, "shelf", "indoor", {}, shelf(x_m, y_m), parent=0, bearer=0)
        draft.pitches_m[token] = (PITCH_M, 2.0)
        return draft

    return stand


def backs_m(draft, boxes):
    """How far each of some boxes is behind the nearest that stands beside it."""
    stood = [obj.bbox.p for obj in draft.objects[1:]]
    return [min(abs(box.p[0] - p[0]) for p in stood if abs(p[1] - box.p[1]) < 0.2) for box in boxes]


def test_only_what_is_alike_and_turned_away_counts(rows):
    draft = rows(2.0)
    assert backed_by(draft, behind()) == [1, 2, 3, 4]
    for changes in ({"quadrant": 2}, {"side": 1}, {"gap": Gap.WIDE}, {"kind": Kind.FACING}):
        assert backed_by(draft, behind(**changes)) == []


@pytest.mark.parametrize("pitch_m", [PITCH_M, PITCH_M - 0.4])
def test_shelves_stand_back_to_back_though_their_rows_were_drawn_otherwise(rows, pitch_m):
    draft = rows(2.0)
    found = back_to_back(draft, behind(pitch_m), [1, 2, 3, 4], 0)
    assert len(found) == ROWS * COLUMNS
    assert backs_m(draft, found) == pytest.approx([0.53] * 4, abs=0.01)
    assert draft.objects[1].bbox.p[0] == 2.0 - PITCH_M


def test_the_first_make_room_for_those_behind_them(rows):
    draft = rows(4.7)
    found = back_to_back(draft, behind(), [1, 2, 3, 4], 0)
    assert backs_m(draft, found) == pytest.approx([0.53] * 4, abs=0.01)
    assert max(box.p[0] + SIZE_M[0] / 2 for box in found) <= 5.0 + 1e-9
    assert draft.objects[1].bbox.p[0] < 4.7 - PITCH_M
    assert back_to_back(rows(4.7), behind(), [1, 2, 3, 4], 5) is None


def test_a_program_whose_rows_are_unevenly_apart_decodes_to_shelves_back_to_back():
    program = encode(cached_scene(206)).program
    behind_another = next(
        token
        for token, kind in enumerate(program.kinds)
        if kind.node == "unit"
        and (kind.relation, kind.side, kind.gap, kind.is_group) == ("SIDE", 2, "TOUCH", True)
    )
    channels = program.channels.copy()
    channels[behind_another, PITCH.start] -= 0.35
    n_pairs = n_back_to_back(decode(program).scene)
    assert n_pairs > 10
    assert n_back_to_back(decode(program.with_channels(channels)).scene) == n_pairs


def n_back_to_back(scene):
    places = [obj.bbox.p for obj in scene.objects if obj.category == "shelf"]
    return sum(0.4 < math.dist(p[:2], q[:2]) <= 0.85 for p, q in combinations(places, 2))


def test_rows_that_reach_out_of_their_room_end_where_it_does():
    program = encode(cached_scene(206)).program
    channels = program.channels.copy()
    rows = [token for token, kind in enumerate(program.kinds) if kind.is_group]
    channels[rows, PITCH] *= 3.0
    scene = decode(program.with_channels(channels)).scene
    rooms = [footprint(obj.bbox) for obj in scene.objects if obj.category == "room"]
    shelves = [obj.bbox for obj in scene.objects if obj.category == "shelf"]
    assert len(shelves) > 10
    assert all(is_on_any(box, rooms) for box in shelves)
    assert all(math.dist(a.p, b.p) > 0.1 for a, b in combinations(shelves, 2))
