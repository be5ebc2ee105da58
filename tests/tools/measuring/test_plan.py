"""The planner's benchmark: every measure has a row, the same pairs for the same seed."""

import math

import numpy as np
from measuring.configs import PlanBenchCfg
from measuring.joint_optimum import joint_optimum
from measuring.plan import rows
from measuring.plan_crossing import fly_past_a_crossing
from measuring.plan_pairs import FAR_ENOUGH_M, draw_pairs, scene_numbers

from aeroscene.sources import load_scene
from autonomy.planning import PlannerCfg
from autonomy.planning.corridor import build_corridor
from autonomy.planning.demand import excess
from autonomy.planning.limits import FlightLimits
from autonomy.planning.obstacles import Obstacles
from autonomy.planning.optimiser import optimise
from autonomy.types import FlatReference
from flightsim.vehicles.catalogue import airframe_by_name
from scenarios.mission.surroundings import survey

IRIS = airframe_by_name("iris")


def test_pairs_are_free_far_apart_and_the_same_for_the_same_seed():
    world = survey(load_scene("508"), IRIS)
    pairs = draw_pairs(world, 6, np.random.default_rng(3))
    assert pairs == draw_pairs(world, 6, np.random.default_rng(3))
    assert len(pairs) == 6
    ends = np.array(pairs)
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).min() >= FAR_ENOUGH_M
    room = world.clearance_m(ends.reshape(-1, 3))
    assert room.min() > PlannerCfg(vehicle_radius_m=1.0).min_margin_m
    assert scene_numbers(20)[::19] == [0, 1015]


def test_who_crosses_a_plan_is_avoided_and_the_same_for_the_same_seed():
    world = survey(load_scene("508"), IRIS)
    start, goal = draw_pairs(world, 1, np.random.default_rng(3))[0]
    plan = world.plan(FlatReference(position_enu_m=start), goal)

    def fly(seed):
        crossing = fly_past_a_crossing(world, plan, np.random.default_rng(seed))
        assert crossing is not None
        return crossing.is_avoided, crossing.has_braked, len(crossing.replans_ms)

    flights = [fly(seed) for seed in (0, 2)]
    assert flights == [fly(seed) for seed in (0, 2)]
    assert all(is_avoided for is_avoided, _, _ in flights)
    assert any(n_replans for _, _, n_replans in flights)


def test_the_optimiser_comes_within_a_hundredth_of_the_joint_optimum():
    nothing = Obstacles.boxes(np.zeros((0, 3)), np.zeros((0, 4)), np.zeros((0, 3)))
    limits, quadrotor = FlightLimits(), IRIS.quadrotor
    gates = np.array([[0, 0, 5], [8, 0, 5], [8, 6, 6]], dtype=float)
    corridor = build_corridor(
        gates,
        nothing,
        (np.full(3, -30.0), np.full(3, 30.0)),
        wanted_m=0.5,
        least_m=0.1,
        max_leg_m=12.0,
    )
    start, goal = (np.array([gate, np.zeros(3), np.zeros(3)]) for gate in gates[[0, -1]])

    def beyond(nodes, durations):
        return excess(nodes, durations, limits, quadrotor)

    bounds = limits.motion_bounds(quadrotor)
    ours = optimise(start, goal, corridor, bounds, excess=beyond)
    best = joint_optimum(corridor, start, goal, limits, quadrotor)
    assert best is not None
    assert 0.999 * best <= ours.cost <= 1.01 * best


def test_every_measure_has_a_row():
    titles = []
    cfg = PlanBenchCfg(count=2, scenes=1, joint=0)
    found = {row.metric: row for row in rows(cfg, lambda title, _: titles.append(title))}
    assert titles == ["scene 0"]
    assert found["plans that are sound, checked apart"].value == 100.0
    targets = {
        "solved where a path exists": 99.5,
        "whole mission, median": 500.0,
        "replan 8 pieces, warm, median": 20.0,
    }
    for metric, target in targets.items():
        assert found[metric].target == target
        assert math.isfinite(found[metric].value)
