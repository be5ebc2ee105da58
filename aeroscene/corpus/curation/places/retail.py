"""A large store: a low hall with an entrance, and its car park towards the street."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.corpus.curation.places.bays import TWO_ROWS_M, BayField, paint_bays
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.goods import paint, pallet_row
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import rack_bicycles
from aeroscene.corpus.curation.places.rooftops import add_flat_roof, furnish_flat_roof
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, beneath

_HALL_DEEP_M = (11.0, 17.0)
_ENTRANCE_M = (3.0, 6.0, 3.2)
_WALK_M = 3.4
"""Paving between the hall and the first bays."""
_ONE_ROW_M = 8.6


@dataclass(slots=True)
class Retail:
    """A hall at the back, bays before it."""

    ground: Ground
    _hall: Placed | None = None
    _roof: Placed | None = None
    _entrance: Placed | None = None
    _shelter: Placed | None = None
    _fields: list[BayField] = field(default_factory=list)
    _front: float = 0.0
    """Beginning of the hall, v."""

    def structures(self) -> Iterator[None]:
        """Grow the hall; then bays, the roof over its entrance, a shelter for trolleys."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("parking_lot", {"rows": 0, "form": "bays"})
        width, depth = ground.parcel.width, ground.parcel.depth
        deep = round(min(draw.between(*_HALL_DEEP_M), max(10.0, 0.5 * depth)), 2)
        # Without depth for one row of bays before it there is no hall.
        if depth - deep >= _ONE_ROW_M:
            size = (deep, round(min(width - 2.0, 36.0), 2), draw.between(5.2, 6.8))
            look = {**paint(draw), "form": "hall"}
            self._hall = ground.erect("warehouse", 0.0, depth - deep / 2 - 0.5, size, look=look)
        self._front = depth - deep - 0.5
        yield
        if self._hall:
            self._roof = add_flat_roof(ground.builder, self._hall)
        rest = round(self._front - _WALK_M - 0.3, 2)
        # Bays are as deep as the rest allows, one row or two.
        if self._hall and rest >= 5.2:
            half = width / 2 - 0.4
            bays = paint_bays(ground, OpenGround(ground), (-half, half), 0.2, min(TWO_ROWS_M, rest))
            self._fields += [bays] if bays else []
        yield
        if self._hall:
            u = draw.between(-0.25, 0.25) * width
            look = {"colour": "white", "form": "flat"}
            v = self._front - _ENTRANCE_M[0] / 2 - 0.05
            self._entrance = ground.stand("canopy", u, v, _ENTRANCE_M, margin=0.0, look=look)
        yield
        look = {"colour": "silver", "form": "flat"}
        u = (1 if draw.chance(0.5) else -1) * (width / 2 - 3.4)
        size = (2.2, 5.0, 2.6)
        self._shelter = ground.stand("canopy", u, self._front - 1.6, size, margin=0.1, look=look)
        yield

    def details(self) -> Iterator[None]:
        """Grow cars in the bays, goods at the entrance, machines on the roof."""
        ground, draw = self.ground, self.ground.draw
        roof = iter(())
        if self._roof:
            roof = furnish_flat_roof(ground.builder, draw, self._roof)
        cars = [bays.park_cars(ground) for bays in self._fields]
        extras = [bays.equip(ground) for bays in self._fields]
        yield from interleave(*cars, self._enter(), roof, *extras, self._edge())

    def _enter(self) -> Iterator[None]:
        """Planters and boards at the entrance, plants and pallets for sale, bicycles."""
        ground, draw = self.ground, self.ground.draw
        if self._shelter:
            frame = self._shelter.frame.moved(0, 0, QUARTER)
            rack_bicycles(beneath(ground, self._shelter), frame, 0.0, 0.0, draw.count(3, 5))
            yield
        if self._entrance is None:
            return
        entrance, bearing = self._entrance, OpenGround(ground)
        for sign in (-1, 1):
            at = sign * (entrance.size[1] / 2 + 1.0)
            bearing.stand("planter", entrance.frame.moved(0.9, at), (0.8, 1.6, 1.0))
            bearing.stand("bin", entrance.frame.moved(-0.6, at), (0.5, 0.5, 0.95))
            yield
            far = sign * (entrance.size[1] / 2 + 4.2)
            pallet_row(bearing, entrance.frame.moved(-0.3, far, QUARTER), 0.0, 0.0, 3)
            yield
            bench = entrance.frame.moved(0.0, sign * (entrance.size[1] / 2 + 7.4))
            bearing.stand("bench", bench, (0.6, 1.8, 0.85))
        yield

    def _edge(self) -> Iterator[None]:
        """The store's board and trees along the street, lamps along the bays."""
        ground = self.ground
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        look = {"form": "board"}
        ground.stand("sign", 0.8 * half, 0.6, (0.3, 2.2, 4.0), turn=STREETWARD, look=look)
        yield
        for sign in (-1, 1):
            u = sign * (half - 0.6)
            ground.stand("street_lamp", u, 0.5 * self._front, (1.2, 0.4, 6.0), turn=INWARD)
        yield
        names = ("tree", "bush", "planter", "bicycle", "bin", "bench")
        yield from fill_up(ground, names, (-half, half, 0.1, depth), 8)
