"""`aeroscene campaign`: fly many trials and score the pilot."""

from __future__ import annotations

import re
import signal
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from datetime import timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from aeroscene.corpus.corpus import CORPUS_SIZE
from aeroscene.processes import default_jobs
from aeroscene.ranges import Range
from scenarios.campaigns.equipment import CameraHz, Equipment
from scenarios.campaigns.recordings import RECORDINGS, Recordings
from scenarios.cli.campaign_limits import MOST_TRIALS, MOST_WORKERS
from scenarios.cli.campaign_progress import CampaignProgress
from scenarios.cli.command_line import (
    EXIT_DONE,
    EXIT_NEGATIVE,
    default_hint,
    fail,
    interrupt,
    print_json,
)
from scenarios.cli.outputs import OutFolder
from scenarios.cli.progress import progress_bar
from scenarios.cli.report import print_summary
from scenarios.cli.scene_numbers import SceneNumbersError, scene_numbers
from scenarios.cli.terminal import shell, terminal
from scenarios.run.levels import RecordLevel

if TYPE_CHECKING:
    from scenarios.campaigns.engines.crew import Engine
    from scenarios.campaigns.fixed import FixedSuite
    from scenarios.campaigns.flight_stack import FlightStack
    from scenarios.campaigns.flyer import Suite, Trial
    from scenarios.chat.completions import ChatModel

_PROG = "aeroscene campaign"
# Scenes that `load_scene` composes from a seed; they mix with numbers in --scenes.
_DISTRICT = re.compile(r"district:[0-9]{1,9}")
_MOST_INSTANCE = 99
"""The last of `MAX_INSTANCES`, which the testbench has; `--help` should not load it."""


@dataclass(frozen=True, kw_only=True)
class CampaignCfg:
    """Fly trials of a pilot in many scenes and score them.

    Trial N of a scene and a vehicle is always the same one. If a campaign was stopped, even by kill
    -9, the same command continues it. To add scenes, vehicles or trials, name more of them. Exit
    status 1 if every trial raised, hung or died, so that nothing is scored.
    """

    out: Annotated[Path, OutFolder()]
    """Folder of the results; it is made if it is missing."""
    scenes: str = "0:10"
    """Numbers of scenes of the dataset: A:B without B, single ones, and districts as district:SEED,
    joined by commas; or one place on a map as FILE.osm#W,S,E,N."""
    trials: Annotated[int, Range(1, MOST_TRIALS)] = 30
    """Trials of each scene with each vehicle."""
    vehicles: str = "iris,hummingbird"
    """Airframes by their names, or files FILE.toml that describe them, joined by commas."""
    pilot: str = "demo"
    """Pilot to score. demo is ours; mueller is the same with motion primitives as its planner;
    potential follows a potential field; straight flies straight lines without looking; random,
    nearest, perfect and vlm are for goals in words, see docs/goals.md; policy:FILE is a policy that
    was learnt (.zip of Stable-Baselines3, .onnx), see docs/learning.md; MODULE:CLASS is a class of
    your own, mavlink a program of your own over MAVLink, see docs/campaigns.md."""
    program: Annotated[str | None, tyro.conf.arg(help_behavior_hint="")] = None
    """With --pilot mavlink: command that flies each trial, with its task as a line of JSON on
    standard input. By default your clients connect by themselves, and each task is a line on
    standard output."""
    endpoint: Annotated[str | None, tyro.conf.arg(help_behavior_hint="")] = None
    """With --pilot vlm: address of a vision-language model that answers chat/completions as
    OpenAI's does, such as http://127.0.0.1:8080/v1. OPENAI_API_KEY is sent if it is set, over https
    and to this machine only."""
    model: str = "default"
    """With --endpoint: name of the model there."""
    autopilot: Literal["builtin", "px4", "ardupilot"] = "builtin"
    """Flight stack that the pilot commands: ours, or one of its own, see docs/flight_stacks.md."""
    autopilot_binary: Annotated[str | None, tyro.conf.arg(help_behavior_hint="")] = None
    """With --autopilot: program of that flight stack, started anew for each trial."""
    instance: Annotated[int, Range(0, _MOST_INSTANCE)] = 0
    """With --pilot mavlink, without --program: the first worker waits on TCP port 5760 + 10 N of
    loopback, each further one on the next such port. With --autopilot: the first worker has the
    ports of instance N, each further one those of the next."""
    recipe: Annotated[str | None, default_hint("the one in docs/campaigns.md")] = None
    """Recipe from which tasks are drawn: a TOML file that names starts, wind, traffic, sensors and
    map; or one of the families that ship, such as crowd or storm, see docs/families.md."""
    suite: Annotated[str | None, default_hint("none")] = None
    """Fixed suite, aeroscene-300 or aeroscene-hard, which sets scenes, trials, vehicles and recipes
    itself."""
    families: Annotated[str, default_hint("all")] = ""
    """With a suite of families: the families to fly, joined by commas. You can fly the others later
    in the same folder."""
    record: Literal["none"] | RecordLevel = "none"
    """Level of detail of each trial's recording, OUT/recordings/SCENE-VEHICLE-TRIAL.rrd, see
    docs/recording.md. Recording does not change the flights."""
    camera_hz: CameraHz = 5.0
    """With --record: frames of each camera in a simulated second."""
    # Without a text of its own here, tyro would look for one in the sources.
    equipment: Annotated[Equipment, tyro.conf.arg(help="Cameras and sensors of the vehicles.")] = (
        field(default_factory=Equipment)
    )
    workers: Annotated[int, Range(1, MOST_WORKERS)] = field(default_factory=default_jobs)
    """Processes; the default is the number of cores."""
    engine: Literal["local", "ray"] = "local"
    """local runs the processes on this machine, ray on a cluster of Ray (aeroscene[cluster])."""
    ray_address: Annotated[str | None, tyro.conf.arg(help_behavior_hint="")] = None
    """With --engine ray: address of the cluster, such as auto or ray://HOST:10001. By default Ray
    is started on this machine, on loopback only, and ended afterwards."""
    patience: Annotated[float, Range(0.0, unit="s", is_above=True)] = 900.0
    """Wall time for one trial, after which its process is ended and the trial counts as failed."""
    dry_run: bool = False
    """Fly nothing. Report how many trials would be flown, and how long that would take by the cost
    of those in OUT."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: trials, success_rate, interval_95, phases, groups, codes, and more;
    the same as OUT/summary.json."""


