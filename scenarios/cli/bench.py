"""`aeroscene bench`: how fast this machine is, how good generated scenes are."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from scenarios.bench.row import Row
from scenarios.cli.command_line import EXIT_DONE, EXIT_NEGATIVE, fail

_PROG = "aeroscene bench"
_LEAST_SECONDS = 1.0
_LEAST_COUNT, _MOST_COUNT = 3, 1016
_LEAST_GENERATED = 6
"""Fewer say nothing about a set of scenes."""
_GENERATED_COUNT = 24

OnProgress = Callable[[str, float], None]


@dataclass(frozen=True, kw_only=True)
class SimCfg:
    """Fly a scene with everything but cameras and two MAVLink clients, then measure the parts."""

    scene: str = "42"
    """Scene of the dataset by number, or a scene JSON file."""
    vehicle: str = "iris"
    """Airframe: iris, iris-rotors or hummingbird."""
    seconds: float = 60.0
    """Simulated seconds of each flight; those with cameras take a fifth."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: rows, each with metric, value, unit and target."""

    def rows(self, on_progress: OnProgress) -> Iterable[Row]:
        """Measure."""
        from scenarios.bench import sim  # noqa: PLC0415 - the whole stack

        if not self.seconds >= _LEAST_SECONDS:
            raise sim.BenchError(
                f"seconds {self.seconds} is too short; valid: {_LEAST_SECONDS:g} or more"
            )
        cfg = sim.SimBenchCfg(scene=self.scene, vehicle=self.vehicle, seconds=self.seconds)
        return sim.rows(cfg, on_progress)

    @property
    def title(self) -> str:
        """What was measured."""
        return f"scene {self.scene}, {self.vehicle}, {self.seconds:g} simulated seconds"


@dataclass(frozen=True, kw_only=True)
class SceneCfg:
    """Make scenes of all domains, compile them, step their physics, render their cameras.

    CPU time of all threads is counted: what one core would take. p95 is the scene that only a
    twentieth of all are worse than.
    """

    count: int = 12
    """How many scenes, spread over the corpus."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: rows, each with metric, value, unit and target."""

    def rows(self, on_progress: OnProgress) -> Iterable[Row]:
        """Measure."""
        from scenarios.bench import scene, sim  # noqa: PLC0415 - the whole stack

        if not _LEAST_COUNT <= self.count <= _MOST_COUNT:
            raise sim.BenchError(
                f"count {self.count} is out of range; valid: {_LEAST_COUNT} to {_MOST_COUNT}"
            )
        return scene.rows(self.count, on_progress)

    @property
    def title(self) -> str:
        """What was measured."""
        return f"{self.count} scenes of all domains"


@dataclass(frozen=True, kw_only=True)
class GenerateCfg:
    """Generate scenes, one after the other, and judge them beside the corpus.

    Times are wall times from a seed to a finished scene. "before" and "after" are the scenes before
    and after feasibility; docs/metrics.md says what each figure is.
    """

    scenes: str | None = None
    """Judge scenes that are made already instead: shipped, or a folder with a dataset or with what
    `aeroscene generate` has written."""
    count: int | None = None
    """How many scenes, a third of each domain; figures about sets want 64 or more. Of --scenes the
    first so many. [default: 24; of --scenes all]"""
    seed: int = 0
    """Seed of the first scene; the others count on from it."""
    checkpoint: Path | None = None
    """File that `aeroscene train` has written. [default: the one that ships with the preset]"""
    preset: Literal["default", "paper"] = "default"
    """The model that ships, default or paper; its targets hold for a checkpoint too."""
    device: str = "auto"
    """auto takes a GPU where there is one; or cpu, cuda, cuda:1, mps."""
    data: Path = Path("corpus")
    """Folder that `aeroscene dataset build` has made: the scenes to compare with."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: rows, each with metric, value, unit and target."""

    def rows(self, on_progress: OnProgress) -> Iterable[Row]:
        """Measure."""
        from scenarios.bench import sim  # noqa: PLC0415 - the whole stack

        if self.count is not None and not _LEAST_GENERATED <= self.count <= _MOST_COUNT:
            raise sim.BenchError(
                f"count {self.count} is out of range; valid: {_LEAST_GENERATED} to {_MOST_COUNT}"
            )
        if self.seed < 0:
            raise sim.BenchError(f"seed {self.seed} is out of range; valid: 0 or more")
        if self.scenes is not None:
            return self._made_rows(self.scenes, on_progress)
        from scenarios.bench import generate  # noqa: PLC0415 - the model

        cfg = generate.GenerateBenchCfg(
            count=self._n_generated,
            seed=self.seed,
            checkpoint=self.checkpoint,
            preset=self.preset,
            device=self.device,
            data=self.data,
        )
        return generate.rows(cfg, on_progress)

    def _made_rows(self, scenes: str, on_progress: OnProgress) -> Iterable[Row]:
        from scenarios.bench import made, sim  # noqa: PLC0415 - the whole stack

        if (self.checkpoint, self.preset, self.device) != (None, "default", "auto"):
            raise sim.BenchError(
                f"scenes {scenes!r} are made already; valid: --scenes without --checkpoint, "
                "--preset and --device"
            )
        cfg = made.MadeBenchCfg(scenes=scenes, count=self.count, seed=self.seed, data=self.data)
        return made.rows(cfg, on_progress)

    @property
    def _n_generated(self) -> int:
        return _GENERATED_COUNT if self.count is None else self.count

    @property
    def title(self) -> str:
        """What was measured."""
        if self.scenes is not None:
            count = "all" if self.count is None else f"first {self.count}"
            return f"scenes {self.scenes}, {count}"
        model = self.checkpoint or self.preset
        return f"{self._n_generated} scenes by {model}, from seed {self.seed}"


