"""What it takes to start an external flight stack: command line, sensors, and from where."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from flightsim.frames import Geodetic
from flightsim.plant import PlantCfg


@dataclass(frozen=True, kw_only=True, slots=True)
class Start:
    """Place of a vehicle at first, and what it measures by."""

    place: Geodetic
    heading_deg: float
    """Clockwise from north."""
    sensors: PlantCfg
    is_in_room: bool = False
    """Whether it has no satellites there."""

    @property
    def is_by_odometry(self) -> bool:
        """Whether odometry alone says where it is at first."""
        return self.sensors.has("vio") and (self.is_in_room or not self.sensors.has("gnss"))


@dataclass(frozen=True, kw_only=True, slots=True)
class Launch:
    """A command line, in the folder that holds its files."""

    arguments: Sequence[str]
    """Arguments after the binary."""
    environment: Mapping[str, str] = field(default_factory=dict)
    """Variables besides those of this process; $PATH in one of them is this process's."""

    def line(self, program: str) -> str:
        """The command line for a shell, which expands $PATH and takes everything else as it is."""
        words = [
            f"{name}={'$PATH'.join(part and shlex.quote(part) for part in value.split('$PATH'))}"
            for name, value in self.environment.items()
        ]
        return " ".join([*words, program, *map(shlex.quote, self.arguments)])
