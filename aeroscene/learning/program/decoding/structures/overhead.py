"""Upper slabs and roofs: drawn like all things, but laid as the rooms and walls under them are."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from aeroscene.learning.program.decoding.structures.buildings import DecodedBuilding
from aeroscene.scene import OrientedBox

Drawn = tuple[int, OrientedBox]
"""A token and its box."""


@dataclass(slots=True)
class Overhead:
    """What was drawn of one building, until its storeys are built."""

    slabs: list[Drawn] = field(default_factory=list)
    roofs: list[Drawn] = field(default_factory=list)
    """Of a house of rooms alone, without a building about them."""
    has_roof: bool = False
    """Whether the house has its roof, so that no more is laid."""

    def laid(self, building: DecodedBuilding) -> list[Drawn]:
        """What is laid in place of what was drawn, which is forgotten."""
        found: list[Drawn] = []
        if self.slabs:
            found += _nearest(building.upper_slabs(len(self.slabs)), self.slabs)
        if self.roofs:
            found += _nearest(building.roofs(self.roofs[0][1].s[2]), self.roofs)
            self.has_roof = True
        self.slabs, self.roofs = [], []
        return found


def _nearest(boxes: Sequence[OrientedBox], drawn: Sequence[Drawn]) -> Iterator[Drawn]:
    """Boxes, each for the token whose own was nearest."""
    for box in boxes:
        away_m = [math.dist(box.p, own.p) for _, own in drawn]
        yield drawn[away_m.index(min(away_m))][0], box
