"""Options of the benchmarks of many vehicles; see `scenarios.bench.configs`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from aeroscene.ranges import Range
from scenarios.bench.configs import MOST, SECONDS, AnyBenchCfg

PeerName = Literal["gym-pybullet-drones", "pyflyt"]
"""Environments of other projects, to compare ours with."""


@dataclass(frozen=True, kw_only=True)
class WorldsBenchCfg(AnyBenchCfg):
    """Fly many vehicles, each in a world of its own, on one thread and on two; step environments.

    Targets are for two quiet cores; figures in CPU seconds hold on a busy machine too.
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

    Figures are in CPU seconds: one core does it all.
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
