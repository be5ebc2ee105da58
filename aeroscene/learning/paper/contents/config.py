"""Settings of the prior of contents."""

from __future__ import annotations

from dataclasses import dataclass

from aeroscene.learning.diffusion.config import DiffusionError


@dataclass(frozen=True, kw_only=True)
class ContentsCfg:
    """Shape of the prior of contents."""

    width: int = 192
    layers: int = 2

    def __post_init__(self) -> None:
        for name, most in (("width", 4096), ("layers", 16)):
            if not 1 <= getattr(self, name) <= most:
                value = getattr(self, name)
                raise DiffusionError(f"contents.{name} is {value}, valid: 1 to {most}")
