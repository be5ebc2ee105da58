"""A block of a town: houses wall to wall along the street, wings at the flanks, a court within.

Two wings make a U and, with a back row, a closed block; one wing makes an L. A gate between the
front row and the flank leads into the court, so that a drone finds both a passage and an enclosed
space.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import park, rack_bicycles
from aeroscene.corpus.curation.places.rooftops import (
    TILES,
    add_chimney,
    add_flat_roof,
    add_row_roof,
    furnish_flat_roof,
)
from aeroscene.corpus.curation.places.rows import Fronts, raise_row
from aeroscene.corpus.curation.places.seating import picnic
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, beneath, on_top
from aeroscene.solids.shapes.materials import WALL_COLOURS

_FRONTS = Fronts(width_m=13.5, least_m=7.5, storeys=(3, 5), forms=("plain", "plain", "podium"))
_REAR = Fronts(width_m=15.0, least_m=8.0, storeys=(2, 4), forms=("plain", "ledges"))
_DEEP_M = (12.0, 15.0)
_WING_M = (7.0, 9.0)
"""Depths of the row along the street, and of wings and back row."""
_GATE_M = 3.4
"""Width of the passage into the court: a van fits."""
_COURT_M = 6.6
"""Least side of a court."""
_YARD_M = 2.4
"""Least depth of the yard behind the row: bins and bicycles stand there."""
_GATED_M = 8.5
"""Least depth of a court that has a gate; a shallower yard is reached through the houses."""
_LEAST_WING_M = 6.2


@dataclass(slots=True)
class ClosedBlock:
    """Houses round a court.

    Each mass takes its part of the court; a mass that would make it narrower than `_COURT_M` is
    left out.
    """

    ground: Ground
    _masses: list[Placed] = field(default_factory=list)
    _pitched: list[Placed] = field(default_factory=list)
    _flat: list[Placed] = field(default_factory=list)
    _court: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    """Ends u0, u1, v0, v1 of the area that stays open."""
    _path: Placed | None = None
    _shelter: Placed | None = None

    def structures(self) -> Iterator[None]:
        """Grow the masses; then roofs, the way into the court, a shelter."""
        ground, draw = self.ground, self.ground.draw
        ground.cover(draw.one_of(("plaza", "lawn", "lawn")))
        half = ground.parcel.width / 2
        gate = self._gate()
        deep = self._raise_front(gate)
        if deep:
            for side in (-1, 1):
                # A wing behind the gate would close it.
                if abs(side * half - gate) > _WING_M[1] + _GATE_M / 2:
                    self._raise_wing(side)
            self._raise_rear()
        yield
        for mass in self._masses:
            self._cover(mass)
            yield
        self._pave_way(gate, deep)
        yield
        self._raise_shelter()
        yield

    def _gate(self) -> float:
        """Middle of the gate, u: between two houses of a long row, else at one of its ends."""
        half, draw = self.ground.parcel.width / 2, self.ground.draw
        side = 1 if draw.chance(0.5) else -1
        # A row this long leaves space for a house on either side of the gate.
        if half > _WING_M[1] + _FRONTS.least_m / 2 + _GATE_M:
            return side * draw.between(0.0, half - _WING_M[1] - _GATE_M)
        return side * (half - _GATE_M / 2)

    def _raise_front(self, gate: float) -> float:
        """Raise houses along the street on both sides of the gate; without a court, no gate.

        Returns:
            Their depth, m; zero if the parcel is too shallow for any.
        """
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        deep = min(draw.between(*_DEEP_M), round(depth - _YARD_M, 2))
        if deep < _LEAST_WING_M:
            return 0.0
        spans = [(-half, half)]
        # A gate needs a court to lead to, and houses beside it.
        if depth - deep >= _GATED_M and 2 * half > 16.0:
            spans = [(-half, gate - _GATE_M / 2), (gate + _GATE_M / 2, half)]
        for low, high in spans:
            self._masses += raise_row(ground, (low, high), 0.0, deep, _FRONTS)
        self._court = (-half, half, deep, depth)
        return deep

    def _raise_wing(self, side: int) -> None:
        """A wing from the front row to the back, along one flank, looking into the court."""
        ground, draw = self.ground, self.ground.draw
        u0, u1, v0, v1 = self._court
        thick = draw.between(*_WING_M)
        # A wing that is left out leaves its part to the court.
        if u1 - u0 - thick < _COURT_M or v1 - v0 < _LEAST_WING_M:
            return
        turn = 2 * QUARTER if side > 0 else 0.0
        at = u1 - thick / 2 if side > 0 else u0 + thick / 2
        storeys = draw.count(2, 4)
        look = {
            "colour": draw.one_of((*WALL_COLOURS, "brick")),
            "storeys": storeys,
            "form": "plain",
        }
        size = (thick, round(v1 - v0, 2), round(3.2 * storeys, 2))
        wing = ground.erect("building", at, (v0 + v1) / 2, size, turn=turn, margin=0.0, look=look)
        # The wing is part of the border from now on.
        if wing:
            self._masses.append(wing)
            self._court = (u0, u1 - thick, v0, v1) if side > 0 else (u0 + thick, u1, v0, v1)

    def _raise_rear(self) -> None:
        """A row along the back if the court stays wide enough."""
        ground, draw = self.ground, self.ground.draw
        u0, u1, v0, v1 = self._court
        deep = draw.between(*_WING_M)
        if v1 - v0 - deep < _COURT_M:
            return
        row = raise_row(ground, (u0, u1), v1 - deep, deep, _REAR)
        if row:
            self._masses += row
            self._court = (u0, u1, v0, v1 - deep)

    def _cover(self, mass: Placed) -> None:
        """A gable roof, or a flat one with a parapet."""
        ground, draw = self.ground, self.ground.draw
        if draw.chance(0.25):
            roof = add_row_roof(ground.builder, mass, draw.one_of(TILES))
            self._pitched += [roof] if roof else []
            return
        roof = add_flat_roof(ground.builder, mass)
        self._flat += [roof] if roof else []

    def _pave_way(self, gate: float, deep: float) -> None:
        """Paving from the street through the gate into the court."""
        ground = self.ground
        if not self._masses or self._court[3] - self._court[2] < _COURT_M:
            return
        # Paving ends three metres within the court.
        long = round(deep + 3.0, 2)
        size = (long, _GATE_M - 0.6, 0.05)
        self._path = ground.stand("sidewalk", gate, long / 2, size, turn=INWARD, margin=0.0)

    def _raise_shelter(self) -> None:
        """A roof for bicycles at the back of the court."""
        ground, draw = self.ground, self.ground.draw
        u0, u1, _, v1 = self._court
        look = {"colour": draw.one_of(("silver", "green", "blue"))}
        u = draw.between(u0 + 3.0, max(u0 + 3.0, u1 - 3.0))
        self._shelter = ground.stand("canopy", u, v1 - 1.5, (2.2, 4.6, 2.6), margin=0.2, look=look)

    def details(self) -> Iterator[None]:
        """Grow machines and chimneys on the roofs, bicycles, bins and trees in the court."""
        ground, draw = self.ground, self.ground.draw
        roofs = [furnish_flat_roof(ground.builder, draw, roof) for roof in self._flat]
        yield from interleave(self._live(), *roofs, self._chimneys(), self._plant())

    def _chimneys(self) -> Iterator[None]:
        for roof in self._pitched:
            add_chimney(self.ground.builder, self.ground.draw, roof)
            yield

    def _live(self) -> Iterator[None]:
        """Bicycles under their roof, bins by the gate, a van that delivers, a table."""
        ground, draw = self.ground, self.ground.draw
        u0, u1, v0, v1 = self._court
        if self._shelter:
            frame = self._shelter.frame.moved(0, 0, QUARTER)
            rack_bicycles(beneath(ground, self._shelter), frame, 0, 0, draw.count(4, 6))
            yield
        for index in range(3):
            u = (u0 + u1) / 2 + (index - 1) * 0.9
            ground.stand("bin", u, v0 + 0.7, (0.7, 0.75, 1.1), turn=INWARD)
        yield
        if self._path:
            end = self._path.size[0] / 2 - 3.2
            name = draw.one_of(("car", "van"))
            park(on_top(ground, self._path), name, self._path.frame, end, 0.0, 0.0)
            yield
        # A table needs a court in which people can sit off the walls.
        if v1 - v0 > 7 and u1 - u0 > 7:
            at = (draw.between(u0 + 2.5, u1 - 2.5), draw.between(v0 + 3.0, v1 - 3.0))
            picnic(OpenGround(ground), ground.parcel.frame, *at, 0.0)
            yield

    def _plant(self) -> Iterator[None]:
        """Trees and bushes in the court, a bench under them."""
        ground = self.ground
        court = self._court
        for _ in range(2):
            ground.plant_trees(1, court)
            ground.scatter("bush", 2, near=court)
            yield
        yield from fill_up(ground, ("bench", "planter", "bush", "bicycle"), court, 6)
