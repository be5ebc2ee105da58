"""Input of a shape: the box's size, its attributes and a number for variety.

A scene says how large an object is and rarely how it looks. Shapes draw the rest from the object's
id, so that a row of houses varies, yet the same file looks the same in every process.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from zlib import crc32

from aeroscene.scene import AttributeValue, Vector3
from aeroscene.solids.shapes.primitive import Part

_LEAST_STOREY_M = 1.5
_MOST_STOREYS = 60
"""Most storeys. A file may state any number, and a facade has as many parts as storeys times bays.
"""


@dataclass(frozen=True, slots=True)
class Look:
    """Size and attributes of one object; a missing attribute falls back on the variant."""

    size_m: Vector3
    attributes: Mapping[str, AttributeValue]
    variant: int
    """Number that varies whatever no attribute fixes; the object's id."""

    def choice(self, name: str, options: Sequence[str], drawn: Sequence[str] = ()) -> str:
        """Return a named attribute if it is one of the options, else the variant's pick.

        Args:
            name: Name of the attribute.
            options: Its valid values.
            drawn: Values among which the variant picks; all options by default.
        """
        return self._pinned(name, options) or _pick(name, str(self.variant), drawn or options)

    def set_choice(self, name: str, options: Sequence[str], drawn: Sequence[str] = ()) -> str:
        """Like `choice`, but objects with equal `wood` and `colour` share the pick.

        The chairs of one room are of one kind, though each has its own id. Generators give them the
        same wood and colour, which therefore serve as the seed.
        """
        taste = [str(self.attributes[key]) for key in ("wood", "colour") if key in self.attributes]
        seed = "-".join(taste) or str(self.variant)
        return self._pinned(name, options) or _pick(name, seed, drawn or options)

    def _pinned(self, name: str, options: Sequence[str]) -> str | None:
        value = self.attributes.get(name)
        return value if isinstance(value, str) and value in options else None

    def number(self, name: str, default: float) -> float:
        """Return a numeric attribute, or the default if it is missing or no number."""
        value = self.attributes.get(name, default)
        # In Python a bool is an int as well.
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return float(value) if is_number else default

    def storeys(self, default: int) -> int:
        """Number of storeys: the attribute, limited to the number that the height has room for."""
        asked = max(1, round(self.number("storeys", default)))
        return min(asked, _MOST_STOREYS, max(1, int(self.size_m[2] / _LEAST_STOREY_M)))

    def flag(self, name: str) -> bool:
        """Return true if a yes-or-no attribute is set."""
        return self.attributes.get(name) is True


Shape = Callable[[Look], list[Part]]


def _pick(name: str, seed: str, options: Sequence[str]) -> str:
    """Pick the same option for the same name and seed in every process.

    Python's own `hash` of texts differs between processes, hence the checksum. The name is part of
    its text, so that attributes vary independently.
    """
    return options[crc32(f"{name} of {seed}".encode()) % len(options)]
