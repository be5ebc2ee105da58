"""Cost of a trial where the map grows, among movers, and in both: `tools/bench.py grow`.

Each trial is flown as in a campaign, in this one process; the first trial of each kind pays for the
planner's programs and is not counted. A trial's task counts, as in a campaign's rows.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from measuring.configs import GrowBenchCfg
from measuring.plan_pairs import SHIPPED_SCENES
from scenarios.bench.row import OnProgress, Row, higher, lower
from scenarios.campaigns.flyer import Flyer, NoFlightCode, Suite, Trial
from scenarios.campaigns.flyer import Row as TrialRow
from scenarios.tasks.recipe import Recipe

_CROWD = ("people=6,cars=3,drones=1",)
KINDS: Mapping[str, Recipe] = {
    "growing map": Recipe(map=("onboard",)),
    "crowd": Recipe(traffic=_CROWD),
    "both": Recipe(map=("onboard",), traffic=_CROWD),
}
MOST_CPU_S = 12.0
# Coprime to the number of scenes.
_STEP = 613
"""Scenes are taken in steps of this many, which visit all of them in turn."""
_MOST_SCENES_A_TRIAL = 4
"""Scenes that are looked at for each trial: some have no task, or no room for a crowd."""


def rows(cfg: GrowBenchCfg, on_progress: OnProgress) -> Iterator[Row]:
    """Fly trials of each kind, and sum up their costs and results.

    Args:
        cfg: Options of the benchmark.
        on_progress: Called with what is being done, and the share that is done.

    Returns:
        Rows of results.
    """
    for n, (kind, recipe) in enumerate(KINDS.items()):
        with Flyer(Suite(recipe=recipe)) as flyer:
            on_progress(kind, n / len(KINDS))
            flown = list(_flown(cfg, flyer))
        if not flown:
            continue
        spent_s = [row["trial_cpu_seconds"] for row in flown]
        yield lower(f"{kind}: CPU, median", float(np.median(spent_s)), "s", MOST_CPU_S)
        yield lower(f"{kind}: CPU, most", max(spent_s), "s", MOST_CPU_S)
        share = [row["trial_cpu_seconds"] / row["sim_seconds"] for row in flown]
        yield lower(f"{kind}: CPU a simulated second, median", float(np.median(share)), "s")
        yield higher(f"{kind}: landed", 100 * sum(map(_landed, flown)) / len(flown), "%")


def _flown(cfg: GrowBenchCfg, flyer: Flyer) -> Iterator[TrialRow]:
    """Rows of the trials but the first, which warms the process up."""
    # From -1, so that the first flight is number 0 and not counted.
    n_flown, number = -1, cfg.seed
    for _ in range(_MOST_SCENES_A_TRIAL * (cfg.count + 1)):
        if n_flown == cfg.count:
            return
        row = flyer.fly(Trial(str(number % SHIPPED_SCENES), cfg.vehicle, 0))
        number += _STEP
        if row["code"] in (NoFlightCode.NO_TASK, NoFlightCode.NO_PLAN):
            continue
        n_flown += 1
        if n_flown:
            yield row


def _landed(row: TrialRow) -> bool:
    return bool(row["success"])
