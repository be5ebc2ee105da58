"""Options of each benchmark, light so that the command line does not load the benchmarks."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from aeroscene.ranges import SEEDS, Range, require_ranges

MOST_SCENES = 1016
MOST = 1_000_000
"""Upper limit of every count of a benchmark."""
COUNT = Range(1, MOST)
SCENES = Range(1, MOST_SCENES)
SECONDS = Range(1.0, 36_000.0, "s")
"""Simulated time of a flight; ten hours at most."""


class BenchError(ValueError):
    """A benchmark cannot run with these options, or its flight failed."""


@dataclass(frozen=True, kw_only=True)
class AnyBenchCfg(ABC):
    """Options common to all benchmarks."""

    json: bool = False
    """Print one JSON object: rows, each with metric, value, unit and target."""

    def __post_init__(self) -> None:
        """Refuse numbers that are out of their ranges.

        Raises:
            BenchError: Naming the option, its value and the range.
        """
        require_ranges(self, BenchError)

    @property
    @abstractmethod
    def title(self) -> str:
        """Title of the results."""


@dataclass(frozen=True, kw_only=True)
class SimBenchCfg(AnyBenchCfg):
    """Fly a scene with two MAVLink clients and without cameras, then measure the parts."""

    scene: str = "42"
    """Scene of the dataset by number, or a scene JSON file."""
    vehicle: str = "iris"
    """Airframe by its name; an unknown one is answered with the valid names."""
    seconds: Annotated[float, SECONDS] = 60.0
    """Simulated seconds of each flight; those with cameras take a fifth."""

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"scene {self.scene}, {self.vehicle}, {self.seconds:g} simulated seconds"


@dataclass(frozen=True, kw_only=True)
class SceneBenchCfg(AnyBenchCfg):
    """Make scenes of all domains, compile them, step their physics and render their cameras.

    Times are CPU times of all threads, which is what one core would take. p95 is the scene that
    only a twentieth of all scenes exceed.
    """

    count: Annotated[int, SCENES] = 12
    """Number of scenes, spread over the corpus."""

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"{self.count} scenes of all domains"


@dataclass(frozen=True, kw_only=True)
class ControlBenchCfg(AnyBenchCfg):
    """Fly steps and figure eights, in still air and wind, beyond limits, and out of tumbling.

    The targets apply to the Hummingbird; the Iris is flown too. With the estimator in the loop,
    errors are relative to the estimate, because the controller can track nothing else.
    """

    count: Annotated[int, COUNT] = 1000
    """Number of recoveries of each vehicle from random attitudes and rates."""
    flights: Annotated[int, COUNT] = 10
    """Number of figure eights of each vehicle in 5 m/s of wind with moderate turbulence."""
    vehicles: tuple[str, ...] = ("hummingbird", "iris")
    """Airframes to fly, by their names, or files FILE.toml that describe them; an unknown name is
    answered with the valid ones."""
    seed: Annotated[int, SEEDS] = 0
    """Seed of the noise, the wind and the attitudes."""

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"{self.flights} flights in wind, {self.count} recoveries, seed {self.seed}"


PeerName = Literal["gym-pybullet-drones", "pyflyt", "crazyflow"]
"""Environments of other projects, to compare ours with."""


@dataclass(frozen=True, kw_only=True)
class WorldsBenchCfg(AnyBenchCfg):
    """Fly many vehicles, each in a world of its own, on one thread and on two; step environments.

    Environments are stepped by actions that keep all vehicles in the air, and by actions that end
    episodes. Targets are for two quiet cores; figures in CPU seconds hold on a busy machine too.
    """

    worlds: Annotated[int, Range(2, 4096)] = 64
    """Number of worlds."""
    scenes: tuple[str, ...] = ("42",)
    """Scenes by number or file, in turn."""
    vehicle: str = "iris"
    """Airframe by its name; an unknown one is answered with the valid names."""
    seconds: Annotated[float, SECONDS] = 10.0
    """Simulated seconds of each world."""
    peers: tuple[PeerName, ...] = ()
    """Other projects whose hover environments are stepped in the same run, where installed."""

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"{self.worlds} worlds, scenes {', '.join(self.scenes)}, {self.vehicle}"


@dataclass(frozen=True, kw_only=True)
class VehiclesBenchCfg(AnyBenchCfg):
    """Fly several vehicles in one world, with two MAVLink clients each; let pairs collide.

    Figures are in CPU seconds, because one core does all the work.
    """

    vehicles: Annotated[int, Range(2, 100)] = 4
    """Number of vehicles in the world."""
    scene: str = "42"
    """Scene of the dataset by number, or a scene JSON file."""
    vehicle: str = "iris"
    """Airframe by its name; an unknown one is answered with the valid names."""
    seconds: Annotated[float, SECONDS] = 60.0
    """Simulated seconds of the flight."""
    collisions: Annotated[int, Range(3, MOST)] = 10_000
    """Number of random collisions between two vehicles, a third of them of two airframes."""

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"{self.vehicles} vehicles in scene {self.scene}, {self.vehicle}"


@dataclass(frozen=True, kw_only=True)
class MethodBenchCfg(AnyBenchCfg):
    """Compare the paper's network with a formula, and let it learn eight scenes by heart.

    The errors of a trained network are divided by those of a formula without parameters, channel by
    channel, on scenes that it has not seen. A network of the same kind then learns eight scenes,
    and DiffuScene the same eight in the same CPU time.
    """

    preset: Literal["paper", "progressive"] = "progressive"
    """One of the paper's two presets; without --checkpoint the model that ships with it."""
    checkpoint: Annotated[
        Path | None, tyro.conf.arg(help_behavior_hint="(default: the one that ships)")
    ] = None
    """File written by `aeroscene train` with the preset."""
    data: Path = Path("corpus")
    """Folder made by `aeroscene dataset build`, or a file of neutral layouts. Its held-out scenes
    are judged."""
    count: Annotated[int, Range(2, 1000)] = 48
    """Number of held-out scenes."""
    cpu_seconds: Annotated[float, Range(0.0, 36_000.0, "s")] = 60.0
    """CPU time for learning eight scenes, each method; 0 leaves that out."""

    def __post_init__(self) -> None:
        require_ranges(self, BenchError)

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"{self.checkpoint or self.preset}, {self.count} held-out scenes of {self.data}"


