"""Row of a benchmark's output."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal


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
