"""Rows of a benchmark's output."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, Literal

OnProgress = Callable[[str, float], None]
"""Called before each part of a benchmark with its title and the share done, 0 to 1."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Row:
    """One figure."""

    metric: str
    value: float
    unit: str
    target: float | None = None
    """Target value; None if there is none."""
    better: Literal["higher", "lower"] = "higher"

    @property
    def is_met(self) -> bool:
        """Whether the figure meets its target, or has none."""
        if self.target is None:
            return True
        return self.value >= self.target if self.better == "higher" else self.value <= self.target

    def to_plain(self) -> dict[str, Any]:
        """The row as plain data."""
        return asdict(self)


def higher(metric: str, value: float, unit: str, target: float | None = None) -> Row:
    """A figure that is the better the higher it is."""
    return Row(metric=metric, value=value, unit=unit, target=target)


def lower(metric: str, value: float, unit: str, target: float | None = None) -> Row:
    """A figure that is the better the lower it is."""
    return Row(metric=metric, value=value, unit=unit, target=target, better="lower")
