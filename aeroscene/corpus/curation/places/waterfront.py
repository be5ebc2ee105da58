"""A waterfront: a quay along the street, boats moored to it and to jetties, goods, benches."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.goods import (
    paint,
    plastic_crates,
    range_goods,
    set_container,
    stack_container,
)
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import park
from aeroscene.corpus.curation.places.seating import dine
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, Platform, beneath, on_top

_QUAY_M = 0.25
"""Height of the quay above the ground."""
_WATER_M = 0.1
_DRAUGHT_M = 0.03
"""Height of a keel above the bed: hulls lie in the water, not on it."""
_JETTY_M = 3.0
_JETTY_PITCH_M = 15.0
_MARINA_PITCH_M = 9.0
"""Length of quay for each jetty: a marina's berths lie as close as hulls allow."""
_BERTH_M = 0.35
"""Gap between a hull and its mooring."""


@dataclass(slots=True)
class Waterfront:
    """Quay in front, water behind it; as a marina with a jetty for every few boats."""

    ground: Ground
    is_marina: bool = False
    _edge: float = 0.0
    """End of the quay and beginning of the water, v."""
    _water: Placed | None = None
    _jetties: list[Placed] = field(default_factory=list)
    _pavilion: Placed | None = None
    _kiosk: Placed | None = None
    _boxes: list[Placed] = field(default_factory=list)

    def structures(self) -> Iterator[None]:
        """Grow quay and water; then jetties, a pavilion, containers, a kiosk, a boathouse."""
        ground, draw = self.ground, self.ground.draw
        half = ground.parcel.width / 2
        self._lay_quay()
        yield
        pitch, most = (_MARINA_PITCH_M, 7) if self.is_marina else (_JETTY_PITCH_M, 4)
        count = max(1, min(most, int(2 * half / pitch)))
        for index in range(count):
            # Jetties at equal distances, about the middle of the quay.
            self._build_jetty((index - (count - 1) / 2) * 2 * half / count)
            yield
        side = 1 if draw.chance(0.5) else -1
        size = (4.0, min(6.5, 0.5 * half), 3.2)
        at = (side * 0.5 * half, self._edge - 3.6)
        self._pavilion = ground.stand("canopy", *at, size, turn=INWARD, look=paint(draw))
        yield
        for index in range(0 if self.is_marina else 2):
            u = -side * (half - 4.0 - 7.0 * index)
            box = set_container(ground, u, 2.0, 0.0)
            if box:
                self._boxes.append(box)
                if draw.chance(0.4):
                    stack_container(ground, box)
            yield
        at = (-side * 0.25 * half, max(2.2, 0.55 * self._edge))
        self._kiosk = ground.stand("kiosk", *at, (2.4, 3.2, 2.8), turn=INWARD, look=paint(draw))
        yield
        if self._edge > 8:
            form = {"form": "shed"}
            at = (side * (half - 2.6), 2.8)
            ground.erect("garage", *at, (4.4, 3.6, 2.8), look=form)
            yield

    def _lay_quay(self) -> None:
        """Paving along the street and water behind it, side by side on the parcel's level."""
        ground, parcel = self.ground, self.ground.parcel
        share = 0.28 if self.is_marina else 0.42
        self._edge = round(min(14.0, max(5.0, share * parcel.depth)), 2)
        rest = round(parcel.depth - self._edge, 2)
        size = (parcel.width, self._edge, _QUAY_M)
        spot = parcel.frame.moved(0, self._edge / 2)
        # Built directly: `cover` would put one surface over the whole parcel.
        ground.surface = ground.builder.place("plaza", spot, size, base=parcel.level)
        form = {"form": "open"}
        v, size = self._edge + rest / 2, (parcel.width, rest, _WATER_M)
        spot = parcel.frame.moved(0, v)
        self._water = ground.builder.place("water", spot, size, base=parcel.level, look=form)

    def _afloat(self, water: Placed) -> Platform:
        """The water as a surface to float in."""
        ground = self.ground
        return Platform(ground.builder, ground.draw, water, water.base + _DRAUGHT_M)

    def _build_jetty(self, u: float) -> None:
        """Boards out into the water, level with the quay."""
        ground, water = self.ground, self._water
        rest = ground.parcel.depth - self._edge
        if water is None or rest < 7:
            return
        long = round(min(12.0, rest - 3.0), 2)
        # The jetty's planks are level with the quay, whose height counts from the ground.
        size = (long, _JETTY_M, round(_QUAY_M - _DRAUGHT_M, 2))
        spot = ground.parcel.frame.moved(u, self._edge + long / 2 + 0.02, INWARD)
        jetty = self._afloat(water).stand("deck", spot, size, margin=0.0)
        if jetty:
            self._jetties.append(jetty)

    def details(self) -> Iterator[None]:
        """Grow boats first; then goods on the quay, guests, benches that look at the water."""
        ground = self.ground
        half = ground.parcel.width / 2
        quay = (-half + 0.5, half - 0.5, 1.0, self._edge - 0.5)
        bearing = OpenGround(ground)
        yield from interleave(
            self._moor(), self._line_edge(), self._serve(), range_goods(ground, bearing, quay, 4)
        )

    def _moor(self) -> Iterator[None]:
        """Boats along both sides of each jetty, then along the quay."""
        draw, water = self.ground.draw, self._water
        if water is None:
            return
        afloat = self._afloat(water)
        for jetty in self._jetties:
            for side in (-1, 1):
                turn = INWARD if draw.chance(0.7) else -INWARD
                _moor_along(afloat, jetty, side * _JETTY_M / 2, turn)
            yield
        frame = self.ground.parcel.frame
        half = self.ground.parcel.width / 2
        slots = max(1, int(2 * half / 7.5))
        for number, index in enumerate(draw.shuffled(range(slots))):
            beam, length = draw.between(1.8, 2.6), draw.between(5.0, 6.8)
            u = (index - (slots - 1) / 2) * 2 * half / slots
            v = self._edge + _BERTH_M + beam / 2
            turn = 0.0 if draw.chance(0.5) else pi
            size = (length, beam, draw.between(1.4, 2.4))
            afloat.stand("boat", frame.moved(u, v, turn), size, look=paint(draw))
            if number % 2:
                yield
        for index in range(2):
            u = draw.between(-0.7, 0.7) * half
            v = self.ground.parcel.depth - draw.between(1.8, 3.0)
            size = (draw.between(5.0, 9.0), 2.4, draw.between(1.8, 3.0))
            afloat.stand("boat", frame.moved(u, v, index * pi), size, look=paint(draw))
            yield

    def _line_edge(self) -> Iterator[None]:
        """Benches towards the water, planters, lamps."""
        ground = self.ground
        half = ground.parcel.width / 2
        count = max(2, int(2 * half / 6.0))
        for index in range(count):
            u = (index + 0.5) * 2 * half / count - half
            ground.stand("bench", u, self._edge - 1.6, (0.6, 1.8, 0.85), turn=INWARD)
            ground.stand("planter", u + 2.2, self._edge - 0.6, (0.6, 0.6, 0.7), turn=0.0)
            if index % 2 == 0:
                at = (u - 1.9, self._edge - 1.6)
                ground.stand("street_lamp", *at, (0.9, 0.4, 4.2), turn=INWARD)
            yield
        for jetty in self._jetties:
            end = jetty.size[0] / 2 - 0.6
            on_top(ground, jetty).stand("crate", jetty.frame.moved(end, 0.8), (0.8, 0.8, 0.7))
            spot = jetty.frame.moved(end - 0.4, -0.6)
            on_top(ground, jetty).stand("bench", spot, (0.6, 1.4, 0.85))
            yield

    def _serve(self) -> Iterator[None]:
        """Tables in the pavilion, planters, a van at the kiosk, trees in the paving."""
        ground, draw = self.ground, self.ground.draw
        half, bearing = ground.parcel.width / 2, OpenGround(ground)
        if self._pavilion:
            width = self._pavilion.size[1]
            spots = [(0.0, -width / 4), (0.0, width / 4)] if width > 4.6 else [(0.0, 0.0)]
            yield from dine(beneath(ground, self._pavilion), self._pavilion.frame, spots, QUARTER)
        for box in self._boxes:
            at = box.size[0] / 2 - 1.0
            plastic_crates(bearing, box.frame.moved(at, -box.size[1] / 2 - 1.2, 0), 0.0, 0.0, 3)
            yield
        park(bearing, "van", ground.parcel.frame, draw.between(-0.5, 0.5) * half, 1.6, 0.0)
        yield
        if self._kiosk:
            for sign in (-1, 1):
                at = sign * (self._kiosk.size[1] / 2 + 0.7)
                bearing.stand("planter", self._kiosk.frame.moved(0.0, at), (1.2, 0.6, 0.9))
            yield
        for _ in range(3):
            ground.plant_trees(1, (-half, half, 0.5, 0.6 * self._edge))
            ground.scatter("planter", 1, near=(-half, half, 0.3, self._edge - 2.0), turn=0.0)
            yield
        ground.stand("sign", 0.8 * half, 0.6, (0.1, 1.4, 2.4), turn=STREETWARD)
        ground.scatter("bin", 1, near=(-half, half, 0.5, self._edge), turn=0.0)
        yield
        names = ("bicycle", "crate", "planter", "bench", "bin")
        yield from fill_up(ground, names, (-half, half, 0.5, self._edge), 8)


def _moor_along(afloat: Platform, jetty: Placed, edge: float, turn: float) -> None:
    """A boat beside a jetty, its keel along it."""
    draw = afloat.draw
    beam = draw.between(1.8, 2.4)
    length = min(draw.between(5.0, 7.5), round(jetty.size[0] - 1.0, 2))
    side = 1 if edge > 0 else -1
    at = edge + side * (_BERTH_M + beam / 2)
    # A mast about as high as the boat is long, or a cabin.
    high = draw.between(0.9, 1.15) * length if draw.chance(0.4) else draw.between(1.3, 2.2)
    size = (round(length, 2), beam, round(high, 2))
    heading = 0.0 if turn > 0 else pi
    u = draw.between(-0.1, 0.25) * (jetty.size[0] - length)
    u = max(u, -jetty.size[0] / 2 + length / 2 + 3.2)  # Clear of the boats along the quay.
    afloat.stand("boat", jetty.frame.moved(u, at, heading), size, look=paint(draw))