_N_GENERATED = 24


def _default(says: str) -> Any:
    """Return a tyro mark that states the default of an option whose own default is None."""
    return tyro.conf.arg(help_behavior_hint=f"(default: {says})")


@dataclass(frozen=True, kw_only=True)
class GenerateBenchCfg(AnyBenchCfg):
    """Generate scenes one by one and compare them with the corpus.

    Times are wall times from a seed to a finished scene. "before" and "after" are the scenes before
    and after feasibility; docs/metrics.md explains each figure.
    """

    scenes: Annotated[str | None, _default("none")] = None
    """Judge existing scenes instead of generating any: shipped, or a folder with a dataset or with
    output of `aeroscene generate`."""
    count: Annotated[int | None, Range(2, MOST_SCENES), _default("24; with --scenes all")] = None
    """Number of scenes, a third in each domain; figures of sets need 64 or more. With --scenes, the
    number of first scenes to judge."""
    seed: Annotated[int, SEEDS] = 0
    """Seed of the first scene; the others count up from it."""
    checkpoint: Annotated[Path | None, _default("the one that ships with the preset")] = None
    """File written by `aeroscene train`."""
    preset: Literal["default", "paper", "progressive"] = "default"
    """The model that ships; its targets apply to a checkpoint too."""
    device: str = "auto"
    """auto uses a GPU if there is one; or cpu, cuda, cuda:1, mps."""
    data: Path = Path("corpus")
    """Folder made by `aeroscene dataset build`, with the scenes to compare with."""

    def __post_init__(self) -> None:
        require_ranges(self, BenchError)
        chosen = (self.checkpoint, self.preset, self.device)
        if self.scenes is not None and chosen != (None, "default", "auto"):
            raise BenchError(
                f"scenes {self.scenes!r} are made already; valid: --scenes without --checkpoint, "
                "--preset and --device"
            )

    @property
    def n_generated(self) -> int:
        """Number of scenes to generate."""
        return _N_GENERATED if self.count is None else self.count

    @property
    def title(self) -> str:
        """Title of the results."""
        if self.scenes is not None:
            count = "all" if self.count is None else f"first {self.count}"
            return f"scenes {self.scenes}, {count}"
        model = self.checkpoint or self.preset
        return f"{self.n_generated} scenes by {model}, from seed {self.seed}"
