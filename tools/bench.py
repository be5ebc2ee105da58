"""Measure what we build on: planner, estimator, landing, contacts, growing maps, difficulty.

    python tools/bench.py plan
    python tools/bench.py estimate --count 20 --json

`aeroscene bench` measures what users ask about: this machine, a scene model, a vehicle. Exit status
0 if every target is met, else 1.
"""

from __future__ import annotations

import importlib
import sys
from dataclasses import dataclass
from typing import Annotated

import tyro
from measuring.configs import (
    ApproachesBenchCfg,
    DifficultyBenchCfg,
    EncountersBenchCfg,
    EstimateBenchCfg,
    GrowBenchCfg,
    LandBenchCfg,
    PlanBenchCfg,
)

from scenarios.cli.bench import measure
from scenarios.cli.command_line import parse

PROG = "tools/bench.py"

# The name of a benchmark is that of its module in `measuring` and of its word on the command line.
NAMES = {
    EstimateBenchCfg: "estimate",
    PlanBenchCfg: "plan",
    DifficultyBenchCfg: "difficulty",
    LandBenchCfg: "land",
    EncountersBenchCfg: "encounters",
    ApproachesBenchCfg: "approaches",
    GrowBenchCfg: "grow",
}

Bench = (
    Annotated[EstimateBenchCfg, tyro.conf.subcommand("estimate", prefix_name=False)]
    | Annotated[PlanBenchCfg, tyro.conf.subcommand("plan", prefix_name=False)]
    | Annotated[DifficultyBenchCfg, tyro.conf.subcommand("difficulty", prefix_name=False)]
    | Annotated[LandBenchCfg, tyro.conf.subcommand("land", prefix_name=False)]
    | Annotated[EncountersBenchCfg, tyro.conf.subcommand("encounters", prefix_name=False)]
    | Annotated[ApproachesBenchCfg, tyro.conf.subcommand("approaches", prefix_name=False)]
    | Annotated[GrowBenchCfg, tyro.conf.subcommand("grow", prefix_name=False)]
)


@dataclass(frozen=True, kw_only=True)
class BenchCfg:
    """Measure the planner, the estimator, encounters, approaches, growing maps, or difficulty.

    Exit status 0 if every target is met, else 1.
    """

    bench: Bench


def main(args: list[str]) -> int:
    """Run the benchmark of the command line.

    Returns:
        Exit status: 0 if every target is met, else 1.
    """
    cfg = parse(BenchCfg, PROG, args).bench
    name = NAMES[type(cfg)]
    # Imported here, so that no benchmark waits for the libraries of the others.
    return measure(PROG, name, cfg, importlib.import_module(f"measuring.{name}"))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
