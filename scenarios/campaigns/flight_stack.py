"""Flight stack that is not ours, which flies the trials of a suite in place of our autopilot."""

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
    """A program that flies: each trial starts it anew, so that none knows of the one before."""

    autopilot: Literal["px4", "ardupilot"]
    binary: str

    def require(self) -> None:
        """Refuse a program that is not there.

        Raises:
            FlightStackError: If it is none.
        """
        path = Path(self.binary)
        if not path.is_file() or not os.access(path, os.X_OK):
            raise FlightStackError(
                f"autopilot-binary {self.binary!r} is no program; valid: that of {self.autopilot}, "
                "built for simulation"
            )

    def to_plain(self) -> dict[str, Any]:
        """What decides the outcome: another build under the same name is another one."""
        digest = hashlib.sha256(Path(self.binary).read_bytes()).hexdigest()
        return {
            "autopilot": self.autopilot,
            "autopilot_binary": self.binary,
            "autopilot_sha256": digest,
        }

    def flying(self, bench: TestbenchCfg, instance: int) -> TestbenchCfg:
        """Settings of a testbench in which it flies, on the ports of an instance."""
        return replace(
            bench, autopilot=self.autopilot, autopilot_binary=self.binary, instance=instance
        )


def stack_from(suite: dict[str, Any]) -> FlightStack | None:
    """The flight stack that a campaign's file tells of; None for our own autopilot."""
    if suite.get("autopilot") is None:
        return None
    return FlightStack(autopilot=suite["autopilot"], binary=suite["autopilot_binary"])
