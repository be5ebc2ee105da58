"""Part of `bench worlds`: cost of the end of an episode, and steps with many ends.

A learner ends episodes all the time, above all at the start of its training. An environment that is
fast only while nothing ends would mislead. The cost of one end is the slope of a line through the
times of steps with few and with many ends, so steps need not be stopped to measure it.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flightsim.plant.cfg import ADVANCE_HZ
from scenarios.bench.configs import BenchError, WorldsBenchCfg
from scenarios.bench.row import Row, higher, lower

if TYPE_CHECKING:  # an extra: whoever has no gymnasium is told so
    from scenarios.environments.cfg import ActionLevel

LEAST_STEPS_WITH_ENDS = 42_000.0
"""Target in steps of environments a second, on two quiet cores."""
MOST_END_MS, MOST_DRAWN_END_MS = 0.1, 0.5
"""Targets of an end, without and with a landing area that is drawn for the next episode."""
_LEAST_STEPS = 200
"""Number of steps after which vehicles that sink from five metres are down."""


@dataclass(frozen=True, kw_only=True)
class _Policy:
    """A constant action that ends episodes in its own way."""

    task: str
    says: str
    action: tuple[float, float, float, float]
    level: ActionLevel = "velocity"
    episode_s: float | None = None


_FALLING = _Policy(task="hover", says="that fall", action=(-1.0, 0.3, 0.0, 0.0), level="rates")
_STAYING = (0.0, 0.0, 0.0, 0.0)
_TIMED = _Policy(task="hover", says="whose time is up", action=_STAYING, episode_s=1.0)
_DRAWN = _Policy(task="landing", says="whose time is up", action=_STAYING, episode_s=1.0)
_SINKING = _Policy(task="landing", says="that sink until they rest", action=(0.0, 0.0, -1.0, 0.0))


def end_rows(cfg: WorldsBenchCfg) -> Iterator[Row]:
    """Step environments with actions that end their episodes.

    Args:
        cfg: Options of the benchmark.

    Raises:
        BenchError: If none ends.
    """
    wall_s, cpu_s, n_ends = _step(_FALLING, cfg, n_threads=2)
    n = cfg.worlds * len(cpu_s)
    title = f"environments that fall, {n_ends.sum()} ends in {n} steps, two threads"
    yield higher(title, n / wall_s.sum(), "steps of 20 ms / wall s", LEAST_STEPS_WITH_ENDS)
    yield higher(title, n / cpu_s.sum(), "steps of 20 ms / CPU s")
    # On one thread, so that a step's CPU time is all its own.
    for policy, target in (
        (_TIMED, MOST_END_MS),
        (_FALLING, None),
        (_DRAWN, MOST_DRAWN_END_MS),
        (_SINKING, None),
    ):
        _, cpu_s, n_ends = _step(policy, cfg, n_threads=1)
        # A line through the times of steps with few and with many ends: its slope is an end.
        end_s = float(np.polyfit(n_ends, cpu_s, 1)[0])
        title = f"an end of {policy.task} episodes {policy.says}"
        yield lower(title, 1e3 * end_s, "CPU ms", target)


def _step(
    policy: _Policy, cfg: WorldsBenchCfg, n_threads: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return wall time, CPU time and number of ends of each step."""
    from scenarios.environments import AeroSceneVectorEnv, EnvironmentCfg

    env_cfg = EnvironmentCfg(vehicle=cfg.vehicle, action=policy.level, episode_s=policy.episode_s)
    env = AeroSceneVectorEnv(policy.task, cfg.worlds, cfg.scenes, env_cfg, n_threads)
    env.reset(seed=0)
    actions = np.tile(policy.action, (cfg.worlds, 1))
    steps: list[tuple[float, float, int]] = []
    for _ in range(max(_LEAST_STEPS, round(cfg.seconds * ADVANCE_HZ))):
        wall_s, cpu_s = time.perf_counter(), time.process_time()
        _, _, is_terminated, is_truncated, _ = env.step(actions)
        wall_s, cpu_s = time.perf_counter() - wall_s, time.process_time() - cpu_s
        steps.append((wall_s, cpu_s, int((is_terminated | is_truncated).sum())))
    env.close()
    walls_s, cpus_s, n_ends = np.array(steps).T
    if not n_ends.any():
        raise BenchError(f"{policy.task}: no episode has ended in {len(steps)} steps")
    return walls_s, cpus_s, n_ends.astype(int)
