"""Options of each benchmark, light so that the command line does not load the benchmarks."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

_MOST_SCENES = 1016
_N_GENERATED = 24


def _default(says: str) -> Any:
    """What happens without an option whose own default is None."""
    return tyro.conf.arg(help_behavior_hint=f"(default: {says})")


class BenchError(ValueError):
    """A benchmark cannot run with these options, or its flight failed."""


@dataclass(frozen=True, kw_only=True)
class AnyBenchCfg(ABC):
    """Options common to all benchmarks."""

    json: bool = False
    """Print one JSON object: rows, each with metric, value, unit and target."""

    @property
    @abstractmethod
    def title(self) -> str:
        """Title of the results."""


def check_range(name: str, value: float, low: float, high: float | None = None) -> None:
    """Refuse a value that is out of range or NaN."""
    if value >= low and (high is None or value <= high):
        return
    valid = f"{low:g} or more" if high is None else f"{low:g} to {high:g}"
    raise BenchError(f"{name} {value} is out of range; valid: {valid}")


@dataclass(frozen=True, kw_only=True)
class SimBenchCfg(AnyBenchCfg):
    """Fly a scene with two MAVLink clients and without cameras, then measure the parts."""

    scene: str = "42"
    """Scene of the dataset by number, or a scene JSON file."""
    vehicle: str = "iris"
    """Airframe by its name; an unknown one is answered with the valid names."""
    seconds: float = 60.0
    """Simulated seconds of each flight; those with cameras take a fifth."""

    def __post_init__(self) -> None:
        check_range("seconds", self.seconds, 1.0)

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"scene {self.scene}, {self.vehicle}, {self.seconds:g} simulated seconds"


@dataclass(frozen=True, kw_only=True)
class SceneBenchCfg(AnyBenchCfg):
    """Make scenes of all domains, compile them, step their physics and render their cameras.

    Times are CPU times of all threads: what one core would take. p95 is the scene that only a
    twentieth of all scenes exceed.
    """

    count: int = 12
    """Number of scenes, spread over the corpus."""

    def __post_init__(self) -> None:
        check_range("count", self.count, 1, _MOST_SCENES)

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"{self.count} scenes of all domains"


@dataclass(frozen=True, kw_only=True)
class GenerateBenchCfg(AnyBenchCfg):
    """Generate scenes one by one and compare them with the corpus.

    Times are wall times from a seed to a finished scene. "before" and "after" are the scenes before
    and after feasibility; docs/metrics.md explains each figure.
    """

    scenes: Annotated[str | None, _default("none")] = None
    """Judge existing scenes instead: shipped, or a folder with a dataset or with output of
    `aeroscene generate`."""
    count: Annotated[int | None, _default("24; with --scenes all")] = None
    """Number of scenes, a third in each domain; figures of sets need 64 or more. With --scenes, the
    number of first scenes to judge."""
    seed: int = 0
    """Seed of the first scene; the others count up from it."""
    checkpoint: Annotated[Path | None, _default("the one that ships with the preset")] = None
    """File written by `aeroscene train`."""
    preset: Literal["default", "paper"] = "default"
    """The model that ships, default or paper; its targets apply to a checkpoint too."""
    device: str = "auto"
    """auto uses a GPU if there is one; or cpu, cuda, cuda:1, mps."""
    data: Path = Path("corpus")
    """Folder made by `aeroscene dataset build`, with the scenes to compare with."""

    def __post_init__(self) -> None:
        check_range("count", self.n_generated, 2, _MOST_SCENES)
        check_range("seed", self.seed, 0)
        chosen = (self.checkpoint, self.preset, self.device)
        if self.scenes is not None and chosen != (None, "default", "auto"):
            raise BenchError(
                f"scenes {self.scenes!r} are made already; valid: --scenes without --checkpoint, "
                "--preset and --device"
            )

    @property
    def n_generated(self) -> int:
        """Number of scenes to generate, or the most to look at."""
        return _N_GENERATED if self.count is None else self.count

    @property
    def title(self) -> str:
        """Title of the results."""
        if self.scenes is not None:
            count = "all" if self.count is None else f"first {self.count}"
            return f"scenes {self.scenes}, {count}"
        model = self.checkpoint or self.preset
        return f"{self.n_generated} scenes by {model}, from seed {self.seed}"


@dataclass(frozen=True, kw_only=True)
class PlanBenchCfg(AnyBenchCfg):
    """Plan missions and flights between random places, replan them and compare with other planners.

    Times are CPU times of the process: what one core would take. "solved" counts pairs of start and
    goal that free space connects; failures are listed by their error. "cost" is flight time plus
    weighted squared jerk, which the planner minimises.
    """

    count: int = 200
    """Number of pairs of start and goal, 10 m apart or more where the scene allows."""
    scenes: int = 20
    """Number of shipped scenes over which the pairs are spread."""
    vehicle: str = "iris"
    """Airframe by its name; an unknown one is answered with the valid names."""
    seed: int = 0
    """Seed of the places and of crossing traffic."""
    joint: int = 8
    """Plans compared with the joint optimum of states and times by ipopt, some seconds each."""

    def __post_init__(self) -> None:
        check_range("scenes", self.scenes, 1, _MOST_SCENES)
        check_range("count", self.count, self.scenes)
        check_range("joint", self.joint, 0)
        check_range("seed", self.seed, 0)

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"{self.count} pairs in {self.scenes} scenes, {self.vehicle}, seed {self.seed}"


@dataclass(frozen=True, kw_only=True)
class DifficultyBenchCfg(AnyBenchCfg):
    """Measure the planner's ways in shipped scenes: what `generate --difficulty` grades by.

    Medians over the ways of a scene, then thirds over the scenes; "over_straight" is the length of
    a way over the distance of its ends, "quarter_turns" its changes of direction in right angles.
    """

    count: int = 120
    """Number of scenes, spread over the dataset."""
    vehicle: str = "iris"
    """Airframe by its name; an unknown one is answered with the valid names."""

    def __post_init__(self) -> None:
        check_range("count", self.count, 1, _MOST_SCENES)

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"{self.count} scenes, {self.vehicle}"


@dataclass(frozen=True, kw_only=True)
class EstimateBenchCfg(AnyBenchCfg):
    """Test the consistency and the accuracy of the estimator with every source of position.

    Short flights of the plant alone, each with its own noise and curves; errors against the truth
    are compared with the covariance that the filter claims (NEES), innovations with theirs (NIS).
    """

    count: int = 100
    """Number of flights in each case."""
    vehicle: str = "iris"
    """Airframe by its name; an unknown one is answered with the valid names."""
    seconds: float = 30.0
    """Seconds of curves in each flight, after 6.5 s of rest and take-off."""
    seed: int = 0
    """Seed of the first flight; the others count up from it."""

    def __post_init__(self) -> None:
        check_range("count", self.count, 1)
        check_range("seconds", self.seconds, 1.0)
        check_range("seed", self.seed, 0)

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"{self.count} flights of {self.vehicle} a case, from seed {self.seed}"


@dataclass(frozen=True, kw_only=True)
class ControlBenchCfg(AnyBenchCfg):
    """Fly steps and figure eights, in still air and wind, beyond limits, and out of tumbling.

    Hummingbird, to whose figures the targets apply, and Iris. With the estimator in the loop,
    errors are relative to the estimate, which is all that the controller can track.
    """

    count: int = 1000
    """Number of recoveries of each vehicle from random attitudes and rates."""
    flights: int = 10
    """Number of figure eights of each vehicle in 5 m/s of wind with moderate turbulence."""
    vehicles: tuple[str, ...] = ("hummingbird", "iris")
    """Airframes to fly, by their names, or files FILE.toml that describe them; an unknown name is
    answered with the valid ones."""
    seed: int = 0
    """Seed of the noise, the wind and the attitudes."""

    def __post_init__(self) -> None:
        check_range("count", self.count, 1)
        check_range("flights", self.flights, 1)
        check_range("seed", self.seed, 0)

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"{self.flights} flights in wind, {self.count} recoveries, seed {self.seed}"


@dataclass(frozen=True, kw_only=True)
class LandBenchCfg(AnyBenchCfg):
    """Choose landing sites with a noisy depth camera and judge them by the true geometry.

    Search and descent over landing areas of many scenes, Iris and Hummingbird in turn, from poses
    with the errors of the estimate; then flights of the whole stack. A site is unsafe if the
    vehicle itself breaks a limit of slope, height range or rise there, by vertical rays onto the
    solids.
    """

    areas: int = 500
    """Number of landing areas; perching places are tested in addition."""
    flights: int = 10
    """Number of landings flown in the whole stack, one scene each."""
    camera: Literal["exact", "d435", "d455"] = "d435"
    """Depth camera: without errors, or with those of a RealSense D435 or D455."""
    seed: int = 0
    """Seed of the areas and of all errors."""

    def __post_init__(self) -> None:
        check_range("areas", self.areas, 1)
        check_range("flights", self.flights, 0)
        check_range("seed", self.seed, 0)

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"{self.areas} areas by {self.camera}, {self.flights} flights, seed {self.seed}"
