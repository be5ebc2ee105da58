"""Facts that an external flight stack's start needs, and the command line that comes of them."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from flightsim.frames import Geodetic
from flightsim.plant import PlantCfg


@dataclass(frozen=True, kw_only=True, slots=True)
class Start:
    """Place of a vehicle at first, and the sensors that it has."""

    place: Geodetic
    heading_deg: float
    """Clockwise from north."""
    sensors: PlantCfg
    is_in_room: bool = False
    """True if the vehicle starts in a room, where it has no satellites."""

    @property
    def is_by_odometry(self) -> bool:
        """True if odometry alone says at first where the vehicle is."""
        return self.sensors.has("vio") and (self.is_in_room or not self.sensors.has("gnss"))


@dataclass(frozen=True, kw_only=True, slots=True)
class Launch:
    """A command line, in the folder that holds its files."""

    arguments: Sequence[str]
    """Arguments after the name of the binary."""
    environment: Mapping[str, str] = field(default_factory=dict)
    """Variables to set besides those of this process; $PATH in a value stands for this process's
    own."""

    def line(self, program: str) -> str:
        """Return the command line for a shell, which expands $PATH and takes all else literally.

        Args:
            program: Name or path of the binary, taken as it is.
        """
        # Quoting the parts between, and not the whole value, leaves $PATH to the shell.
        words = [
            f"{name}={'$PATH'.join(part and shlex.quote(part) for part in value.split('$PATH'))}"
            for name, value in self.environment.items()
        ]
        return " ".join([*words, program, *map(shlex.quote, self.arguments)])
