"""Part of `bench worlds`: steps of the environment that a whole autopilot flies.

One process flies one vehicle, so the figure is of one core. Each kind of set point has a row,
because some take more messages and more control than others.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import get_args

import numpy as np

from scenarios.bench.configs import WorldsBenchCfg
from scenarios.bench.row import Row, higher

LEAST_STEPS = 500.0
"""Target in steps a CPU second of one core: 1,000 a second on two."""
_N_STEPS = 400
"""Number of steps, 8 s of an episode of hovering, which is longer."""
_N_RESETS = 5


def offboard_rows(cfg: WorldsBenchCfg) -> Iterator[Row]:
    """Yield the figures of each kind of set point, then the beginning of an episode.

    Args:
        cfg: Options of the benchmark, of which scene and vehicle count here.

    Raises:
        AutopilotError: If the vehicle does not take off.
    """
    from scenarios.environments import AeroSceneEnv, AutopilotCfg, EnvironmentCfg
    from scenarios.environments.cfg import ActionLevel

    for level in get_args(ActionLevel):
        if level == "motors":
            continue
        env_cfg = EnvironmentCfg(vehicle=cfg.vehicle, action=level)
        env = AeroSceneEnv("hover", cfg.scenes[0], env_cfg, autopilot=AutopilotCfg())
        env.reset(seed=0)
        n_steps, spent_s, action = 0, 0.0, np.zeros(4)
        while n_steps < _N_STEPS:
            began_s = time.process_time()
            _, _, is_terminated, is_truncated, _ = env.step(action)
            spent_s += time.process_time() - began_s
            n_steps += 1
            # Without feedback, bare thrust drifts off in the end.
            if is_terminated or is_truncated:
                env.reset()
        title = f"environments, autopilot by {level}, one vehicle"
        yield higher(title, n_steps / spent_s, "steps of 20 ms / CPU s", LEAST_STEPS)
        if level == "velocity":
            began_s = time.process_time()
            for _ in range(_N_RESETS):
                env.reset()
            each_s = (time.process_time() - began_s) / _N_RESETS
            yield higher("environments, autopilot, begins", 1.0 / each_s, "episodes / CPU s")
        env.close()