def run(cfg: CampaignCfg) -> int:
    """Fly the trials that are not in the folder yet, and print the summary of all.

    Returns:
        0, or 1 if every trial raised, hung or died. Bad input or an unusable folder ends the
        process with status 2 and one line.
    """
    # Imported here because it is the whole simulator, which `--help` does not need.
    from scenarios.baselines.named import PilotError
    from scenarios.campaigns.campaign import CampaignError
    from scenarios.campaigns.engines.crew import WorkerError
    from scenarios.campaigns.external.program import ProgramError
    from scenarios.campaigns.fixed import FixedSuiteError
    from scenarios.campaigns.flight_stack import FlightStackError
    from scenarios.campaigns.store import StoreError

    # SIGTERM is handled as Ctrl-C is: processes and folder are left in order.
    signal.signal(signal.SIGTERM, interrupt)
    refusals = (
        *(CampaignError, FixedSuiteError, StoreError, WorkerError),
        *(PilotError, ProgramError, FlightStackError, SceneNumbersError),
    )
    try:
        if cfg.dry_run:
            return _plan(cfg)
        summary = _fly(cfg)
    # Refusals of pilots, programs and folders; scenes and airframes end in `boundary.one_line`.
    except refusals as error:
        fail(_PROG, str(error))
    except KeyboardInterrupt:
        sys.stderr.write(f"{_PROG}: stopped; the same command goes on from here\n")
        raise
    if cfg.json:
        print_json({"folder": str(cfg.out), **summary})
    else:
        print_summary(terminal(), summary)
        print(f"More: {shell('aeroscene', 'report', cfg.out)}")
    return EXIT_NEGATIVE if _has_only_failed_flights(summary) else EXIT_DONE


def _has_only_failed_flights(summary: Mapping[str, Any]) -> bool:
    """Return true if the pilot or its process failed in every trial, so that none is scored."""
    from scenarios.campaigns.flyer import NoFlightCode

    failed_flights = {NoFlightCode.RAISED.value, NoFlightCode.HUNG.value, NoFlightCode.DIED.value}
    return bool(summary["codes"]) and failed_flights.issuperset(summary["codes"])


def _fly(cfg: CampaignCfg) -> dict[str, Any]:
    """Fly the trials that are left, and return the summary of all."""
    from scenarios.campaigns.campaign import open_campaign
    from scenarios.campaigns.store import read_results

    trials, suite = _trials(cfg), _suite(cfg)
    with open_campaign(cfg.out, suite) as campaign:
        remaining = campaign.remaining(trials)
        sys.stderr.write(f"{_PROG}: {len(remaining)} of {len(trials)} trials to fly\n")
        # The rate that the bar shows is of the whole campaign, earlier runs of it included.
        known = read_results(cfg.out, ["success"])["success"].to_pylist()
        news = CampaignProgress(
            cfg.out, len(remaining), known, has_bar=terminal(stderr=True).is_terminal
        )
        with _engine(cfg, suite) as engine, progress_bar("", len(remaining), "trials") as advance:
            rows = campaign.fly(remaining, engine, workers=cfg.workers, patience_s=cfg.patience)
            for row in rows:
                news.add(row, advance)
        return campaign.summary()


