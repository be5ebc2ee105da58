"""Drones that come a vehicle's way: where they come from, when they are there, what is counted."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from measuring import encounters
from measuring.configs import EncountersBenchCfg
from measuring.meeting import DIRECTIONS, FlownWay, centres, draw_meeting

from tests.scenarios.landing_scenes import yard

TIMES_S = np.arange(0.0, 30.0, 0.02)
EASTWARD = FlownWay(
    time_s=TIMES_S,
    position_enu_m=np.column_stack([2.0 * TIMES_S, 0 * TIMES_S, np.full_like(TIMES_S, 9.0)]),
)


def anywhere(places_enu_m, _room_m):
    return places_enu_m[:, 2] > 0.0


@settings(max_examples=25)
@given(seed=st.integers(0, 2**32), direction=st.sampled_from(DIRECTIONS))
def test_a_drone_is_where_the_vehicle_is_and_comes_from_where_it_should(seed, direction):
    rng = np.random.default_rng(seed)
    mover = draw_meeting(EASTWARD, (8.0, 20.0), direction, anywhere, rng)
    assert mover is not None
    there = centres(mover, TIMES_S)
    off_m = np.linalg.norm(there - EASTWARD.position_enu_m, axis=1)
    # The first time that they are near each other is the meeting, within its times.
    meet = int(np.argmax(off_m < 0.1))
    assert 0.0 < off_m[meet : meet + 10].min() < 0.05
    assert 7.9 < TIMES_S[meet] < 20.1
    comes = there[meet] - there[meet - 40]
    down = math.degrees(math.asin(-comes[2] / np.linalg.norm(comes)))
    turn = abs(math.degrees(math.atan2(comes[1], comes[0])))
    low, high = {"above": (25, 60), "below": (-60, -25)}.get(direction, (-10, 10))
    assert low - 1 < down < high + 1
    if direction == "ahead":
        assert turn > 149
    if direction == "side":
        assert 59 < turn < 121


def test_no_drone_comes_through_what_stands():
    rng = np.random.default_rng(0)
    wall = lambda places, room: places[:, 1] < 2.0 - room  # noqa: E731 - one line says it
    found = [draw_meeting(EASTWARD, (8.0, 20.0), "ahead", wall, rng) for _ in range(10)]
    ways = [np.array(mover.path_enu_m) for mover in found if mover is not None]
    assert len(ways) > 5
    assert max(way[:, 1].max() for way in ways) < 2.0
    assert draw_meeting(EASTWARD, (8.0, 20.0), "side", wall, rng) is None


@pytest.fixture
def in_the_yard(monkeypatch):
    monkeypatch.setattr(encounters, "load_scene", lambda _name: yard())


@pytest.mark.usefixtures("in_the_yard")
def test_encounters_are_flown_and_counted():
    said = []
    cfg = EncountersBenchCfg(count=1)
    rows = {row.metric: row for row in encounters.rows(cfg, lambda *words: said.append(words))}
    assert rows["encounters"].value == 1
    assert rows["nearer than 0.3 m"].target == 0
    # It was there: whoever flies past far away met nobody.
    assert rows["nearest, least"].value < 4.0
    assert sum(rows[f"{name}: encounters"].value for name in DIRECTIONS) == 1
    assert next(words for words, _ in said).endswith("alone")
