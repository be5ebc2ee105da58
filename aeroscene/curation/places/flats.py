"""Blocks of flats and towers: solid masses with machines on their roofs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from aeroscene.curation.builder import Placed
from aeroscene.curation.frame import QUARTER, STREETWARD
from aeroscene.curation.places.ground import Ground
from aeroscene.curation.rooftops import add_flat_roof, add_roof_pad, equip_flat_roof
from aeroscene.scene import AttributeValue
from aeroscene.shapes.materials import WALL_COLOURS

_STOREY_M = 3.2
_BAY_M = 3.0


@dataclass(slots=True)
class Flats:
    """One to three tall buildings around a green."""

    ground: Ground
    _roofs: list[Placed] = field(default_factory=list)

    def structures(self) -> Iterator[None]:
        """A slab along the street, perhaps a tower or a second slab behind it."""
        ground, draw = self.ground, self.ground.draw
        ground.cover(draw.one_of(("lawn", "lawn", "plaza")))
        width, depth = ground.parcel.width, ground.parcel.depth
        bays = max(3, min(6, int((width - 4) / _BAY_M)))
        length = _BAY_M * draw.count(max(3, bays - 2), bays)
        deep = _BAY_M * draw.count(3, 4)
        u = draw.between(-0.5, 0.5) * (width - length - 2)
        self._mass("building", u, 3 + deep / 2, deep, length, draw.count(3, 5))
        if depth - deep - 6 > 9:
            second = _BAY_M * 3
            v = depth - 1.5 - second / 2
            u = draw.between(-0.5, 0.5) * (width - second - 2)
            if draw.chance(0.55):
                height = draw.between(16, 21)
                attributes: dict[str, AttributeValue] = {"colour": draw.one_of(WALL_COLOURS)}
                ground.erect("tower", u, v, (second, second, height), attributes=attributes)
            elif draw.chance(0.7):
                self._mass("building", u, v, second, second + 3.0, draw.count(2, 4))
        if draw.chance(0.5):
            side = 1 if draw.chance(0.5) else -1
            edge = side * (width / 2 - 0.3)
            ground.fence_line((edge, 4), (edge, depth - 1), "hedge", 1.2)
        yield

    def _mass(
        self, name: str, u: float, v: float, deep: float, length: float, storeys: int
    ) -> None:
        ground, draw = self.ground, self.ground.draw
        attributes: dict[str, AttributeValue] = {
            "colour": draw.one_of((*WALL_COLOURS, "brick")),
            "storeys": storeys,
        }
        mass = ground.erect(name, u, v, (deep, length, storeys * _STOREY_M), attributes=attributes)
        if mass:
            roof = add_flat_roof(ground.builder, mass)
            if roof:
                self._roofs.append(roof)

    def details(self) -> Iterator[None]:
        """Roof equipment, trees, bicycles, bins, a parked van."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        for roof in self._roofs:
            if draw.chance(0.4):
                add_roof_pad(ground.builder, draw, roof)
            equip_flat_roof(ground.builder, draw, roof, items=draw.count(3, 6))
        for _ in range(draw.count(1, 3)):
            ground.stand("bicycle", draw.between(-0.9, 0.9) * half, 1.5, margin=0.1)
        for _ in range(draw.count(1, 2)):
            ground.stand("bin", draw.between(-0.9, 0.9) * half, depth - 0.7)
        ground.plant_trees(draw.count(2, 5))
        ground.scatter("bush", draw.count(0, 3))
        for _ in range(draw.count(0, 2)):
            turn = STREETWARD if draw.chance(0.5) else STREETWARD + QUARTER
            ground.stand("bench", draw.between(-0.8, 0.8) * half, 0.55 * depth, turn=turn)
        yield