def _plan(cfg: CampaignCfg) -> int:
    """Print how many trials would be flown, and how long that would take."""
    from scenarios.campaigns.campaign import require_same_suite
    from scenarios.campaigns.engines.forecast import forecast, measured_costs
    from scenarios.campaigns.store import JOURNAL, SCHEMA, read_results

    trials, suite = _trials(cfg), _suite(cfg)
    suite.require_pilot()
    # The real run would refuse a folder of another pilot or recipe; so does the plan.
    require_same_suite(cfg.out, suite)
    has_any = (cfg.out / JOURNAL).is_file()
    table = read_results(cfg.out) if has_any else SCHEMA.empty_table()
    done = set(table["trial_id"].to_pylist())
    remaining = [trial for trial in trials if trial.id not in done]
    costs = measured_costs(table)
    # Without a flown trial there is no measured cost, and so no forecast.
    takes = forecast(remaining, costs, cfg.workers) if remaining and costs else None
    if cfg.json:
        facts = {} if takes is None else asdict(takes)
        print_json(
            {"trials": len(trials), "to_fly": len(remaining), "workers": cfg.workers, **facts}
        )
        return EXIT_DONE
    print(f"{len(remaining)} of {len(trials)} trials to fly")
    if takes is not None:
        wall = timedelta(seconds=round(takes.wall_seconds))
        print(
            f"{wall} h on {cfg.workers} workers with a core each: "
            f"{takes.cpu_seconds / 3600:.1f} core hours, {takes.share_at_work:.1%} at work"
        )
    elif remaining:
        print(f"How long that takes can be told when some trials have been flown in {cfg.out}")
    return EXIT_DONE


def _trials(cfg: CampaignCfg) -> list[Trial]:
    """Return all trials that are asked for; bad input ends the process."""
    from flightsim.vehicles import airframe_by_name
    from scenarios.campaigns.campaign import all_trials

    if cfg.suite is not None:
        return _chosen(cfg, _fixed(cfg, cfg.suite))
    if cfg.families:
        fail(
            _PROG,
            f"families {cfg.families!r} needs a suite of families; valid: --recipe NAME for one",
        )
    scenes = _scenes(cfg.scenes)
    # `dict.fromkeys` removes repeated names and keeps their order, which `set` would not.
    vehicles = list(dict.fromkeys(cfg.vehicles.split(",")))
    for vehicle in vehicles:
        airframe_by_name(vehicle)
        cfg.equipment.require(vehicle)
    return all_trials(scenes, vehicles, cfg.trials)


def _chosen(cfg: CampaignCfg, suite: FixedSuite) -> list[Trial]:
    """Return the trials of the families that are asked for; an unknown one ends the process."""
    wanted = list(dict.fromkeys(cfg.families.split(","))) if cfg.families else []
    for name in wanted:
        if name not in suite.families:
            valid = ", ".join(suite.families) or f"none, {suite.name} has no families"
            fail(_PROG, f"families {cfg.families!r}: {name!r} is unknown; valid: {valid}")
    return [trial for trial in suite.all_trials() if not wanted or trial.family in wanted]


def _scenes(text: str) -> list[str]:
    """Return the names of the scenes; bad input ends the process."""
    from aeroscene.sources import is_map, load_scene

    if is_map(text):
        load_scene(text)  # Before the first trial, which would fail for it.
        return [text]
    parts = text.split(",")
    districts = [part for part in parts if _DISTRICT.fullmatch(part)]
    if len(districts) == len(parts):
        return list(dict.fromkeys(districts))
    # An empty text would be refused as malformed, so districts alone have returned above.
    numbers = scene_numbers(",".join(part for part in parts if part not in districts))
    if numbers[-1] >= CORPUS_SIZE:
        fail(_PROG, f"scenes {text!r} has no scene {numbers[-1]}; valid: 0:{CORPUS_SIZE}")
    return [*map(str, numbers), *dict.fromkeys(districts)]


