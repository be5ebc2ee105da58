"""What a benchmark prints."""

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
    """What it should be; None where nothing was promised."""
    better: Literal["higher", "lower"] = "higher"

    @property
    def is_met(self) -> bool:
        """Whether the figure is as good as its target, or has none."""
        if self.target is None:
            return True
        return self.value >= self.target if self.better == "higher" else self.value <= self.target

    def to_plain(self) -> dict[str, Any]:
        """As plain data."""
        return asdict(self)
