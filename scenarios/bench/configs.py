"""What each benchmark is asked for: light, so that the command line loads none of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

_MOST_SCENES = 1016
_N_GENERATED = 24


class BenchError(ValueError):
    """A benchmark that cannot be run as it was asked for, or whose flight did not happen."""


@dataclass(frozen=True, kw_only=True)
class AnyBenchCfg(ABC):
    """What all benchmarks are asked."""

    json: bool = False
    """Print one JSON object: rows, each with metric, value, unit and target."""

    @property
    @abstractmethod
    def title(self) -> str:
        """What was measured."""


def _check(name: str, value: float, low: float, high: float | None = None) -> None:
    """Refuse a value that is out of range, or no number."""
    if value >= low and (high is None or value <= high):
        return
    valid = f"{low:g} or more" if high is None else f"{low:g} to {high:g}"
    raise BenchError(f"{name} {value} is out of range; valid: {valid}")


@dataclass(frozen=True, kw_only=True)
class SimBenchCfg(AnyBenchCfg):
    """Fly a scene with everything but cameras and two MAVLink clients, then measure the parts."""

    scene: str = "42"
    """Scene of the dataset by number, or a scene JSON file."""
    vehicle: str = "iris"
    """Airframe: iris, iris-rotors or hummingbird."""
    seconds: float = 60.0
    """Simulated seconds of each flight; those with cameras take a fifth."""

    def __post_init__(self) -> None:
        """Refuse what cannot be measured, before anything starts."""
        _check("seconds", self.seconds, 1.0)

    @property
    def title(self) -> str:
        """What was measured."""
        return f"scene {self.scene}, {self.vehicle}, {self.seconds:g} simulated seconds"


@dataclass(frozen=True, kw_only=True)
class SceneBenchCfg(AnyBenchCfg):
    """Make scenes of all domains, compile them, step their physics, render their cameras.

    CPU time of all threads is counted: what one core would take. p95 is the scene that only a
    twentieth of all are worse than.
    """

    count: int = 12
    """How many scenes, spread over the corpus."""

    def __post_init__(self) -> None:
        """Refuse what cannot be measured, before anything starts."""
        _check("count", self.count, 1, _MOST_SCENES)

    @property
    def title(self) -> str:
        """What was measured."""
        return f"{self.count} scenes of all domains"


@dataclass(frozen=True, kw_only=True)
class GenerateBenchCfg(AnyBenchCfg):
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

    def __post_init__(self) -> None:
        """Refuse what cannot be measured, before anything starts."""
        _check("count", self.n_generated, 2, _MOST_SCENES)
        _check("seed", self.seed, 0)
        chosen = (self.checkpoint, self.preset, self.device)
        if self.scenes is not None and chosen != (None, "default", "auto"):
            raise BenchError(
                f"scenes {self.scenes!r} are made already; valid: --scenes without --checkpoint, "
                "--preset and --device"
            )

    @property
    def n_generated(self) -> int:
        """How many scenes are made, or looked at at most."""
        return _N_GENERATED if self.count is None else self.count

    @property
    def title(self) -> str:
        """What was measured."""
        if self.scenes is not None:
            count = "all" if self.count is None else f"first {self.count}"
            return f"scenes {self.scenes}, {count}"
        model = self.checkpoint or self.preset
        return f"{self.n_generated} scenes by {model}, from seed {self.seed}"


@dataclass(frozen=True, kw_only=True)
class PlanBenchCfg(AnyBenchCfg):
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

    def __post_init__(self) -> None:
        """Refuse what cannot be measured, before anything starts."""
        _check("scenes", self.scenes, 1, _MOST_SCENES)
        _check("count", self.count, self.scenes)
        _check("joint", self.joint, 0)
        _check("seed", self.seed, 0)

    @property
    def title(self) -> str:
        """What was measured."""
        return f"{self.count} pairs in {self.scenes} scenes, {self.vehicle}, seed {self.seed}"


@dataclass(frozen=True, kw_only=True)
class EstimateBenchCfg(AnyBenchCfg):
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

    def __post_init__(self) -> None:
        """Refuse what cannot be measured, before anything starts."""
        _check("count", self.count, 1)
        _check("seconds", self.seconds, 1.0)
        _check("seed", self.seed, 0)

    @property
    def title(self) -> str:
        """What was measured."""
        return f"{self.count} flights of {self.vehicle} a case, from seed {self.seed}"


@dataclass(frozen=True, kw_only=True)
class ControlBenchCfg(AnyBenchCfg):
    """Fly figure eights in still air and in wind, overload the controller, let the vehicle tumble.

    Hummingbird, whose figures have the targets, and Iris. With the estimator in the loop errors
    are against the estimate: what the controller answers for.
    """

    count: int = 1000
    """Recoveries of each vehicle from random attitudes and rates."""
    flights: int = 10
    """Figure eights of each vehicle in 5 m/s of wind with moderate turbulence."""
    vehicles: tuple[str, ...] = ("hummingbird", "iris")
    """Airframes to fly: iris, iris-rotors or hummingbird."""
    seed: int = 0
    """Seed of the noise, the wind and the attitudes."""

    def __post_init__(self) -> None:
        """Refuse what cannot be measured, before anything starts."""
        _check("count", self.count, 1)
        _check("flights", self.flights, 1)
        _check("seed", self.seed, 0)

    @property
    def title(self) -> str:
        """What was measured."""
        return f"{self.flights} flights in wind, {self.count} recoveries, seed {self.seed}"


@dataclass(frozen=True, kw_only=True)
class LandBenchCfg(AnyBenchCfg):
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

    def __post_init__(self) -> None:
        """Refuse what cannot be measured, before anything starts."""
        _check("areas", self.areas, 1)
        _check("flights", self.flights, 0)
        _check("seed", self.seed, 0)

    @property
    def title(self) -> str:
        """What was measured."""
        return f"{self.areas} areas by {self.camera}, {self.flights} flights, seed {self.seed}"
