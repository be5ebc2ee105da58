"""`bench worlds`: many vehicles, each in a world of its own, and the environments over them.

Learning needs many worlds at once. The benchmark measures the fleet of plants on one thread and on
two, then the environments of Gymnasium over it, and the ends of their episodes.
"""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable, Iterator

import numpy as np

from aeroscene.sources import load_scene
from autonomy.types import LEVEL, ControlLevel
from flightsim.plant import Fleet, PlantCfg, compile_kernels
from flightsim.plant.cfg import ADVANCE_HZ
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import World, build_world
from scenarios.bench.configs import BenchError, WorldsBenchCfg
from scenarios.bench.episode_ends import end_rows
from scenarios.bench.offboard import offboard_rows
from scenarios.bench.peers import check_installed, peer_rows
from scenarios.bench.row import OnProgress, Row, higher, lower

LEAST_SPEED, LEAST_TRUE_SPEED = 650.0, 900.0
"""Targets in simulated seconds per wall second on two quiet cores, with sensors and without."""
LEAST_GAIN = 1.8
"""Least speed of two threads over that of one."""
LEAST_STEPS, LEAST_DEPTH_STEPS = 30_000.0, 2_000.0
"""Targets in steps of an environment a second."""
DEPTH_PX = (64, 64)
_CLIMB_M = 6.0
_DEPTH_SHARE = 0.1
"""Share of the benchmark's duration for images, which take long."""
_ROUNDS = 10
"""Turns of one thread and two, so that a slow moment of the machine meets both alike."""


def rows(cfg: WorldsBenchCfg, on_progress: OnProgress) -> Iterator[Row]:
    """Run every part of the benchmark.

    Args:
        cfg: Options of the benchmark.
        on_progress: Called before each part.

    Raises:
        SceneError: If there is no such scene.
        AirframeError: If there is no such vehicle.
        BenchError: If gymnasium or a peer is not installed, or the vehicles do not fly.
    """
    # Optional packages first, so that a missing one is reported before minutes of work.
    if importlib.util.find_spec("gymnasium") is None:
        raise BenchError("gymnasium is not installed; valid: pip install 'aeroscene[rl]'")
    check_installed(cfg.peers)
    compile_kernels()
    airframe = airframe_by_name(cfg.vehicle)
    worlds = [build_world(load_scene(name), airframe) for name in cfg.scenes]
    on_progress("worlds", 0.0)
    around = [worlds[i % len(worlds)] for i in range(cfg.worlds)]
    yield from _fleet_rows(around, cfg)
    on_progress("worlds without sensors", 0.4)
    yield from _true_state_rows(around, cfg)
    on_progress("environments", 0.6)
    yield from _environment_rows(cfg)
    on_progress("environments that an autopilot flies", 0.75)
    yield from offboard_rows(cfg)
    on_progress("ends of episodes", 0.8)
    yield from end_rows(cfg)
    if cfg.peers:
        on_progress("peers", 0.9)
        yield from peer_rows(cfg.peers, cfg.seconds)
    on_progress("done", 1.0)


def _fleet_rows(worlds: list[World], cfg: WorldsBenchCfg) -> Iterator[Row]:
    sensing = [PlantCfg(seed=i, aiding="auto") for i in range(len(worlds))]
    wall_s, cpu_s = _fly(worlds, sensing, cfg.seconds)
    sim_s = len(worlds) * cfg.seconds
    what = f"{len(worlds)} worlds with sensors, filter and control"
    yield higher(f"{what}, one thread", sim_s / wall_s[0], "simulated s / wall s")
    yield higher(f"{what}, two threads", sim_s / wall_s[1], "simulated s / wall s", LEAST_SPEED)
    yield higher("two threads over one", wall_s[0] / wall_s[1], "", LEAST_GAIN)
    yield higher(f"{what}, one thread", sim_s / cpu_s[0], "simulated s / CPU s")
    yield lower("CPU time on two threads over one", cpu_s[1] / cpu_s[0], "")
    # One world alone is fast, so it is stepped ten times as long.
    with _hovering(worlds[:1], sensing[:1], 1) as one:
        _, one_s = _time(one.advance, round(10 * cfg.seconds * ADVANCE_HZ))
    yield higher("one world", 10 * cfg.seconds / one_s, "simulated s / CPU s")


