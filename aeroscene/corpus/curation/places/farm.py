"""A farmyard: a house, a barn and an open shed round a paved yard, beds and a paddock behind."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.goods import paint, pallet_row
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import park
from aeroscene.corpus.curation.places.rooftops import add_chimney, add_pitched_roof
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, beneath, on_top
from aeroscene.solids.shapes.materials import WALL_COLOURS

_HOUSE_M = (7.6, 10.0, 5.8)
_SHED_M = (5.0, 9.0, 3.8)
_SILO_M = (2.6, 2.6, 3.5)
_EAVES_M = 0.4
_BED_M = (2.2, 0.06)
"""Width and height of a bed in the field."""


@dataclass(slots=True)
class Farm:
    """Buildings round a yard.

    The house is at one side of the yard, the barn at the other; `_side` is that of the barn.
    """

    ground: Ground
    _roof: Placed | None = None
    _barn: Placed | None = None
    _shed: Placed | None = None
    _yard: Placed | None = None
    _beds: list[Placed] = field(default_factory=list)
    _side: int = 1

    def structures(self) -> Iterator[None]:
        """Grow house and barn; then the yard between them, a shed, the paddock's fence, beds."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("lawn", {"form": "plain"})
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        self._side = 1 if draw.chance(0.5) else -1
        self._raise_house()
        self._raise_barn()
        yield
        size = (round(min(10.0, half), 2), round(min(13.0, 0.5 * depth), 2), 0.05)
        if min(size[:2]) >= 5.0:
            v = size[1] / 2 + 0.1
            look = {"form": "border", "paving": "paving"}
            at = self._side * 0.08 * half
            self._yard = ground.stand("plaza", at, v, size, turn=0.0, margin=0.0, look=look)
        yield
        look = {"form": "pitched", **paint(draw)}
        at = (self._side * (half - _SHED_M[1] / 2 - 0.8), depth - _SHED_M[0] / 2 - 0.8)
        self._shed = ground.stand("canopy", *at, _SHED_M, margin=0.3, look=look)
        yield
        start, end = (-self._side * (half - 0.5), 0.62 * depth), (0.0, 0.62 * depth)
        ground.fence_line(start, end, "rails", 1.2)
        yield
        for index in range(3):
            long = min(12.0, round(half - 2.0, 2))
            at = (-self._side * (half - long / 2 - 0.8), depth - 1.8 - 2.6 * index)
            size = (long, _BED_M[0], _BED_M[1])
            look = {"form": "beds"}
            bed = ground.stand("lawn", *at, size, turn=0.0, margin=0.1, look=look)
            self._beds += [bed] if bed else []
            yield

    def _raise_house(self) -> None:
        """The farmhouse at one side of the yard, under a steep roof."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        look = {"colour": draw.one_of((*WALL_COLOURS, "brick")), "storeys": 2, "form": "plain"}
        deep, length, high = _HOUSE_M
        size = (min(deep, round(depth - 3.0, 2)), min(length, round(half - 2.0, 2)), high)
        # A house of less than 6 m would be an outlier of its category.
        if min(size[:2]) < 6.0:
            return
        u = -self._side * (half - size[1] / 2 - 1.2)
        house = ground.erect("house", u, size[0] / 2 + 1.8, size, look=look)
        self._roof = add_pitched_roof(ground.builder, draw, house) if house else None

    def _raise_barn(self) -> None:
        """The barn on the other side, its gate to the yard."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        thick = min(11.0, round(0.62 * half, 2))
        long = min(18.0, round(depth - 9.0, 2))
        if thick < 7.0 or long < 10.0:
            return
        look = {"form": "lowpitch", **paint(draw)}
        # The barn's front (+x), with its gate, is towards the yard.
        turn = 2 * QUARTER if self._side > 0 else 0.0
        u = self._side * (half - thick / 2 - 0.8)
        size = (thick, long, draw.between(5.0, 6.4))
        self._barn = ground.erect("warehouse", u, 1.2 + long / 2, size, turn=turn, look=look)

    def details(self) -> Iterator[None]:
        """Grow tractors and trailers, hay, a silo; fruit trees in rows, rows of plants."""
        yield from interleave(self._work(), self._live(), self._grow(), self._plant())

    def _work(self) -> Iterator[None]:
        """A lorry in the yard, hay under the shed, a silo beside the barn, crates and pallets."""
        ground, draw = self.ground, self.ground.draw
        bearing = OpenGround(ground)
        if self._yard:
            yard = on_top(ground, self._yard)
            length = draw.between(6.2, 7.4)
            look = {**paint(draw), "form": "flatbed"}
            spot = self._yard.frame.moved(0.0, 1.2, QUARTER)
            yard.stand("truck", spot, (length, 2.4, 2.8), margin=0.15, look=look)
            park(yard, "car", self._yard.frame, -2.8, -2.0, QUARTER)
            yield
            spot = self._yard.frame.moved(0.32 * self._yard.size[0], -0.3 * self._yard.size[1])
            pallet_row(yard, spot, 0.0, 0.0, 2)
            yard.stand("crate", spot.moved(0.0, 1.6), (0.8, 0.8, 0.7))
            yield
        if self._shed:
            shed = beneath(ground, self._shed)
            # Bales in two ranks, four in each.
            for index in range(4):
                at = (index - 1.5) * 1.9
                for depth in (-1.1, 0.6):
                    size = (1.2, 1.2, 1.2)
                    shed.stand(
                        "crate", self._shed.frame.moved(depth, at), size, look={"form": "boards"}
                    )
                if index % 2:
                    yield
        if self._barn:
            frame = self._barn.frame
            end = self._barn.size[1] / 2 + _SILO_M[1] / 2 + 0.5
            look = {"form": "drum"}
            for sign in (-1, 1):
                bearing.stand("water_tank", frame.moved(1.5 * sign, end), _SILO_M, look=look)
            yield

    def _live(self) -> Iterator[None]:
        """A chimney, bins and flowers at the house, a bench before it."""
        ground, draw = self.ground, self.ground.draw
        if self._roof:
            add_chimney(ground.builder, draw, self._roof)
            yield
        half = ground.parcel.width / 2
        u = -self._side * (half - 6.0)
        ground.stand("bench", u, 1.0, (0.6, 1.8, 0.85), turn=STREETWARD)
        for index in range(3):
            at = u + (index - 1) * 2.2
            ground.stand("planter", at, 0.5, (0.5, 1.4, 0.7))
        yield
        ground.stand("bin", u + self._side * 5.4, 2.0, (0.7, 0.6, 1.1))
        ground.stand("bicycle", u + self._side * 5.6, 3.6, (1.75, 0.5, 1.05), turn=INWARD)
        yield

    def _grow(self) -> Iterator[None]:
        """Bushes in line on each bed."""
        ground = self.ground
        for bed in self._beds:
            platform = on_top(ground, bed)
            count = int(bed.size[0] / 1.6)
            for index in range(count):
                at = (index - (count - 1) / 2) * 1.6
                platform.stand("bush", bed.frame.moved(at, 0.0), (0.8, 0.8, 0.6))
                if index % 3 == 2:
                    yield
            yield

    def _plant(self) -> Iterator[None]:
        """An orchard in the paddock, trees along the flanks."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        # All trees of an orchard are alike.
        crown = draw.between(2.4, 3.2)
        size = (crown, crown, 4.2)
        look = {"form": "round"}
        for row in range(2):
            for column in range(3):
                u = -self._side * (2.0 + 4.4 * column)
                v = (0.7 + 0.14 * row) * depth
                ground.stand("tree", u, v, size, turn=0.0, look=look)
            yield
        ground.plant_trees(2, (-half, half, 0.5 * depth, depth))
        ground.scatter("bush", 3)
        yield
        names = ("tree", "crate", "bush", "pallet")
        yield from fill_up(ground, names, (-half, half, 0.5 * depth, depth), 6)
        ground.stand("bench", self._side * 0.3 * half, 0.6 * depth, turn=pi)
        yield
