"""What a shape is drawn from: the box's size, its attributes and a number for variety."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from zlib import crc32

from aeroscene.scene import AttributeValue, Vector3
from aeroscene.solids.shapes.primitive import Part

_LEAST_STOREY_M = 1.5
_MOST_STOREYS = 60
"""A file may say any number; the parts of a facade are as many as its storeys times its bays."""


@dataclass(frozen=True, slots=True)
class Look:
    """Size and attributes of one object; a missing attribute falls back on the variant."""

    size_m: Vector3
    attributes: Mapping[str, AttributeValue]
    variant: int
    """Varies what no attribute fixes; the object's id."""

    def choice(self, name: str, options: Sequence[str], drawn: Sequence[str] = ()) -> str:
        """A named attribute, if it is one of the options, else the variant's pick.

        Args:
            name: Name of the attribute.
            options: Its valid values.
            drawn: Those among which the variant picks; all by default.
        """
        return self._pinned(name, options) or _pick(name, str(self.variant), drawn or options)

    def set_choice(self, name: str, options: Sequence[str], drawn: Sequence[str] = ()) -> str:
        """Like `choice`, but what shares its wood and colour with others, shares this too.

        The chairs of one room are of one kind, though each has its own id.
        """
        taste = [str(self.attributes[key]) for key in ("wood", "colour") if key in self.attributes]
        seed = "-".join(taste) or str(self.variant)
        return self._pinned(name, options) or _pick(name, seed, drawn or options)

    def _pinned(self, name: str, options: Sequence[str]) -> str | None:
        value = self.attributes.get(name)
        return value if isinstance(value, str) and value in options else None

    def number(self, name: str, default: float) -> float:
        """A numeric attribute."""
        value = self.attributes.get(name, default)
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return float(value) if is_number else default

    def storeys(self, default: int) -> int:
        """Number of storeys, as many as the height has room for."""
        asked = max(1, round(self.number("storeys", default)))
        return min(asked, _MOST_STOREYS, max(1, int(self.size_m[2] / _LEAST_STOREY_M)))

    def flag(self, name: str) -> bool:
        """A yes-or-no attribute."""
        return self.attributes.get(name) is True


Shape = Callable[[Look], list[Part]]


def _pick(name: str, seed: str, options: Sequence[str]) -> str:
    """The same for the same name and seed in every process; names vary independently."""
    return options[crc32(f"{name} of {seed}".encode()) % len(options)]