def _true_state_rows(worlds: list[World], cfg: WorldsBenchCfg) -> Iterator[Row]:
    """Yield figures of plants as environments use them by default, with the true state."""
    true = [PlantCfg(seed=i, state="truth", has_sensors=False) for i in range(len(worlds))]
    wall_s, cpu_s = _fly(worlds, true, cfg.seconds)
    sim_s, what = len(worlds) * cfg.seconds, f"{len(worlds)} worlds by the true state, no sensors"
    title = f"{what}, two threads"
    yield higher(title, sim_s / wall_s[1], "simulated s / wall s", LEAST_TRUE_SPEED)
    yield higher(f"{what}, one thread", sim_s / cpu_s[0], "simulated s / CPU s")


def _fly(worlds: list[World], cfgs: list[PlantCfg], seconds: float) -> tuple[list[float], ...]:
    """Return wall times and CPU times of flying on one thread and on two."""
    wall_s, cpu_s = [0.0, 0.0], [0.0, 0.0]
    n_steps = round(seconds / _ROUNDS * ADVANCE_HZ)
    with _hovering(worlds, cfgs, 1) as alone, _hovering(worlds, cfgs, 2) as together:
        for _ in range(_ROUNDS):
            for i, fleet in enumerate((alone, together)):
                spent = _time(fleet.advance, n_steps)
                wall_s[i], cpu_s[i] = wall_s[i] + spent[0], cpu_s[i] + spent[1]
        # Vehicles that fell would have been measured in contact with the ground.
        for fleet in (alone, together):
            _check_flight(fleet)
    return wall_s, cpu_s


def _hovering(worlds: list[World], cfgs: list[PlantCfg], n_threads: int) -> Fleet:
    """Return a fleet whose vehicles hold their places above the start, estimators aligned."""
    fleet = Fleet(worlds, cfgs, n_threads=n_threads)
    starts_enu_m = np.array([world.scene.start_position_enu_m for world in worlds])
    places_enu_m = starts_enu_m + np.array([0.0, 0.0, _CLIMB_M])
    # Held in the air while estimators align, then released: no take-off needs to be simulated.
    for i, (place, plant_cfg) in enumerate(zip(places_enu_m.tolist(), cfgs, strict=True)):
        fleet.restart(i, plant_cfg.seed, plant_cfg.wind, held_at=[(place, LEVEL)])
    fleet.align(range(len(worlds)))
    for i in range(len(worlds)):
        fleet.release(i)
    fleet.setpoints["position_enu_m"] = places_enu_m
    fleet.setpoints["level"] = ControlLevel.TRAJECTORY
    return fleet


def _check_flight(fleet: Fleet) -> None:
    start_m = [world.scene.start_position_enu_m[2] for world in fleet.worlds]
    heights_m = fleet.history["position_true_enu_m"][:, -1, 2] - start_m
    if not np.all(heights_m > 0.5 * _CLIMB_M):
        raise BenchError(f"world {int(np.argmin(heights_m))}: the vehicle did not stay in the air")


def _environment_rows(cfg: WorldsBenchCfg) -> Iterator[Row]:
    from scenarios.environments import AeroSceneVectorEnv, EnvironmentCfg, ObservationCfg

    n_steps = round(cfg.seconds * ADVANCE_HZ)
    width, height = DEPTH_PX
    for what, observation, share, target in (
        ("state", ObservationCfg(), 1.0, LEAST_STEPS),
        (
            f"{width} x {height} depth",
            ObservationCfg(depth=DEPTH_PX),
            _DEPTH_SHARE,
            LEAST_DEPTH_STEPS,
        ),
    ):
        env_cfg = EnvironmentCfg(vehicle=cfg.vehicle, action="velocity", observation=observation)
        env = AeroSceneVectorEnv("hover", cfg.worlds, cfg.scenes, env_cfg, 2)
        env.reset(seed=0)
        # Zero velocity keeps every vehicle where it is, so that no episode ends.
        actions = np.zeros((cfg.worlds, 4))
        n = max(1, round(share * n_steps))
        wall_s, cpu_s = _time(lambda env=env, actions=actions: env.step(actions), n)
        env.close()
        title = f"environments, {what}, two threads"
        yield higher(title, cfg.worlds * n / wall_s, "steps of 20 ms / wall s", target)
        yield higher(title, cfg.worlds * n / cpu_s, "steps of 20 ms / CPU s")


def _time(step: Callable[[], object], n: int) -> tuple[float, float]:
    """Return wall time, and CPU time of all threads, for n steps."""
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    for _ in range(n):
        step()
    return time.perf_counter() - wall_s, time.process_time() - cpu_s