def _suite(cfg: CampaignCfg) -> Suite:
    from flightsim.testbench import MAX_INSTANCES
    from scenarios.campaigns.fixed import named_recipe
    from scenarios.campaigns.flyer import Suite
    from scenarios.tasks.recipe import Recipe

    families: Mapping[str, Recipe] = {}
    if cfg.suite is not None:
        fixed = _fixed(cfg, cfg.suite)
        recipe, families = fixed.recipe, fixed.families
    else:
        recipe = Recipe() if cfg.recipe is None else named_recipe(cfg.recipe)
    recordings = None
    if cfg.record != "none":
        recordings = Recordings(
            folder=cfg.out / RECORDINGS, level=cfg.record, camera_hz=cfg.camera_hz
        )
    suite = Suite(
        recipe=recipe,
        families=families,
        pilot=cfg.pilot,
        program=cfg.program,
        chat=chat_model(_PROG, cfg.endpoint, cfg.model),
        stack=_stack(cfg),
        equipment=cfg.equipment,
        recordings=recordings,
    )
    if cfg.program is not None and not suite.is_external:
        fail(_PROG, f"program {cfg.program!r} needs --pilot mavlink; pilot is {cfg.pilot!r}")
    if suite.is_external and cfg.program is None and cfg.engine == "ray":
        fail(_PROG, "pilot mavlink without --program waits on loopback; valid: --engine local")
    if cfg.ray_address is not None and cfg.engine != "ray":
        fail(_PROG, f"ray-address {cfg.ray_address!r} needs --engine ray")
    # Worker K takes instance + K, and the ports of the last one must exist too.
    last = MAX_INSTANCES - cfg.workers
    has_ports = suite.stack is not None or (suite.is_external and cfg.program is None)
    if has_ports and not 0 <= cfg.instance <= last:
        fail(_PROG, f"instance {cfg.instance} is out of range; valid: 0 to {last}, by the workers")
    return suite


def chat_model(prog: str, endpoint: str | None, model: str) -> ChatModel | None:
    """Return the language model at an address that the user names.

    Args:
        prog: Command that names itself in errors.
        endpoint: Address of a server that answers chat/completions; None for no model.
        model: Name of the model there.

    Returns:
        The model, or None without an address. A model's name without an address ends the process
        with status 2.
    """
    from scenarios.chat.completions import ChatModel

    if endpoint is None:
        if model != "default":
            fail(prog, f"model {model!r} needs --endpoint")
        return None
    return ChatModel(endpoint=endpoint, model=model)


def _stack(cfg: CampaignCfg) -> FlightStack | None:
    """Return the flight stack that is asked for, None for ours; bad input ends the process."""
    from scenarios.campaigns.flight_stack import FlightStack
    from scenarios.campaigns.flyer import EXTERNAL

    name, binary = cfg.autopilot, cfg.autopilot_binary
    if name == "builtin":
        if binary is not None:
            fail(_PROG, f"autopilot-binary {binary!r} needs --autopilot px4 or ardupilot")
        return None
    if binary is None:
        fail(_PROG, f"autopilot {name} needs --autopilot-binary, which each trial starts anew")
    if cfg.pilot == EXTERNAL:
        fail(_PROG, f"pilot mavlink flies by our autopilot, not {name}; valid: another --pilot")
    if cfg.engine != "local":
        fail(_PROG, f"autopilot {name} flies on this machine; valid: --engine local")
    return FlightStack(autopilot=name, binary=binary)


def _fixed(cfg: CampaignCfg, name: str) -> FixedSuite:
    """Return a fixed suite by name; options that it would overrule end the process."""
    from scenarios.campaigns.fixed import fixed_suite

    for option in ("scenes", "trials", "vehicles", "recipe"):
        if getattr(cfg, option) != getattr(CampaignCfg, option):
            fail(_PROG, f"{option} is fixed by suite {name!r}; valid: one of the two")
    if cfg.equipment != Equipment():
        fail(_PROG, f"cameras and sensors are fixed by suite {name!r}; valid: one of the two")
    return fixed_suite(name)


@contextmanager
def _engine(cfg: CampaignCfg, suite: Suite) -> Iterator[Engine]:
    """Open the engine that runs trials in processes, and close it at the end."""
    from scenarios.campaigns.engines.cluster import ray_engine
    from scenarios.campaigns.engines.local import LocalEngine
    from scenarios.campaigns.external.flight import FIRST_PORT

    if cfg.engine == "ray":
        with ray_engine(suite, cfg.patience, cfg.workers, cfg.ray_address) as engine:
            yield engine
        return
    # Ten ports an instance, as everywhere in the testbench: 5760, 5770, ...
    port = FIRST_PORT + 10 * cfg.instance
    waits = suite.is_external and suite.program is None
    if waits:
        sys.stderr.write(f"{_PROG}: clients are awaited from tcp:127.0.0.1:{port} on\n")
    yield LocalEngine(suite, cfg.patience, port if waits else None, cfg.instance)
