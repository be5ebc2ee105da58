"""A market square: stalls with goods round a fountain, tables under an awning, kiosks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import pi

from aeroscene.corpus.curation.builder import Attributes, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import QUARTER, STREETWARD
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.goods import boxes_on, crate_stack, paint
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import park, rack_bicycles
from aeroscene.corpus.curation.places.seating import dine
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, beneath

_STALL_M = (2.6, 3.2, 2.7)
_PITCH_M = 4.6
_FOUNTAIN_M = (4.0, 4.0, 0.45)


@dataclass(slots=True)
class Market:
    """Paving with stalls along the back and the sides, open towards the street."""

    ground: Ground
    _stalls: list[Placed] = field(default_factory=list)
    _kiosks: list[Placed] = field(default_factory=list)
    _awning: Placed | None = None
    _middle: Placed | None = None

    def structures(self) -> Iterator[None]:
        """Grow three stalls and an awning; then a fountain, kiosks and more stalls."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("plaza")
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        spots = self._stall_spots()
        # Three stalls at once, so that the first step shows a market.
        for spot in spots[:3]:
            self._pitch_stall(*spot)
        yield
        side = 1 if draw.chance(0.5) else -1
        width = min(8.0, 0.9 * half)
        size = (draw.between(4.2, 5.5), round(max(3.0, width), 2), 3.3)
        u, v = side * (half - size[1] / 2 - 1.2), 0.45 * depth
        self._awning = ground.stand("canopy", u, v, size, margin=0.5, look=_awning(draw))
        yield
        name = draw.one_of(("water", "water", "deck"))
        size = _FOUNTAIN_M if name == "water" else (3.6, 5.0, 0.45)
        self._middle = ground.stand(name, -side * 0.25 * half, v, size, margin=1.2)
        yield
        kiosk = (2.8, draw.between(3.0, 4.0), 2.9)
        spot = (-side * (half - 2.4), max(2.0, 0.25 * depth))
        placed = ground.stand("kiosk", *spot, kiosk, margin=0.5, look=paint(draw))
        self._kiosks += [placed] if placed else []
        yield
        for index, spot in enumerate(spots[3:]):
            self._pitch_stall(*spot)
            if index % 2:
                yield

    def _stall_spots(self) -> list[tuple[float, float, float]]:
        """Places and headings along the back, then along the sides."""
        half, depth = self.ground.parcel.width / 2, self.ground.parcel.depth
        count = max(1, int((2 * half - 2) / _PITCH_M))
        back = [
            ((index - (count - 1) / 2) * _PITCH_M, depth - 2.4, STREETWARD)
            for index in range(count)
        ]
        order = self.ground.draw.shuffled(range(count))
        spots = [back[index] for index in order]
        # Stalls at the sides face the middle.
        sides = [(sign * (half - 2.4), 0.66 * depth, sign * pi / 2 + QUARTER) for sign in (-1, 1)]
        return [*spots, *sides]

    def _pitch_stall(self, u: float, v: float, turn: float) -> None:
        ground = self.ground
        stall = ground.stand(
            "canopy", u, v, _STALL_M, turn=turn, margin=0.5, look=_awning(ground.draw)
        )
        if stall:
            self._stalls.append(stall)

    def details(self) -> Iterator[None]:
        """Grow goods on the stalls, guests at the tables, and the usual furniture of a square."""
        yield from interleave(self._sell(), self._serve(), self._decorate())

    def _sell(self) -> Iterator[None]:
        """A counter with boxes in each stall, crates behind it."""
        ground = self.ground
        for stall in self._stalls:
            bearing = beneath(ground, stall)
            form = {"form": "trestle"}
            size = (0.85, 2.4, 0.78)
            table = bearing.stand("table", stall.frame.moved(0.5, 0.0), size, look=form)
            if table:
                boxes_on(ground, table, ground.draw.count(2, 3))
            yield
        for stall in self._stalls:
            # Behind the trader.
            crate_stack(beneath(ground, stall), stall.frame.moved(-0.75, 0, QUARTER), 0.0, 0.0)
            yield
        for kiosk in self._kiosks:
            bearing = OpenGround(ground)
            for sign in (-1, 1):
                at = sign * (kiosk.size[1] / 2 + 0.6)
                bearing.stand("bin", kiosk.frame.moved(0.6, at), (0.6, 0.6, 0.95))
            yield

    def _serve(self) -> Iterator[None]:
        """Tables in a row under the awning."""
        if self._awning is None:
            return
        _, width, _ = self._awning.size
        count = max(1, int((width - 0.8) / 2.4))
        spots = [(0.0, (index - (count - 1) / 2) * 2.4) for index in range(count)]
        bearing = beneath(self.ground, self._awning)
        yield from dine(bearing, self._awning.frame, spots, QUARTER)

    def _decorate(self) -> Iterator[None]:
        """Benches round the fountain, planters along the street, lamps, trees, a van."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        bearing = OpenGround(ground)
        if self._middle:
            reach = self._middle.size[0] / 2 + 0.9
            # On all four sides, facing the middle.
            for quarter in range(4):
                frame = self._middle.frame.moved(0, 0, quarter * QUARTER)
                bearing.stand("bench", frame.moved(reach, 0.0, pi), (0.6, 1.8, 0.85))
            yield
        for sign in (-1, 1):
            ground.stand("planter", sign * 0.55 * half, 0.8, (0.7, 2.2, 1.1))
            ground.stand("street_lamp", sign * 0.85 * half, 0.35 * depth, (0.9, 0.4, 4.2))
            yield
        ground.stand("sign", 0.2 * half, 0.6, (0.1, 1.2, 2.4))
        rack_bicycles(bearing, ground.parcel.frame, -0.15 * half, 1.2, 3)
        yield
        park(bearing, "van", ground.parcel.frame, draw.between(-0.3, 0.3) * half, 3.6, 0.0)
        yield
        for _ in range(3):
            ground.plant_trees(1, (-half, half, 0.1 * depth, 0.9 * depth))
            ground.scatter("planter", 1, turn=0.0)
            ground.scatter("bin", 1, turn=0.0)
            yield
        names = ("crate", "bench", "bin", "tree", "planter", "bicycle")
        yield from fill_up(ground, names, (-half, half, 0.3, depth), 8)


def _awning(draw: Draw) -> Attributes:
    """A colour of canvas, and a flat or pitched form."""
    return {**paint(draw), "form": draw.one_of(("flat", "pitched"))}
