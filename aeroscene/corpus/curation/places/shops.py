"""A parade of shops: low buildings wall to wall, awnings with tables and goods before them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.goods import boxes_on, crate_stack, paint, range_goods
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import park, rack_bicycles
from aeroscene.corpus.curation.places.rooftops import (
    TILES,
    add_flat_roof,
    add_row_roof,
    furnish_flat_roof,
)
from aeroscene.corpus.curation.places.rows import Fronts, raise_row
from aeroscene.corpus.curation.places.seating import dine
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, beneath

_FRONTS = Fronts(width_m=9.5, least_m=7.0, storeys=(1, 3), storey_m=3.6, forms=("plain", "podium"))
_DEEP_M = (10.0, 12.5)
_PAVING_M = (3.2, 4.6)
"""Depth of the paving between the kerb's sidewalk and the shops."""
_AWNING_M = (2.4, 3.0)
"""Depth and height of an awning."""


@dataclass(slots=True)
class Shops:
    """Shops along the street, a yard for deliveries behind them."""

    ground: Ground
    _shops: list[Placed] = field(default_factory=list)
    _awnings: list[Placed] = field(default_factory=list)
    _flat: list[Placed] = field(default_factory=list)
    _front: float = 0.0
    """Beginning of the shops, v."""
    _back: float = 0.0
    """End of the shops and beginning of the yard, v."""

    def structures(self) -> Iterator[None]:
        """Grow the shops; then their awnings and roofs, a wall or a fence round the yard."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("plaza", {"form": "bands"})
        width, depth = ground.parcel.width, ground.parcel.depth
        deep = min(draw.between(*_DEEP_M), round(depth - 2.6, 2))
        self._front = max(2.5, min(draw.between(*_PAVING_M), round(depth - deep - 0.1, 2)))
        self._back = round(self._front + deep, 2)
        # Buildings are at least 6 m deep in the catalogue.
        if deep >= 6.2:
            span = (-width / 2 + 0.1, width / 2 - 0.1)
            self._shops = raise_row(ground, span, self._front, deep, _FRONTS)
        yield
        for shop in self._shops:
            self._hang_awning(shop)
            yield
        for shop in self._shops:
            if draw.chance(0.2):
                add_row_roof(ground.builder, shop, draw.one_of(TILES))
            # Machines need a flat roof.
            else:
                roof = add_flat_roof(ground.builder, shop)
                self._flat += [roof] if roof else []
            yield
        if depth - self._back > 4.0:
            half = width / 2 - 0.4
            ground.fence_line((-half, depth - 0.3), (half, depth - 0.3), "wall", 1.8)
            yield

    def _hang_awning(self, shop: Placed) -> None:
        """Canvas before a shop, in a colour of its own."""
        ground, draw = self.ground, self.ground.draw
        # Every fourth shop has none.
        if draw.chance(0.25):
            return
        u, _ = ground.parcel.frame.local(shop.frame.x, shop.frame.y)
        size = (_AWNING_M[0], round(min(8.0, shop.size[1] - 1.2), 2), _AWNING_M[1])
        look = {**paint(draw), "form": draw.one_of(("flat", "pitched"))}
        v = self._front - _AWNING_M[0] / 2 - 0.05
        awning = ground.stand("canopy", u, v, size, margin=0.0, look=look)
        self._awnings += [awning] if awning else []

    def details(self) -> Iterator[None]:
        """Grow tables and goods under the awnings, boards and planters, machines on the roofs."""
        ground, draw = self.ground, self.ground.draw
        roofs = [furnish_flat_roof(ground.builder, draw, roof) for roof in self._flat]
        uses = [
            # In turn a cafe and a grocer.
            self._serve(awning) if index % 2 else self._sell(awning)
            for index, awning in enumerate(self._awnings)
        ]
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        yard = (-half + 0.5, half - 0.5, self._back + 0.5, depth - 0.6)
        goods = range_goods(ground, OpenGround(ground), yard, 4)
        yield from interleave(*uses, self._line_front(), *roofs, goods, self._deliver())

    def _serve(self, awning: Placed) -> Iterator[None]:
        """A cafe's tables."""
        width = awning.size[1]
        count = max(1, int((width - 0.6) / 2.3))
        spots = [(0.0, (index - (count - 1) / 2) * 2.3) for index in range(count)]
        bearing = beneath(self.ground, awning)
        yield from dine(bearing, awning.frame, spots, QUARTER, chairs=2)

    def _sell(self, awning: Placed) -> Iterator[None]:
        """A grocer's trestles with boxes, crates beside them."""
        ground, width = self.ground, awning.size[1]
        bearing = beneath(ground, awning)
        for index in range(max(1, int(width / 3.2))):
            at = (index + 0.5) * 3.2 - width / 2
            size = (0.85, 2.2, 0.78)
            spot = awning.frame.moved(-0.4, at)
            table = bearing.stand("table", spot, size, look={"form": "trestle"})
            if table:
                boxes_on(ground, table, 3)
            yield
        crate_stack(bearing, awning.frame.moved(0.7, 0.0, QUARTER), 0.0, 0.0)
        yield

    def _line_front(self) -> Iterator[None]:
        """Boards, planters, bicycles and bins at the edge of the paving."""
        ground = self.ground
        half = ground.parcel.width / 2
        for index, shop in enumerate(self._shops):
            u, _ = ground.parcel.frame.local(shop.frame.x, shop.frame.y)
            edge = u + shop.size[1] / 2 - 0.8
            ground.stand("sign", edge, 0.7, (0.12, 0.8, 1.9))
            ground.stand("planter", edge - 1.6, self._front - 0.45, (0.6, 1.2, 0.9))
            yield
            if index % 2:
                rack_bicycles(OpenGround(ground), ground.parcel.frame, u, 0.95, 3)
            else:
                ground.stand("bench", u, 0.8, turn=INWARD)
                ground.stand("bin", u + 1.8, 0.8, (0.5, 0.5, 0.95))
            yield
        for sign in (-1, 1):
            ground.stand("street_lamp", sign * (half - 1.0), 0.6, (0.9, 0.4, 4.2), turn=STREETWARD)
        yield

    def _deliver(self) -> Iterator[None]:
        """A van in the yard, bins along the shops' backs."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        if depth - self._back < 3.0:
            return
        u = draw.between(-0.6, 0.6) * half
        if depth - self._back > 4.5:
            park(OpenGround(ground), "van", ground.parcel.frame, u, depth - 2.4, 0.0)
            yield
        for shop in self._shops:
            at, _ = ground.parcel.frame.local(shop.frame.x, shop.frame.y)
            for step in range(2):
                size = (0.75, 1.2, 1.25)
                ground.stand("bin", at + 1.4 * step, self._back + 0.5, size, turn=INWARD)
            yield
        yard = (-half, half, self._back + 0.2, depth)
        yield from fill_up(ground, ("pallet", "crate", "bicycle"), yard, 5)