@dataclass(frozen=True, kw_only=True)
class PlanCfg:
    """Plan missions and flights between drawn places, replan them, compare with other planners.

    CPU time of the process is counted: what one core would take. "solved" are pairs of start and
    goal that free space joins; the failures are listed by their error. "cost" is flight time plus
    weighted squared jerk, what the planner minimises.
    """

    count: int = 200
    """Pairs of start and goal, 10 m apart or more where the scene allows."""
    scenes: int = 20
    """Shipped scenes that they are spread over."""
    vehicle: str = "iris"
    """Airframe: iris, iris-rotors or hummingbird."""
    seed: int = 0
    """Seed of the places and of who crosses the way."""
    joint: int = 8
    """Plans to compare with the joint optimum of states and times by ipopt; some seconds each."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: rows, each with metric, value, unit and target."""

    def rows(self, on_progress: OnProgress) -> Iterable[Row]:
        """Measure."""
        from scenarios.bench import plan, sim  # noqa: PLC0415 - the planner

        if not 1 <= self.scenes <= _MOST_COUNT:
            raise sim.BenchError(f"scenes {self.scenes} is out of range; valid: 1 to {_MOST_COUNT}")
        if not (self.count >= self.scenes and self.joint >= 0 and self.seed >= 0):
            raise sim.BenchError(
                f"count {self.count}, joint {self.joint} or seed {self.seed} is out of range; "
                f"valid: {self.scenes} (a pair for each scene) or more, 0 or more, 0 or more"
            )
        cfg = plan.PlanBenchCfg(
            count=self.count,
            scenes=self.scenes,
            vehicle=self.vehicle,
            seed=self.seed,
            joint=self.joint,
        )
        return plan.rows(cfg, on_progress)

    @property
    def title(self) -> str:
        """What was measured."""
        return f"{self.count} pairs in {self.scenes} scenes, {self.vehicle}, seed {self.seed}"


@dataclass(frozen=True, kw_only=True)
class EstimateCfg:
    """Is the estimator as good as it says, by every way to know where one is?

    Short flights of the plant alone, each with noise and curves of its own; errors against the
    truth are held to the covariance that the filter claims (NEES), innovations to theirs (NIS).
    """

    count: int = 100
    """Flights of each case."""
    vehicle: str = "iris"
    """Airframe: iris, iris-rotors or hummingbird."""
    seconds: float = 30.0
    """Of curves in each flight, after 6.5 s of rest and take-off."""
    seed: int = 0
    """Seed of the first flight; the others count on from it."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: rows, each with metric, value, unit and target."""

    def rows(self, on_progress: OnProgress) -> Iterable[Row]:
        """Measure."""
        from scenarios.bench import estimate, sim  # noqa: PLC0415 - the whole stack

        for name, value, least in (("count", self.count, 1), ("seconds", self.seconds, 1.0)):
            if not value >= least:
                raise sim.BenchError(f"{name} {value} is too small; valid: {least:g} or more")
        if self.seed < 0:
            raise sim.BenchError(f"seed {self.seed} is out of range; valid: 0 or more")
        cfg = estimate.EstimateBenchCfg(
            count=self.count, vehicle=self.vehicle, seconds=self.seconds, seed=self.seed
        )
        return estimate.rows(cfg, on_progress)

    @property
    def title(self) -> str:
        """What was measured."""
        return f"{self.count} flights of {self.vehicle} a case, from seed {self.seed}"


@dataclass(frozen=True, kw_only=True)
class ControlCfg:
    """Fly figure eights in still air and in wind, overload the controller, let the vehicle tumble.

    Hummingbird, whose figures have the targets, and Iris. With the estimator in the loop errors
    are against the estimate: what the controller answers for.
    """

    count: int = 1000
    """Recoveries of each vehicle from random attitudes and rates."""
    flights: int = 10
    """Figure eights of each vehicle in 5 m/s of wind with moderate turbulence."""
    seed: int = 0
    """Seed of the noise, the wind and the attitudes."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: rows, each with metric, value, unit and target."""

    def rows(self, on_progress: OnProgress) -> Iterable[Row]:
        """Measure."""
        from scenarios.bench import control, sim  # noqa: PLC0415 - the plant

        if not (self.count >= 1 and self.flights >= 1 and self.seed >= 0):
            raise sim.BenchError(
                f"count {self.count}, flights {self.flights} or seed {self.seed} is out of range; "
                "valid: 1 or more, 1 or more, 0 or more"
            )
        cfg = control.ControlBenchCfg(trials=self.count, flights=self.flights, seed=self.seed)
        return control.rows(cfg, on_progress)

    @property
    def title(self) -> str:
        """What was measured."""
        return f"{self.flights} flights in wind, {self.count} recoveries, seed {self.seed}"


