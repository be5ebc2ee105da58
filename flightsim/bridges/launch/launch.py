"""What it takes to start an external flight stack: its command line, and where it starts from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from flightsim.frames import Geodetic


@dataclass(frozen=True, kw_only=True, slots=True)
class Start:
    """Place of a vehicle at first."""

    place: Geodetic
    heading_deg: float
    """Clockwise from north."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Launch:
    """A command line, in the folder that holds its files."""

    arguments: Sequence[str]
    """Arguments after the binary."""
    environment: Mapping[str, str] = field(default_factory=dict)
    """Variables besides those of this process; $PATH in one of them is this process's."""
