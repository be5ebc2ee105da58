"""`aeroscene campaign`: fly many trials and score the pilot."""

from __future__ import annotations

import signal
import sys
from collections import Counter
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro
from rich.console import Console

from aeroscene.corpus.corpus import CORPUS_SIZE
from aeroscene.processes import default_jobs
from scenarios.cli.command_line import EXIT_DONE, default_hint, fail, fail_on_file, print_json
from scenarios.cli.progress import progress_bar
from scenarios.cli.report import print_summary
from scenarios.cli.scene_numbers import SceneNumbersError, scene_numbers
from scenarios.run.levels import RecordLevel

if TYPE_CHECKING:
    from scenarios.campaigns.fixed import FixedSuite
    from scenarios.campaigns.flyer import Suite, Trial

_PROG = "aeroscene campaign"
_MOST_TRIALS = 1_000_000


@dataclass(frozen=True, kw_only=True)
class CampaignCfg:
    """Fly trials of a pilot in many scenes and score them.

    Trial N of a scene and a vehicle is always the same one. A campaign that was stopped, also by
    kill -9, goes on where it was by the same command; more scenes, vehicles or trials are added by
    naming more.
    """

    out: Path
    """Folder of the results; made where it is missing."""
    scenes: str = "0:10"
    """Numbers of scenes of the dataset: A:B without B, single ones, joined by commas."""
    trials: int = 30
    """Trials of each scene with each vehicle."""
    vehicles: str = "iris,hummingbird"
    """Airframes by their names, joined by commas."""
    pilot: str = "demo"
    """Who flies: demo is ours, mueller the same with motion primitives for a planner; potential
    goes through a potential field, straight flies straight lines without looking; or MODULE:CLASS
    of your own, see docs/campaigns.md."""
    recipe: Annotated[Path | None, default_hint("the one in docs/campaigns.md")] = None
    """TOML file that says what the tasks are drawn from: starts, wind, traffic, sensors, map."""
    suite: Annotated[str | None, default_hint("none")] = None
    """Fixed suite, such as aeroscene-300: names scenes, trials, vehicles and recipe by itself."""
    record: Literal["none"] | RecordLevel = "none"
    """What is recorded of each trial, as OUT/recordings/SCENE-VEHICLE-TRIAL.rrd, see
    docs/recording.md; the flights are the same."""
    workers: int = field(default_factory=default_jobs)
    """Processes; the default is the number of cores."""
    patience: float = 900.0
    """Wall time for one trial in s, after which its process is ended and the trial counts as
    failed."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: trials, success_rate, interval_95, phases, groups, codes, and more;
    the same as OUT/summary.json."""


def run(cfg: CampaignCfg) -> int:
    """Fly the campaign; exit status 2 with one line where input or folder do not allow it."""
    # Imported here because it is the whole simulator, which `--help` does not need.
    from scenarios.baselines.named import PilotError  # noqa: PLC0415
    from scenarios.campaigns.campaign import CampaignError  # noqa: PLC0415
    from scenarios.campaigns.fixed import FixedSuiteError  # noqa: PLC0415
    from scenarios.campaigns.store import StoreError  # noqa: PLC0415
    from scenarios.campaigns.workers import WorkerError  # noqa: PLC0415

    # SIGTERM is handled as Ctrl-C is: processes and folder are left in order.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        summary = _fly(cfg)
    except (
        CampaignError,
        FixedSuiteError,
        StoreError,
        WorkerError,
        PilotError,
        SceneNumbersError,
    ) as error:
        fail(_PROG, str(error))
    except OSError as error:
        fail_on_file(_PROG, error)
    except KeyboardInterrupt:
        sys.stderr.write(f"{_PROG}: stopped; the same command goes on from here\n")
        raise
    if cfg.json:
        print_json({"folder": str(cfg.out), **summary})
    else:
        print_summary(Console(), summary)
        print(f"More: aeroscene report {cfg.out}")
    return EXIT_DONE


def _fly(cfg: CampaignCfg) -> dict[str, Any]:
    """Fly what is left, and return the summary of all."""
    from scenarios.campaigns.campaign import open_campaign  # noqa: PLC0415 - see `run`
    from scenarios.campaigns.store import read_results  # noqa: PLC0415

    trials = _trials(cfg)
    with open_campaign(cfg.out, _suite(cfg)) as campaign:
        left = campaign.left(trials)
        sys.stderr.write(f"{_PROG}: {len(left)} of {len(trials)} trials to fly\n")
        verdicts = Counter(read_results(cfg.out, ["success"])["success"].to_pylist())
        rows = campaign.fly(left, workers=cfg.workers, patience_s=cfg.patience)
        with closing(rows), progress_bar("", len(left), "trials") as advance:
            for row in rows:
                verdicts[row["success"]] += 1
                n_judged = verdicts[True] + verdicts[False]
                rate = f"{verdicts[True] / n_judged:.1%}" if n_judged else "none"
                advance(1, title=f"success so far {rate}")
        return campaign.summary()


def _trials(cfg: CampaignCfg) -> list[Trial]:
    """All trials that are asked for; bad input ends the process."""
    from flightsim.vehicles import airframe_by_name  # noqa: PLC0415 - see `run`
    from scenarios.campaigns.campaign import all_trials  # noqa: PLC0415

    if not 1 <= cfg.trials <= _MOST_TRIALS:
        fail(_PROG, f"trials {cfg.trials} is out of range; valid: 1 to {_MOST_TRIALS}")
    if cfg.workers < 1:
        fail(_PROG, f"workers {cfg.workers} is too few; valid: 1 or more")
    if not cfg.patience > 0:
        fail(_PROG, f"patience {cfg.patience} is not valid; valid: seconds above 0")
    if cfg.suite is not None:
        return _fixed(cfg, cfg.suite).all_trials()
    numbers = scene_numbers(cfg.scenes)
    if numbers[-1] >= CORPUS_SIZE:
        fail(_PROG, f"scenes {cfg.scenes!r} has no scene {numbers[-1]}; valid: 0:{CORPUS_SIZE}")
    vehicles = list(dict.fromkeys(cfg.vehicles.split(",")))
    for vehicle in vehicles:
        airframe_by_name(vehicle)
    return all_trials(map(str, numbers), vehicles, cfg.trials)


def _suite(cfg: CampaignCfg) -> Suite:
    from scenarios.campaigns.flyer import RECORDINGS, Recordings, Suite  # noqa: PLC0415 - see `run`
    from scenarios.tasks.recipe import Recipe, read_recipe  # noqa: PLC0415

    if cfg.suite is not None:
        recipe = _fixed(cfg, cfg.suite).recipe
    else:
        recipe = Recipe() if cfg.recipe is None else read_recipe(cfg.recipe)
    recordings = None
    if cfg.record != "none":
        recordings = Recordings(folder=cfg.out / RECORDINGS, level=cfg.record)
    return Suite(recipe=recipe, pilot=cfg.pilot, recordings=recordings)


def _fixed(cfg: CampaignCfg, name: str) -> FixedSuite:
    """The fixed suite of a name; options beside it that it would overrule end the process."""
    from scenarios.campaigns.fixed import fixed_suite  # noqa: PLC0415 - see `run`

    for option in ("scenes", "trials", "vehicles", "recipe"):
        if getattr(cfg, option) != getattr(CampaignCfg, option):
            fail(_PROG, f"{option} is fixed by suite {name!r}; valid: one of the two")
    return fixed_suite(name)
