"""A car park with cars in its bays and a building behind it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from math import pi

from aeroscene.curation.builder import Placed
from aeroscene.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.curation.places.ground import GROUND_M, Ground
from aeroscene.curation.rooftops import add_flat_roof, equip_flat_roof
from aeroscene.scene import AttributeValue
from aeroscene.shapes.ground import BAY_WIDTH_M
from aeroscene.shapes.materials import PAINT_COLOURS, WALL_COLOURS

_DEPTH_M = 16.5


@dataclass(slots=True)
class Parking:
    """Two rows of bays, a strip of green, a shop."""

    ground: Ground
    _lot: Placed | None = None
    _roof: Placed | None = None

    def structures(self) -> Iterator[None]:
        """The lot at the street; behind it lawn and, where deep enough, a shop."""
        ground, draw = self.ground, self.ground.draw
        parcel = ground.parcel
        rest = parcel.depth - _DEPTH_M
        self._lot = ground.builder.place(
            "parking_lot",
            parcel.frame,
            0,
            _DEPTH_M / 2,
            (parcel.width, _DEPTH_M, GROUND_M["parking_lot"]),
            base=0.0,
            attributes={"rows": 2},
        )
        if rest >= 3:
            ground.surface = ground.builder.place(
                "lawn",
                parcel.frame,
                0,
                _DEPTH_M + rest / 2,
                (parcel.width, rest, GROUND_M["lawn"]),
                base=0.0,
            )
        if rest >= 8.5:
            deep, length = min(9.0, rest - 2), min(15.0, parcel.width - 3)
            attributes: dict[str, AttributeValue] = {"colour": draw.one_of(WALL_COLOURS)}
            size = (deep, length, 3.2 * draw.count(1, 2))
            shop = ground.erect("building", 0, _DEPTH_M + rest / 2, size, attributes=attributes)
            self._roof = add_flat_roof(ground.builder, shop) if shop else None
        elif draw.chance(0.5) and self._lot:
            ground.builder.place(
                "canopy",
                self._lot.frame,
                draw.between(-0.3, 0.3) * parcel.width,
                -0.5,
                (2.4, 2.4, 2.9),
                base=self._lot.top,
                parent=self._lot,
                attributes={"colour": "blue"},
            )
        yield

    def details(self) -> Iterator[None]:
        """Cars in about half the bays, lamps, trees on the strip of green."""
        ground, draw = self.ground, self.ground.draw
        if self._lot is None:
            return
        self._park_cars(self._lot)
        self._light(self._lot)
        if self._roof:
            equip_flat_roof(ground.builder, draw, self._roof, items=draw.count(2, 4))
        if ground.surface:
            half, depth = ground.parcel.width / 2, ground.parcel.depth
            ground.plant_trees(draw.count(2, 4), (-half, half, _DEPTH_M, depth))
            ground.scatter("bush", draw.count(2, 4), near=(-half, half, _DEPTH_M, depth))
            ground.stand("bench", draw.between(-0.7, 0.7) * half, _DEPTH_M + 0.8, turn=-QUARTER)
        yield

    def _park_cars(self, lot: Placed) -> None:
        draw = self.ground.draw
        n_bays = int((lot.size[0] - 0.1) // BAY_WIDTH_M)
        share = draw.between(0.3, 0.55)
        for row, bay in product((-1, 1), range(n_bays)):
            if not draw.chance(share):
                continue
            u = -n_bays * BAY_WIDTH_M / 2 + (bay + 0.5) * BAY_WIDTH_M
            name = "van" if draw.chance(0.12) else "car"
            size = draw.size_of(name)
            turn = INWARD if draw.chance(0.5) else STREETWARD
            self.ground.builder.place(
                name,
                lot.frame,
                u,
                row * (lot.size[1] / 2 - 2.7),
                (min(size[0], 4.9), size[1], size[2]),
                base=lot.top,
                turn=turn,
                parent=lot,
                within=lot,
                attributes={"colour": draw.one_of(PAINT_COLOURS)},
            )

    def _light(self, lot: Placed) -> None:
        """A lamp at each end of the aisle."""
        for sign in (-1, 1):
            self.ground.builder.place(
                "street_lamp",
                lot.frame,
                sign * (lot.size[0] / 2 - 0.6),
                0.0,
                (1.6, 0.5, 5.5),
                base=lot.top,
                turn=pi if sign > 0 else 0.0,
                parent=lot,
            )
