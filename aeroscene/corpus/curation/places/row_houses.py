"""Row houses: narrow houses wall to wall, each with a garden in front and one behind."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.rooftops import TILES, add_chimney, add_row_roof
from aeroscene.corpus.curation.places.rows import Fronts, raise_row
from aeroscene.corpus.curation.places.seating import dine
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, on_top

_FRONTS = Fronts(
    category="house", width_m=6.6, least_m=6.0, storeys=(2, 2), storey_m=2.9, forms=("plain", "bay")
)
_DEEP_M = (8.0, 9.4)
_SETBACK_M = (2.6, 4.2)
"""Depth of the front gardens."""
_SHED_M = (2.2, 2.4, 2.3)


@dataclass(slots=True)
class RowHouses:
    """One row of houses along the street."""

    ground: Ground
    _houses: list[Placed] = field(default_factory=list)
    _roofs: list[Placed] = field(default_factory=list)
    _terraces: list[Placed] = field(default_factory=list)
    _setback: float = 0.0
    _back: float = 0.0
    """End of the houses and beginning of the back gardens, v."""

    def structures(self) -> Iterator[None]:
        """Grow the row with its roofs; then a hedge in front, fences between gardens, sheds."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("lawn", {"form": "plain"})
        width, depth = ground.parcel.width, ground.parcel.depth
        deep = draw.between(*_DEEP_M)
        self._setback = max(0.5, min(draw.between(*_SETBACK_M), round(depth - deep - 0.5, 2)))
        self._back = round(self._setback + deep, 2)
        # A parcel without a metre beside the houses keeps its lawn.
        if depth >= deep + 1.0:
            span = (-width / 2 + 0.6, width / 2 - 0.6)
            self._houses = raise_row(ground, span, self._setback, deep, _FRONTS, is_even=True)
        yield
        # All roofs of a row have the same tiles.
        tiles = draw.one_of(TILES)
        for house in self._houses:
            roof = add_row_roof(ground.builder, house, tiles)
            self._roofs += [roof] if roof else []
            yield
        # The last house has no neighbour; two houses alone are both fenced.
        for house in self._houses[: -1 if len(self._houses) > 2 else None]:
            self._part_gardens(house)
            yield
        for house in self._houses:
            self._lay_terrace(house)
            yield
        for index, house in enumerate(self._houses):
            # Every other garden has a shed.
            if index % 2 == 0:
                self._raise_shed(house)
                yield

    def _edge(self, house: Placed) -> float:
        """End of a house's plot, u."""
        u, _ = self.ground.parcel.frame.local(house.frame.x, house.frame.y)
        return u + house.size[1] / 2

    def _part_gardens(self, house: Placed) -> None:
        """Boards between a house's back garden and the next."""
        ground, edge = self.ground, self._edge(house)
        depth = ground.parcel.depth
        form = ground.draw.one_of(("boards", "hedge", "boards"))
        if depth - self._back > 4.0 and abs(edge) < ground.parcel.width / 2 - 1.5:
            start = (edge, self._back + 0.1)
            ground.fence_line(start, (edge, depth - 0.6), form, ground.draw.between(1.2, 1.7))

    def _lay_terrace(self, house: Placed) -> None:
        """A deck behind a house."""
        ground = self.ground
        if ground.parcel.depth - self._back < 4.0:
            return
        size = (3.0, round(house.size[1] - 1.4, 2), 0.15)
        u = self._edge(house) - house.size[1] / 2
        terrace = ground.stand("deck", u, self._back + 1.55, size, turn=INWARD, margin=0.02)
        self._terraces += [terrace] if terrace else []

    def _raise_shed(self, house: Placed) -> None:
        """A shed at the end of a garden."""
        ground = self.ground
        u = self._edge(house) - 1.9
        if ground.parcel.depth - self._back > 7.5:
            look = {"form": "shed"}
            ground.erect("garage", u, ground.parcel.depth - 1.8, _SHED_M, look=look)

    def details(self) -> Iterator[None]:
        """Grow chimneys, bins and bushes in front; tables, trees and beds behind."""
        yield from interleave(
            self._front(), *(self._garden(house) for house in self._houses), self._chimneys()
        )

    def _chimneys(self) -> Iterator[None]:
        for roof in self._roofs:
            add_chimney(self.ground.builder, self.ground.draw, roof)
            yield

    def _front(self) -> Iterator[None]:
        """At each door bins, a bush, now and then a bicycle or a small tree."""
        ground, draw = self.ground, self.ground.draw
        for house in self._houses:
            u = self._edge(house) - house.size[1] / 2
            side = house.size[1] / 2 - 0.9
            ground.stand("bin", u + side, 1.1, (0.7, 0.6, 1.1))
            ground.stand("bush", u - side, 1.2, (1.0, 1.2, 0.9))
            if draw.chance(0.4):
                size = (1.75, 0.55, 1.05)
                ground.stand("bicycle", u, self._setback - 0.5, size, turn=0.0)
            yield

    def _garden(self, house: Placed) -> Iterator[None]:
        """The terrace with its table, a tree, a bed of vegetables, a bench."""
        ground, draw, depth = self.ground, self.ground.draw, self.ground.parcel.depth
        u = self._edge(house) - house.size[1] / 2
        low, high = u - house.size[1] / 2 + 0.5, u + house.size[1] / 2 - 0.5
        # A terrace belongs to the house that has the same middle.
        terrace = next(
            (t for t in self._terraces if abs(self._edge(t) - t.size[1] / 2 - u) < 1), None
        )
        if terrace:
            yield from dine(on_top(ground, terrace), terrace.frame, [(0.0, 0.0)], QUARTER, chairs=2)
        if depth - self._back < 4.0:
            return
        garden = (low, high, self._back + 3.3, depth - 0.5)
        ground.plant_trees(1, garden)
        yield
        ground.stand("planter", low + 0.9, depth - 1.8, (1.2, 2.4, 0.7), turn=QUARTER)
        ground.scatter("bush", 1, near=garden)
        yield
        if draw.chance(0.5):
            ground.stand("bench", u, depth - 1.0, (0.6, 1.6, 0.85), turn=STREETWARD)
            OpenGround(ground).stand("planter", ground.parcel.frame.moved(high - 0.8, depth - 3.0))
            yield
