"""What a shape is drawn from: the box's size, its attributes and a number for variety."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from aeroscene.scene import AttributeValue, Vector3
from aeroscene.shapes.primitive import Part


@dataclass(frozen=True, slots=True)
class Look:
    """Size and attributes of one object; a missing attribute falls back on the variant."""

    size_m: Vector3
    attributes: Mapping[str, AttributeValue]
    variant: int
    """Varies what no attribute fixes; the object's id."""

    def choice(self, name: str, options: Sequence[str]) -> str:
        """A named attribute, if it is one of the options, else the variant's pick."""
        value = self.attributes.get(name)
        if isinstance(value, str) and value in options:
            return value
        return options[self.variant % len(options)]

    def number(self, name: str, default: float) -> float:
        """A numeric attribute."""
        value = self.attributes.get(name, default)
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return float(value) if is_number else default

    def flag(self, name: str, *, default: bool = False) -> bool:
        """A yes-or-no attribute."""
        value = self.attributes.get(name, default)
        return value if isinstance(value, bool) else default


Shape = Callable[[Look], list[Part]]
