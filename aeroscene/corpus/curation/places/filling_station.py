"""A filling station: pumps under a wide roof, a shop behind them, a bay to wash cars."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.goods import paint
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import park
from aeroscene.corpus.curation.places.rooftops import add_flat_roof, furnish_flat_roof
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, beneath
from aeroscene.solids.shapes.materials import WALL_COLOURS

_ROOF_M = (7.0, 12.0, 5.2)
"""Depth, length and height of the roof over the pumps."""
_PUMP_M = (0.3, 0.9, 1.8)
_ISLAND_PITCH_M = 5.4
_SHOP_M = (7.0, 11.0, 4.0)
_WASH_M = (7.0, 4.2, 3.2)


@dataclass(slots=True)
class FillingStation:
    """Asphalt with a roof over pumps."""

    ground: Ground
    _canopy: Placed | None = None
    _shop: Placed | None = None
    _roof: Placed | None = None
    _wash: Placed | None = None
    _side: int = 1

    def structures(self) -> Iterator[None]:
        """Grow roof and shop; then the washing bay, a strip of green at the street."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("parking_lot", {"rows": 0, "form": "bays"})
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        self._side = 1 if draw.chance(0.5) else -1
        size = (min(_ROOF_M[0], depth - 4.0), min(_ROOF_M[1], 2 * half - 3.0), _ROOF_M[2])
        look = {**paint(draw), "form": "flat"}
        # A parcel that is too small keeps the asphalt only.
        if min(size) >= 2.0:
            v = 2.0 + size[0] / 2
            self._canopy = ground.stand("canopy", 0.0, v, size, margin=0.2, look=look)
        yield
        rest = depth - 3.0 - size[0]
        # The shop takes the rest of the depth; below 6 m there is none.
        deep = min(_SHOP_M[0], round(rest - 1.0, 2))
        if deep >= 6.0:
            look = {"colour": draw.one_of(WALL_COLOURS), "storeys": 1, "form": "plain"}
            length = min(_SHOP_M[1], round(2 * half - 7.0, 2))
            shop = (deep, max(6.0, length), _SHOP_M[2])
            u = -self._side * max(0.0, half - shop[1] / 2 - 1.0)
            self._shop = ground.erect("building", u, depth - deep / 2 - 0.4, shop, look=look)
            self._roof = add_flat_roof(ground.builder, self._shop) if self._shop else None
        yield
        # A carport: a car can stand in it, and a small drone can fly through.
        look = {"form": "carport"}
        at = (self._side * (half - _WASH_M[1] / 2 - 0.5), depth - _WASH_M[0] / 2 - 0.5)
        self._wash = ground.erect("garage", *at, _WASH_M, look=look)
        yield
        island = (round(0.5 * half, 2), 1.6, 0.12)
        if island[0] >= 2.0:
            ground.stand("lawn", 0.0, 1.0, island, turn=0.0, margin=0.0, look={"form": "plain"})
        yield

    def details(self) -> Iterator[None]:
        """Grow pumps with cars beside them, the price board, goods before the shop."""
        ground, draw = self.ground, self.ground.draw
        roof = iter(())
        if self._roof:
            roof = furnish_flat_roof(ground.builder, draw, self._roof)
        yield from interleave(self._pump(), self._sell(), roof, self._wait(), self._edge())

    def _pump(self) -> Iterator[None]:
        """Islands of two pumps and a bin across the roof's length, cars on either side."""
        ground, draw, canopy = self.ground, self.ground.draw, self._canopy
        if canopy is None:
            return
        bearing = beneath(ground, canopy)
        # One island at least, however short the roof is.
        count = max(1, int(canopy.size[1] / _ISLAND_PITCH_M))
        for index in range(count):
            at = (index - (count - 1) / 2) * _ISLAND_PITCH_M
            for along in (-1.2, 1.2):
                spot = canopy.frame.moved(along, at, QUARTER)
                bearing.stand("sign", spot, _PUMP_M, look={"form": "board"})
            bearing.stand("bin", canopy.frame.moved(0.0, at), (0.5, 0.5, 0.95))
            yield
            for side in (-1, 1):
                if draw.chance(0.6):
                    turn = 0.0 if draw.chance(0.5) else pi
                    park(bearing, "car", canopy.frame.moved(0.0, at + side * 1.5), 0.0, 0.0, turn)
            yield

    def _sell(self) -> Iterator[None]:
        """Crates, bottles in their cages and plants before the shop."""
        ground, draw, shop = self.ground, self.ground.draw, self._shop
        if shop is None:
            return
        bearing = OpenGround(ground)
        front, half = shop.size[0] / 2, shop.size[1] / 2
        for sign in (-1, 1):
            spot = shop.frame.moved(front + 0.7, sign * (half - 1.2))
            bearing.stand("crate", spot, (1.0, 1.2, 1.1))
            bearing.stand("planter", shop.frame.moved(front + 0.7, sign * (half - 3.0)))
            yield
        bearing.stand(
            "pallet", shop.frame.moved(front + 0.9, 1.2), (1.2, 1.0, draw.between(0.6, 1.2))
        )
        bearing.stand("bin", shop.frame.moved(front + 0.6, -1.0), (0.5, 0.5, 0.95))
        yield

    def _wait(self) -> Iterator[None]:
        """Cars by the shop and in the washing bay, a lorry at the side."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        if self._wash:
            bearing = beneath(ground, self._wash)
            park(bearing, "car", self._wash.frame, 0.0, 0.0, 0.0)
            yield
        for index in range(3):
            u = -self._side * (half - 2.0 - 2.6 * index)
            park(OpenGround(ground), "car", ground.parcel.frame, u, depth - 11.2, INWARD)
            if index == 1:
                yield
        side = self._side * (half - 1.8)
        length = draw.between(6.5, 8.5)
        ground.stand("truck", side, 5.5, (length, 2.4, 3.2), turn=INWARD, look=paint(draw))
        yield

    def _edge(self) -> Iterator[None]:
        """The price board and a lamp at the street, bushes, air and water."""
        ground = self.ground
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        ground.stand("sign", -self._side * 0.7 * half, 0.8, (0.3, 1.8, 4.0), look={"form": "board"})
        ground.stand("street_lamp", self._side * 0.8 * half, 0.8, (1.2, 0.4, 6.0), turn=STREETWARD)
        yield
        ground.scatter("bush", 3, near=(-half, half, 0.1, 1.9))
        ground.plant_trees(1, (-half, half, depth - 3.0, depth))
        yield
        names = ("bush", "bin", "bicycle", "tree")
        yield from fill_up(ground, names, (-half, half, 0.3, depth), 5)
