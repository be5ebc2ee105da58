"""Flight stack of another project, which flies the trials of a suite in place of our autopilot.

The pilot stays the same and commands PX4 or ArduPilot instead, so that a campaign compares
autopilots.
"""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from flightsim.testbench import TestbenchCfg


class FlightStackError(ValueError):
    """There is no such flight stack; one line says so, and what would be valid."""


@dataclass(frozen=True, kw_only=True, slots=True)
class FlightStack:
    """A program that flies. Each trial starts it anew, so that no trial affects the next one."""

    autopilot: Literal["px4", "ardupilot"]
    binary: str

    def require(self) -> None:
        """Refuse a program that is not there.

        Raises:
            FlightStackError: If the file does not exist or cannot be executed.
        """
        path = Path(self.binary)
        # Before the campaign begins: otherwise every trial would fail alike.
        if not path.is_file() or not os.access(path, os.X_OK):
            raise FlightStackError(
                f"autopilot-binary {self.binary!r} is no program; valid: that of {self.autopilot}, "
                "built for simulation"
            )

    def to_plain(self) -> dict[str, Any]:
        """Return the stack as plain data, with a digest of its binary.

        The digest is part of the campaign's identity, because another build under the same name may
        fly otherwise.
        """
        digest = hashlib.sha256(Path(self.binary).read_bytes()).hexdigest()
        return {
            "autopilot": self.autopilot,
            "autopilot_binary": self.binary,
            "autopilot_sha256": digest,
        }

    def flying(self, bench: TestbenchCfg, instance: int) -> TestbenchCfg:
        """Return the settings of a testbench in which it flies, on the ports of an instance."""
        return replace(
            bench, autopilot=self.autopilot, autopilot_binary=self.binary, instance=instance
        )


def stack_from(suite: dict[str, Any]) -> FlightStack | None:
    """Return the flight stack in a campaign's manifest; None for our own autopilot."""
    if suite.get("autopilot") is None:
        return None
    return FlightStack(autopilot=suite["autopilot"], binary=suite["autopilot_binary"])
