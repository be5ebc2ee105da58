"""Options of the benchmarks of planner, estimator and landing, light so that `--help` is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from aeroscene.ranges import SEEDS, Range, require_ranges
from scenarios.bench.configs import (
    COUNT,
    MOST,
    MOST_SCENES,
    SCENES,
    SECONDS,
    AnyBenchCfg,
    BenchError,
)


@dataclass(frozen=True, kw_only=True)
class PlanBenchCfg(AnyBenchCfg):
    """Plan missions and flights between random places, replan them and compare with other planners.

    Times are CPU times of the process: what one core would take. "solved" counts pairs of start and
    goal that free space connects; failures are listed by their error. "cost" is flight time plus
    weighted squared jerk, which the planner minimises.
    """

    count: Annotated[int, COUNT] = 200
    """Number of pairs of start and goal, 10 m apart or more where the scene allows."""
    scenes: Annotated[int, SCENES] = 20
    """Number of shipped scenes over which the pairs are spread."""
    vehicle: str = "iris"
    """Airframe by its name; an unknown one is answered with the valid names."""
    seed: Annotated[int, SEEDS] = 0
    """Seed of the places and of crossing traffic."""
    joint: Annotated[int, Range(0, MOST)] = 8
    """Plans compared with the joint optimum of states and times by ipopt, some seconds each."""

    def __post_init__(self) -> None:
        """Refuse numbers that are out of their ranges, and scenes without a pair."""
        require_ranges(self, BenchError)
        if self.count < self.scenes:
            raise BenchError(
                f"count {self.count} is less than the {self.scenes} scenes; "
                f"valid: {self.scenes} or more, or fewer --scenes"
            )

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

    count: Annotated[int, SCENES] = 120
    """Number of scenes, spread over the dataset."""
    vehicle: str = "iris"
    """Airframe by its name; an unknown one is answered with the valid names."""

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

    count: Annotated[int, COUNT] = 100
    """Number of flights in each case."""
    vehicle: str = "iris"
    """Airframe by its name; an unknown one is answered with the valid names."""
    seconds: Annotated[float, SECONDS] = 30.0
    """Seconds of curves in each flight, after 6.5 s of rest and take-off."""
    seed: Annotated[int, SEEDS] = 0
    """Seed of the first flight; the others count up from it."""

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"{self.count} flights of {self.vehicle} a case, from seed {self.seed}"


@dataclass(frozen=True, kw_only=True)
class LandBenchCfg(AnyBenchCfg):
    """Choose landing sites with a noisy depth camera and judge them by the true geometry.

    Search and descent over landing areas of many scenes, Iris and Hummingbird in turn, from poses
    with the errors of the estimate; then flights of the whole stack. A site is unsafe if the
    vehicle itself breaks a limit of slope, height range or rise there, by vertical rays onto the
    solids.
    """

    areas: Annotated[int, COUNT] = 500
    """Number of landing areas; perching places are tested in addition."""
    flights: Annotated[int, Range(0, MOST)] = 10
    """Number of landings flown in the whole stack, one scene each."""
    camera: Literal["exact", "d435", "d455"] = "d435"
    """Depth camera: without errors, or with those of a RealSense D435 or D455."""
    seed: Annotated[int, SEEDS] = 0
    """Seed of the areas and of all errors."""

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"{self.areas} areas by {self.camera}, {self.flights} flights, seed {self.seed}"


@dataclass(frozen=True, kw_only=True)
class EncountersBenchCfg(AnyBenchCfg):
    """Fly demos in which a drone comes the vehicle's way, from ahead, the side, above or below.

    It would be where the vehicle is at some moment between its climb and its search for a place to
    land, at 1 to 3 m/s, and heeds nobody; its way is free of the scene for 5 s before. Iris and
    Hummingbird in turn. Distances are those between the hulls, by the truth.
    """

    count: Annotated[int, Range(1, 4 * MOST_SCENES)] = 100
    """Number of encounters, up to four a scene, some ten CPU seconds each."""
    seed: Annotated[int, SEEDS] = 0
    """Seed of the flights and the encounters, and the scene to begin with."""

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"{self.count} encounters, seed {self.seed}"


@dataclass(frozen=True, kw_only=True)
class ApproachesBenchCfg(AnyBenchCfg):
    """Let vehicles without power fly at everything, with free flight and by MuJoCo's steps alone.

    Half of them fly at a solid of a shipped scene, from any side in which there is room, the other
    half at another vehicle, at 1 to 20 m/s, turned and turning anyhow. Whoever touches something
    must do so in the same physics step in both, and come there on the same way.
    """

    count: Annotated[int, COUNT] = 1000
    """Number of approaches, about two milliseconds each."""
    scenes: Annotated[int, SCENES] = 4
    """Number of shipped scenes over which they are spread."""
    vehicle: str = "iris"
    """Airframe by its name; an unknown one is answered with the valid names."""
    seed: Annotated[int, SEEDS] = 0
    """Seed of the approaches."""

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"{self.count} approaches in {self.scenes} scenes, {self.vehicle}, seed {self.seed}"


@dataclass(frozen=True, kw_only=True)
class GrowBenchCfg(AnyBenchCfg):
    """Fly trials with a map that grows, among movers, and with both, and measure their CPU time.

    Trials are those of campaigns, trial 0 of one scene after the other; the crowd is six people,
    three cars and a drone.
    """

    count: Annotated[int, SCENES] = 8
    """Number of trials of each kind, some ten CPU seconds each."""
    vehicle: str = "iris"
    """Airframe by its name; an unknown one is answered with the valid names."""
    seed: Annotated[int, SEEDS] = 0
    """Scene to begin with."""

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"{self.count} trials of each kind, {self.vehicle}, from scene {self.seed}"
