"""Upper slabs and roofs: drawn like all objects, but laid as rooms and walls under them need.

Slabs and roofs are drawn before the walls under them are known. Their tokens are therefore
collected, and boxes that fit the finished rooms replace the drawn ones.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from aeroscene.learning.program.decoding.structures.buildings import DecodedBuilding
from aeroscene.scene import OrientedBox

Drawn = tuple[int, OrientedBox]
"""Place of a token, and its box."""


@dataclass(slots=True)
class Overhead:
    """Drawn slabs and roofs of one building, until its storeys are built."""

    slabs: list[Drawn] = field(default_factory=list)
    roofs: list[Drawn] = field(default_factory=list)
    """Roofs of a house of rooms alone, without a building around them."""
    has_roof: bool = False
    """True once the house has its roof; no other is laid then."""

    def laid(self, building: DecodedBuilding) -> list[Drawn]:
        """Return the slabs and roofs to lay, and forget the drawn ones."""
        found: list[Drawn] = []
        if self.slabs:
            found += _nearest(building.upper_slabs(len(self.slabs)), self.slabs)
        if self.roofs:
            found += _nearest(building.roofs(self.roofs[0][1].s[2]), self.roofs)
            self.has_roof = True
        self.slabs, self.roofs = [], []
        return found


def _nearest(boxes: Sequence[OrientedBox], drawn: Sequence[Drawn]) -> Iterator[Drawn]:
    """Yield boxes, each with the token whose own box was nearest."""
    for box in boxes:
        away_m = [math.dist(box.p, own.p) for _, own in drawn]
        yield drawn[away_m.index(min(away_m))][0], box
