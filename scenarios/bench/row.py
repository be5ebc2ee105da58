"""Rows of a benchmark's output: a figure with its unit, its target and its better direction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, Literal

OnProgress = Callable[[str, float], None]
"""Called before each part of a benchmark with its title and the share done, 0 to 1."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Row:
    """One figure of a benchmark."""

    metric: str
    value: float
    unit: str
    target: float | None = None
    """Value that the figure should reach or keep below; None if there is no target."""
    better: Literal["higher", "lower"] = "higher"

    @property
    def is_met(self) -> bool:
        """True if the figure meets its target, or has none."""
        if self.target is None:
            return True
        return self.value >= self.target if self.better == "higher" else self.value <= self.target

    def to_plain(self) -> dict[str, Any]:
        """Return the row as plain data."""
        return asdict(self)


def higher(metric: str, value: float, unit: str, target: float | None = None) -> Row:
    """Return the row of a figure that is better if it is higher.

    Args:
        metric: Title of the figure.
        value: Its value.
        unit: Its unit; empty for a ratio or a count.
        target: Least value that meets the target.
    """
    return Row(metric=metric, value=value, unit=unit, target=target)


def lower(metric: str, value: float, unit: str, target: float | None = None) -> Row:
    """Return the row of a figure that is better if it is lower.

    Args:
        metric: Title of the figure.
        value: Its value.
        unit: Its unit; empty for a ratio or a count.
        target: Greatest value that meets the target.
    """
    return Row(metric=metric, value=value, unit=unit, target=target, better="lower")