@dataclass(frozen=True, kw_only=True)
class LandCfg:
    """Choose landing sites through a depth camera with its errors; judge them by the geometry.

    Search and descent over landing areas of many scenes, Iris and Hummingbird by turns, from poses
    that err as the estimate does; then flights of the whole stack. An unsafe site is one where the
    vehicle itself breaks a limit of slope, height range or rise, by vertical rays onto the solids.
    """

    areas: int = 500
    """Landing areas; places to perch on are looked at beside them."""
    flights: int = 10
    """Landings flown in the whole stack, a scene for each."""
    camera: Literal["exact", "d435", "d455"] = "d435"
    """Depth camera: without errors, or with those of a RealSense D435 or D455."""
    seed: int = 0
    """Seed of the areas and of all errors."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: rows, each with metric, value, unit and target."""

    def rows(self, on_progress: OnProgress) -> Iterable[Row]:
        """Measure."""
        from scenarios.bench import land, sim  # noqa: PLC0415 - the whole stack

        if not (self.areas >= 1 and self.flights >= 0 and self.seed >= 0):
            raise sim.BenchError(
                f"areas {self.areas}, flights {self.flights} or seed {self.seed} is out of range; "
                "valid: 1 or more, 0 or more, 0 or more"
            )
        cfg = land.LandBenchCfg(
            areas=self.areas, flights=self.flights, camera=self.camera, seed=self.seed
        )
        return land.rows(cfg, on_progress)

    @property
    def title(self) -> str:
        """What was measured."""
        return f"{self.areas} areas by {self.camera}, {self.flights} flights, seed {self.seed}"


Bench = (
    Annotated[SimCfg, tyro.conf.subcommand("sim", prefix_name=False)]
    | Annotated[SceneCfg, tyro.conf.subcommand("scene", prefix_name=False)]
    | Annotated[GenerateCfg, tyro.conf.subcommand("generate", prefix_name=False)]
    | Annotated[EstimateCfg, tyro.conf.subcommand("estimate", prefix_name=False)]
    | Annotated[PlanCfg, tyro.conf.subcommand("plan", prefix_name=False)]
    | Annotated[ControlCfg, tyro.conf.subcommand("control", prefix_name=False)]
    | Annotated[LandCfg, tyro.conf.subcommand("land", prefix_name=False)]
)

AnyCfg = SimCfg | SceneCfg | GenerateCfg | EstimateCfg | PlanCfg | ControlCfg | LandCfg
_NAMES: Mapping[type, str] = {
    SimCfg: "sim",
    SceneCfg: "scene",
    GenerateCfg: "generate",
    PlanCfg: "plan",
    ControlCfg: "control",
    LandCfg: "land",
    EstimateCfg: "estimate",
}


@dataclass(frozen=True, kw_only=True)
class BenchCfg:
    """Measure how fast this machine is, or how good generated scenes are.

    Exit status 0 if every target is met, else 1.
    """

    bench: Bench


def run(cfg: BenchCfg) -> int:
    """Run the benchmark and print it; exit status 2 with one line where it cannot be run."""
    # The whole stack: only where it is run.
    from aeroscene.scene import SceneError  # noqa: PLC0415
    from flightsim.vehicles.catalogue import AirframeError  # noqa: PLC0415
    from scenarios.bench.launch import LaunchError  # noqa: PLC0415
    from scenarios.bench.sim import BenchError  # noqa: PLC0415

    try:
        with Progress(console=Console(stderr=True), transient=True) as progress:
            task = progress.add_task("", total=1.0)
            rows = tuple(
                cfg.bench.rows(
                    lambda title, share: progress.update(task, description=title, completed=share)
                )
            )
    except (SceneError, AirframeError, BenchError, LaunchError) as error:
        fail(_PROG, str(error))
    if cfg.bench.json:
        print(json.dumps(_to_plain(cfg.bench, rows)))
    else:
        _print_table(cfg.bench, rows)
    return EXIT_DONE if all(row.is_met for row in rows) else EXIT_NEGATIVE


def _to_plain(bench: AnyCfg, rows: tuple[Row, ...]) -> dict[str, Any]:
    options = {
        name: str(value) if isinstance(value, Path) else value
        for name, value in asdict(bench).items()
    }
    del options["json"]
    return {"bench": _NAMES[type(bench)], **options, "rows": [row.to_plain() for row in rows]}


def _print_table(bench: AnyCfg, rows: tuple[Row, ...]) -> None:
    table = Table("metric", "value", "unit", "target", title=bench.title, title_justify="left")
    for row in rows:
        target = ""
        if row.target is not None:
            sign = "≥" if row.better == "higher" else "≤"
            style = "green" if row.is_met else "bold red"
            target = f"[{style}]{sign} {row.target:g}[/]"
        table.add_row(row.metric, f"{row.value:.4g}", row.unit, target)
    Console().print(table)
