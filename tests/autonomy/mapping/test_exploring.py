"""Flights through what was not known before: every plan ends where it is free."""

import math

import numpy as np
import pytest

from autonomy.mapping import Agenda, SeenMap, plan_towards
from autonomy.mapping.rays import OCCUPIED_AT
from autonomy.mapping.seen_map_cfg import SeenMapCfg
from autonomy.planning import (
    BlockedError,
    CertificateError,
    Craft,
    FlightLimits,
    Obstacles,
    PlannerCfg,
    PlanningError,
    UnreachableError,
    certify,
    plan_trajectory,
)
from autonomy.types import FlatReference
from tests.autonomy.depth_scene import box, look_down
from tests.autonomy.planning_worlds import quadrotor

LOW, HIGH = (-3.0, -6.0, 0.0), (14.0, 6.0, 5.0)
START = FlatReference(position_enu_m=(0.0, 0.0, 2.0))
PITCH_DOWN = math.radians(15.0)
RADIUS_M = 0.35
CFG = PlannerCfg(vehicle_radius_m=RADIUS_M)
LIMITS = FlightLimits()
FRAME_S = 0.2
SHELL = [box((5.5, y, 2.5), (17.0, 0.2, 5.0)) for y in (-6.1, 6.1)]


def wall_with_gap(gap_y, width):
    """From one side of the volume to the other, as high as it, and open for a stretch."""
    low, high = gap_y - width / 2, gap_y + width / 2
    return [
        box((6.1, (low - 6.0) / 2, 2.5), (0.2, low + 6.0, 5.0)),
        box((6.1, (6.0 + high) / 2, 2.5), (0.2, 6.0 - high, 5.0)),
    ]


def look(at, boxes):
    half = at.yaw_rad / 2
    quat = (math.cos(half), 0.0, 0.0, math.sin(half))
    return look_down(at.position_enu_m, quat, pitch_down=PITCH_DOWN, boxes=boxes, shape=(120, 160))


def plan(seen, start, goal, agenda=None):
    craft = Craft(LIMITS, quadrotor(), CFG)
    return plan_towards(seen, agenda or Agenda(), start, goal, craft)


def fly(boxes, goal, seconds=60.0, cfg=None):
    """Follow plans exactly, with an image five times a second; where the vehicle was."""
    seen = SeenMap(LOW, HIGH, cfg)
    seen.assume_free_column((0.0, 0.0, 0.0))
    seen.observe(look(START, boxes))
    agenda, way, at = Agenda(), None, 0.0
    positions = []
    for _ in range(round(seconds / FRAME_S)):
        here = START if way is None else way.sample(at)
        positions.append(here.position_enu_m)
        if math.dist(here.position_enu_m, goal) < 0.05:
            break
        seen.observe(look(here, boxes))
        if way is None or at > 0.6:
            try:
                new = plan(seen, here, goal, agenda)
            except UnreachableError:
                if way is None or at > way.duration_s:
                    raise
            except PlanningError:
                assert way is not None
                assert at < way.duration_s
            else:
                certify(new, seen.obstacles, RADIUS_M, LIMITS, quadrotor())
                way, at = new, 0.0
        at += FRAME_S
    return np.array(positions)


def true_obstacles(boxes):
    center = np.array([(low + high) / 2 for low, high in boxes])
    size = np.array([high - low for low, high in boxes])
    return Obstacles.boxes(center, np.tile((1.0, 0.0, 0.0, 0.0), (len(boxes), 1)), size)


@pytest.mark.parametrize("gap_y", [0.0, 3.0])
def test_a_gap_in_a_wall_is_found_and_passed(gap_y):
    boxes = SHELL + wall_with_gap(gap_y, 2.5)
    goal = (10.0, 0.0, 2.0)
    flown = fly(boxes, goal)
    assert math.dist(flown[-1], goal) < 0.05
    assert true_obstacles(boxes).signed_distance(flown)[0].min() > RADIUS_M


def test_a_goal_beyond_the_block_of_a_search_is_reached_past_a_wall():
    boxes = SHELL + wall_with_gap(3.0, 2.5)
    goal = (12.0, 0.0, 2.0)
    flown = fly(boxes, goal, cfg=SeenMapCfg(most_whole_cells=1, search_m=8.0))
    assert math.dist(flown[-1], goal) < 0.05
    assert true_obstacles(boxes).signed_distance(flown)[0].min() > RADIUS_M


