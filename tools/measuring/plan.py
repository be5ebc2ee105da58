"""Share of problems that the planner solves, its speed and the quality of its plans.

Times are CPU times of the process, kernels compiled and programs built. Plans are compared with two
others: the joint optimum of the same problem, which shows what the split of ours costs, and
primitives by Mueller, Hehn and D'Andrea 2015, which are a common fast planner.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from aeroscene.sources import load_scene
from autonomy.model.flatness import effort
from autonomy.planning import (
    PlannerCfg,
    PlanningError,
    Trajectory,
    plan_trajectory,
    prepare,
    replan,
)
from autonomy.planning.program import JERK_WEIGHT_M2PS5
from autonomy.planning.trajectory import squared_jerk
from autonomy.types import ZERO3, FlatReference
from flightsim.vehicles.airframe import Airframe
from flightsim.vehicles.catalogue import airframe_by_name
from measuring.configs import PlanBenchCfg
from measuring.joint_optimum import joint_optimum
from measuring.plan_crossing import Crossing, fly_past_a_crossing
from measuring.plan_pairs import draw_pairs, scene_numbers
from scenarios.bench.row import OnProgress, Row, higher, lower
from scenarios.mission.mission import plan_mission
from scenarios.mission.surroundings import MissionError, Surroundings, survey

# Targets of the results: percent, CPU ms, and percent above the optimum.
LEAST_SOLVED, LEAST_AVOIDED = 99.5, 95.0
MOST_MISSION_MS, MOST_REPLAN_MS = 500.0, 20.0
MOST_ABOVE_OPTIMUM = 1.0
N_PIECES = 8
_CHECK_STEP_S = 0.004  # between samples of the independent check
_TOLERANCE = 0.011
"""Tolerance that the certificate grants on a limit, plus rounding."""


@dataclass(kw_only=True, slots=True)
class _Tally:
    """Results so far, of all scenes."""

    n_pairs: int = 0
    n_sound: int = 0
    plans_ms: list[float] = field(default_factory=list)
    failures: Counter[str] = field(default_factory=Counter)
    missions_ms: list[float] = field(default_factory=list)
    n_no_mission: int = 0
    replans_ms: list[float] = field(default_factory=list)
    above_optimum: list[float] = field(default_factory=list)
    crossings: list[Crossing] = field(default_factory=list)
    n_primitives: int = 0
    primitives_ms: list[float] = field(default_factory=list)
    primitives_cost: list[float] = field(default_factory=list)
    primitives_time: list[float] = field(default_factory=list)


def rows(cfg: PlanBenchCfg, on_progress: OnProgress) -> Iterator[Row]:
    """Plan missions and pairs in scenes, replan some and compare with other planners.

    Args:
        cfg: Options of the benchmark.
        on_progress: Called with what is being done, and the share that is done.

    Returns:
        Rows of results.
    """
    airframe = airframe_by_name(cfg.vehicle)
    tally = _Tally()
    numbers = scene_numbers(cfg.scenes)
    # One-time compilation and building must count for no scene.
    plan_mission(load_scene(str(numbers[0])), airframe)
    prepare()
    for index, number in enumerate(numbers):
        on_progress(f"scene {number}", index / len(numbers))
        # Differences of rounded shares, so that the counts of all scenes add up.
        n_pairs = cfg.count * (index + 1) // len(numbers) - cfg.count * index // len(numbers)
        rng = np.random.default_rng([cfg.seed, number])
        _measure_scene(number, airframe, n_pairs, cfg, rng, tally)
    yield from _rows(tally)


def _measure_scene(
    number: int,
    airframe: Airframe,
    n_pairs: int,
    cfg: PlanBenchCfg,
    rng: np.random.Generator,
    tally: _Tally,
) -> None:
    scene = load_scene(str(number))
    begun_s = time.process_time()
    try:
        plan_mission(scene, airframe)
        tally.missions_ms.append(1e3 * (time.process_time() - begun_s))
    except MissionError:
        tally.n_no_mission += 1
    world = survey(scene, airframe)
    solved: list[Trajectory] = []
    for start, goal in draw_pairs(world, n_pairs, rng):
        tally.n_pairs += 1
        state = FlatReference(position_enu_m=start)
        begun_s = time.process_time()
        try:
            plan = world.plan(state, goal)
        except PlanningError as error:
            tally.failures[type(error).__name__] += 1
            continue
        tally.plans_ms.append(1e3 * (time.process_time() - begun_s))
        tally.n_sound += is_sound(world, plan)
        solved.append(plan)
        _try_primitives(world, state, goal, plan, tally)
    for plan in [*solved, *solved[:1]]:  # once more: some plans are too short to be crossed
        crossing = fly_past_a_crossing(world, plan, rng)
        tally.crossings += [] if crossing is None else [crossing]
    for plan in solved[:2]:
        tally.replans_ms += _replan_ms(world, plan)
    if solved and len(tally.above_optimum) < cfg.joint:
        tally.above_optimum += _above_optimum(world, solved[-1])


def is_sound(world: Surroundings, plan: Trajectory) -> bool:
    """Check a plan by dense samples, apart from the certificate.

    Args:
        world: World that the plan was made in.
        plan: Plan.

    Returns:
        True if no sample touches anything or breaks a limit.
    """
    times = np.arange(0.0, plan.duration_s, _CHECK_STEP_S)
    velocity, acceleration, jerk = (plan.derivatives(times, order) for order in (1, 2, 3))
    limits, quadrotor = world.limits, world.airframe.quadrotor
    asked = effort(velocity.T, acceleration.T, jerk.T, quadrotor)
    turns = np.abs(np.diff(plan.yaw.yaw_rad)) / plan.yaw.step_s
    pairs = (
        (np.hypot(velocity[:, 0], velocity[:, 1]), limits.speed_horizontal_mps),
        (np.abs(velocity[:, 2]), limits.speed_vertical_mps),
        (np.hypot(acceleration[:, 0], acceleration[:, 1]), limits.acceleration_mps2),
        (asked.specific_thrust_mps2, limits.max_specific_thrust_mps2(quadrotor)),
        (np.arccos(np.clip(asked.cos_tilt, -1, 1)), limits.tilt_rad),
        (asked.tilt_rate_radps, limits.body_rate_radps),
        (turns, limits.yaw_rate_radps),
    )
    keeps = all(values.max(initial=0.0) <= limit * (1 + _TOLERANCE) for values, limit in pairs)
    return keeps and bool(np.all(world.clearance_m(plan.positions(times)) > 0))


def cost_s(plan: Trajectory) -> float:
    """Cost that the optimiser minimises: time plus weighted squared jerk, in s."""
    jerk = float(np.sum(squared_jerk(plan.coefficients, plan.durations_s)))
    return jerk / JERK_WEIGHT_M2PS5 + plan.duration_s


def _try_primitives(
    world: Surroundings,
    start: FlatReference,
    goal: tuple[float, float, float],
    plan: Trajectory,
    tally: _Tally,
) -> None:
    begun_s = time.process_time()
    try:
        other = replace(world, method="primitives").plan(start, goal)
    except PlanningError:
        return
    tally.n_primitives += 1
    tally.primitives_ms.append(1e3 * (time.process_time() - begun_s))
    tally.primitives_cost.append(cost_s(other) / cost_s(plan))
    tally.primitives_time.append(other.duration_s / plan.duration_s)


def _replan_ms(world: Surroundings, plan: Trajectory) -> list[float]:
    """CPU times of replanning a whole plan of eight pieces from shortly after its start."""
    cfg = replace(world.planner, min_pieces=N_PIECES)
    plan = _again(world, plan, cfg)
    if len(plan.durations_s) != N_PIECES:
        return []
    spent = []
    # Within the first piece, so that all eight are still ahead.
    for share in (0.2, 0.4, 0.6):
        at_s = share * float(plan.durations_s[0])
        begun_s = time.process_time()
        replan(plan, at_s, world.obstacles, replace(world.craft, cfg=cfg))
        spent.append(1e3 * (time.process_time() - begun_s))
    return spent


def _again(world: Surroundings, plan: Trajectory, cfg: PlannerCfg) -> Trajectory:
    """Plan again between the same places, with other settings."""
    start, goal = (plan.sample(t).position_enu_m for t in (0.0, plan.duration_s))
    return plan_trajectory(
        FlatReference(position_enu_m=start),
        goal,
        world.field,
        world.obstacles,
        replace(world.craft, cfg=cfg),
    )


def _above_optimum(world: Surroundings, plan: Trajectory) -> list[float]:
    """Percentage by which a plan costs more than the joint optimum; empty if that is not found."""
    start, goal = (plan.sample(t).position_enu_m for t in (0.0, plan.duration_s))
    assert plan.corridor is not None
    best = joint_optimum(
        plan.corridor,
        np.array([start, ZERO3, ZERO3]),
        np.array([goal, ZERO3, ZERO3]),
        world.limits,
        world.airframe.quadrotor,
    )
    return [] if best is None else [100 * (cost_s(plan) / best - 1)]


def _rows(tally: _Tally) -> Iterator[Row]:
    n_solved = len(tally.plans_ms)
    pairs = max(tally.n_pairs, 1)
    yield _share("solved where a path exists", n_solved, pairs, LEAST_SOLVED)
    yield _share("plans that are sound, checked apart", tally.n_sound, max(n_solved, 1), 100.0)
    for name, count in sorted(tally.failures.items()):
        yield lower(f"failed: {name}", count, "pairs")
    yield from _times("plan", tally.plans_ms, None)
    yield from _times("whole mission", tally.missions_ms, MOST_MISSION_MS)
    if tally.n_no_mission:
        yield higher("scenes without a mission", tally.n_no_mission, "scenes")
    yield from _times(f"replan {N_PIECES} pieces, warm", tally.replans_ms, MOST_REPLAN_MS)
    n_avoided = sum(crossing.is_avoided for crossing in tally.crossings)
    n_crossings = len(tally.crossings)
    if n_crossings:
        title = f"walker crosses at up to 3 m/s: avoided, of {n_crossings}"
        yield _share(title, n_avoided, n_crossings, LEAST_AVOIDED)
        spent = [ms for crossing in tally.crossings for ms in crossing.replans_ms]
        yield from _times("replan past a walker", spent, None)
        n_gone_on = sum(crossing.has_gone_on for crossing in tally.crossings)
        yield _share("on the way to the goal again after that", n_gone_on, n_crossings, None)
        n_braked = sum(crossing.has_braked for crossing in tally.crossings)
        yield higher("of these, stopped or stepped aside", n_braked, "flights")
    if tally.above_optimum:
        above = tally.above_optimum
        title = f"cost above the joint optimum, of {len(above)}"
        yield lower(f"{title}, median", float(np.median(above)), "%", MOST_ABOVE_OPTIMUM)
        yield lower(f"{title}, worst", max(above), "%")
    yield _share("Mueller 2015: solved", tally.n_primitives, max(n_solved, 1), None)
    yield from _times("Mueller 2015: plan", tally.primitives_ms, None)
    for name, ratios in (("cost", tally.primitives_cost), ("flight time", tally.primitives_time)):
        value = float(np.median(ratios)) if ratios else math.nan
        yield lower(f"Mueller 2015: {name}, median", value, "times ours")


def _share(metric: str, count: int, of: int, target: float | None) -> Row:
    return higher(metric, 100 * count / of, "%", target)


def _times(what: str, values_ms: list[float], target: float | None) -> Iterator[Row]:
    for name, share, promised in (("median", 0.5, target), ("p95", 0.95, None)):
        value = float(np.quantile(values_ms, share)) if values_ms else math.nan
        yield lower(f"{what}, {name}", value, "CPU ms", promised)
