"""The planner's paths through scenes, and the thirds that grade difficulty."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from aeroscene.sources import load_scene
from flightsim.vehicles.catalogue import airframe_by_name
from measuring.configs import DifficultyBenchCfg
from measuring.plan_pairs import SHIPPED_SCENES
from scenarios.bench.row import OnProgress, Row, higher, lower
from scenarios.mission.difficulty import MOST_POINTS, THIRDS, Difficulty, measure_difficulty
from scenarios.mission.surroundings import MissionError

_UNITS = {"over_straight": "m/m", "seconds": "s", "quarter_turns": "", "least_clearance_m": "m"}
_SHARES = (("first third", 1 / 3), ("median", 0.5), ("second third", 2 / 3))


def rows(cfg: DifficultyBenchCfg, on_progress: OnProgress) -> Iterator[Row]:
    """Measure scenes drawn from the dataset.

    Args:
        cfg: Options of the benchmark.
        on_progress: Called with what is being done, and the share that is done.

    Returns:
        Rows of results.
    """
    airframe = airframe_by_name(cfg.vehicle)
    found: list[Difficulty] = []
    n_blocked = 0
    # Drawn, because an even spread has a rhythm in step with that of the domains.
    drawn = np.random.default_rng(0).permutation(SHIPPED_SCENES)
    numbers = sorted(drawn[: cfg.count].tolist())
    for index, number in enumerate(numbers):
        on_progress(f"scene {number}", index / len(numbers))
        try:
            found.append(measure_difficulty(load_scene(str(number)), airframe))
        except MissionError:
            n_blocked += 1
    yield lower("scenes without a way", n_blocked, "scenes")
    for name in THIRDS if found else ():
        values = [getattr(each.way, name) for each in found]
        for title, share in _SHARES:
            yield lower(f"{name}, {title}", float(np.quantile(values, share)), _UNITS[name])
    grades = Counter(each.grade for each in found)
    for grade in MOST_POINTS:
        share = 100 * grades[grade] / max(len(found), 1)
        yield higher(f"graded {grade}", share, "%")