def test_a_goal_whose_way_out_of_the_block_is_closed_is_refused():
    seen = SeenMap(LOW, HIGH, SeenMapCfg(most_whole_cells=1, search_m=8.0))
    seen.assume_free_column((0.0, 0.0, 0.0))
    seen.evidence[20:] = OCCUPIED_AT
    seen._change(np.array([(20, 0, 0), seen.evidence.shape]))
    with pytest.raises(UnreachableError, match="is closed at"):
        plan(seen, START, (13.0, 0.0, 2.0))


def test_a_plan_that_is_flown_on_has_no_distances_computed():
    seen = SeenMap(LOW, HIGH)
    seen.assume_free_column((0.0, 0.0, 0.0))
    for _ in range(2):
        seen.observe(look(START, SHELL))
    agenda = Agenda()
    now = plan(seen, START, (13.0, 0.0, 2.0), agenda).sample(1.0)
    assert np.all(seen._changed[0] >= seen._changed[1])
    seen.observe(look(now, SHELL))
    with pytest.raises(PlanningError, match="1 images were taken"):
        plan(seen, now, (13.0, 0.0, 2.0), agenda)
    assert np.all(seen._changed[0] < seen._changed[1])


def test_a_wall_without_a_gap_is_given_up():
    closed = [*SHELL, box((6.1, 0.0, 2.5), (0.2, 12.0, 5.0))]
    with pytest.raises(UnreachableError):
        fly(closed, (10.0, 0.0, 2.0), seconds=200.0)


def test_a_goal_behind_the_vehicle_makes_it_turn_first():
    seen = SeenMap((-9.0, -6.0, 0.0), HIGH)
    seen.assume_free_column((0.0, 0.0, 0.0))
    for _ in range(2):
        seen.observe(look(START, SHELL))
    turn = plan(seen, START, (-6.0, 0.0, 2.0))
    assert turn.corridor is None
    assert math.dist(turn.positions(np.array([turn.duration_s]))[0], START.position_enu_m) < 1e-6
    assert abs(math.remainder(turn.yaw.yaw_rad[-1] - math.pi, math.tau)) < 0.5
    rate = np.abs(np.diff(turn.yaw.yaw_rad)).max() / turn.yaw.step_s
    assert rate <= LIMITS.yaw_rate_radps * 1.01


def test_a_plan_ends_within_what_was_seen_free():
    seen = SeenMap(LOW, HIGH)
    seen.assume_free_column((0.0, 0.0, 0.0))
    for _ in range(2):
        seen.observe(look(START, SHELL))
    part = plan(seen, START, (13.0, 0.0, 2.0))
    end = part.sample(part.duration_s)
    assert 3.0 < end.position_enu_m[0] < 8.0
    assert seen.obstacles.signed_distance(np.array([end.position_enu_m]))[0] > RADIUS_M


def test_a_goal_in_sight_that_no_plan_reaches_at_once_is_approached(monkeypatch):
    def plan_nearby(start, goal, *world):
        if math.dist(start.position_enu_m, goal) > 3.0:
            raise CertificateError("more than 14 obstacles crowd the leg; valid: less clutter")
        return plan_trajectory(start, goal, *world)

    monkeypatch.setattr("autonomy.mapping.task.plan_trajectory", plan_nearby)
    seen, goal = SeenMap(LOW, HIGH), (5.0, 0.0, 2.0)
    seen.assume_free_column((0.0, 0.0, 0.0))
    for _ in range(2):
        seen.observe(look(START, SHELL))
    way = plan(seen, START, goal)
    assert math.dist(way.sample(way.duration_s).position_enu_m, goal) < 3.5


def test_a_goal_in_what_was_seen_or_off_the_map_is_named():
    block = box((4.0, 0.0, 2.0), (1.0, 1.0, 2.0))
    seen = SeenMap(LOW, HIGH)
    seen.assume_free_column((0.0, 0.0, 0.0))
    for _ in range(2):
        seen.observe(look(START, [*SHELL, block]))
    with pytest.raises(BlockedError, match=r"goal \(3.50, 0.00, 2.00\) m is 0.00 m from what"):
        plan(seen, START, (3.5, 0.0, 2.0))
    with pytest.raises(BlockedError, match="outside the map"):
        plan(seen, START, (40.0, 0.0, 2.0))
