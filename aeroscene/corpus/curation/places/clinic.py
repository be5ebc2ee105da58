"""A clinic: a main wing and two side wings round a forecourt, a pad for air ambulances."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import park, rack_bicycles
from aeroscene.corpus.curation.places.rooftops import (
    add_flat_roof,
    furnish_flat_roof,
    roof_top,
)
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, on_top
from aeroscene.solids.shapes.materials import WALL_COLOURS

_WING_M = (7.5, 9.0)
"""Depth of a wing."""
_STOREY_M = 3.5
_PORCH_M = (4.0, 6.0, 3.4)
_PAD_M = (5.2, 5.2, 0.05)
_LEAST_COURT_M = 9.0


@dataclass(slots=True)
class Clinic:
    """Wings of one colour round a court that opens towards the street.

    Each wing takes its part of the court, and the rest is the forecourt. On a narrow parcel side
    wings are left out.
    """

    ground: Ground
    _wings: list[Placed] = field(default_factory=list)
    _roofs: list[Placed] = field(default_factory=list)
    _porch: Placed | None = None
    _garden: Placed | None = None
    _court: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    """u0, u1, v0, v1 of the forecourt."""

    def structures(self) -> Iterator[None]:
        """Grow the three wings; then roofs, the porch, a garden in the court."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("plaza", {"form": "border", "paving": "paving"})
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        self._court = (-half, half, 0.0, depth)
        colour, storeys = draw.one_of((*WALL_COLOURS, "brick")), draw.count(2, 4)
        look = {"colour": colour, "storeys": storeys, "form": "plain"}
        self._raise_main(look, storeys)
        for side in (-1, 1):
            self._raise_side(side, look, max(1, storeys - draw.count(0, 2)))
        yield
        for wing in self._wings:
            roof = add_flat_roof(ground.builder, wing)
            self._roofs += [roof] if roof else []
            yield
        u0, u1, v0, v1 = self._court
        look = {"colour": "white", "form": "flat"}
        at = ((u0 + u1) / 2, v1 - _PORCH_M[0] / 2 - 0.05)
        self._porch = ground.stand("canopy", *at, _PORCH_M, margin=0.0, look=look)
        yield
        size = (round(0.4 * (u1 - u0), 2), round(min(6.0, 0.4 * (v1 - v0)), 2), 0.08)
        if min(size[:2]) >= 2.0:
            at = ((u0 + u1) / 2, 0.3 * v1)
            self._garden = ground.stand("lawn", *at, size, turn=0.0, look={"form": "beds"})
        yield

    def _raise_main(self, look: dict[str, str | int], storeys: int) -> None:
        """The wing across the back."""
        ground, draw = self.ground, self.ground.draw
        u0, u1, v0, v1 = self._court
        deep = draw.between(*_WING_M)
        # The court comes first: the main wing is made shallower, or left out below 6 m.
        if v1 - deep < _LEAST_COURT_M:
            deep = round(v1 - _LEAST_COURT_M, 2)
        if deep < 6.0:
            return
        size = (deep, round(min(u1 - u0 - 0.4, 38.0), 2), round(_STOREY_M * storeys, 2))
        main = ground.erect("building", 0.0, v1 - deep / 2 - 0.2, size, margin=0.0, look=look)
        if main:
            self._wings.append(main)
            self._court = (u0, u1, v0, round(v1 - deep - 0.2, 2))

    def _raise_side(self, side: int, look: dict[str, str | int], storeys: int) -> None:
        """A wing forward along one flank, looking into the court."""
        ground = self.ground
        u0, u1, v0, v1 = self._court
        thick = ground.draw.between(6.4, 7.6)
        long = round(v1 - v0 - 2.5, 2)
        # A side wing needs a court that stays wide enough, and a main wing to meet.
        if u1 - u0 - thick < _LEAST_COURT_M or long < 6.2 or not self._wings:
            return
        at = u1 - thick / 2 - 0.2 if side > 0 else u0 + thick / 2 + 0.2
        # Both side wings have their front (+x) towards the court.
        turn = 2 * QUARTER if side > 0 else 0.0
        size = (thick, long, round(_STOREY_M * storeys, 2))
        look = {**look, "storeys": storeys}
        v = v1 - long / 2
        wing = ground.erect("building", at, v, size, turn=turn, margin=0.0, look=look)
        if wing:
            self._wings.append(wing)
            cut = thick + 0.2
            self._court = (u0, u1 - cut, v0, v1) if side > 0 else (u0 + cut, u1, v0, v1)

    def details(self) -> Iterator[None]:
        """Grow a pad on the main roof, machines on the others, ambulances, benches, trees."""
        ground, draw = self.ground, self.ground.draw
        # The first roof is the main wing's, which has the pad.
        roofs = [furnish_flat_roof(ground.builder, draw, roof) for roof in self._roofs[1:]]
        yield from interleave(self._crown(), self._arrive(), *roofs, self._rest())

    def _crown(self) -> Iterator[None]:
        """The pad for helicopters in the middle of the main roof, machines at its ends."""
        if not self._roofs:
            return
        top = roof_top(self.ground.builder, self.ground.draw, self._roofs[0])
        # As large as the roof allows, and left out below 2 m.
        side = min(_PAD_M[0], round(2 * top.half_v - 0.4, 2))
        if side >= 2.0:
            top.platform.stand("landing_pad", top.frame, (side, side, 0.05), margin=0.3)
            yield
        for sign in (-1, 1):
            for index in range(2):
                u = sign * (top.half_u - 0.9 - 2.0 * index)
                top.platform.stand("ac_unit", top.frame.moved(u, 0.4 * top.half_v, QUARTER))
            yield

    def _arrive(self) -> Iterator[None]:
        """Ambulances by the porch, cars along the court, bicycles."""
        ground, draw = self.ground, self.ground.draw
        u0, u1, _, v1 = self._court
        middle, bearing = (u0 + u1) / 2, OpenGround(ground)
        for side in (-1, 1):
            look = {"colour": "white", "form": "panel"}
            u, v = middle + side * 4.6, v1 - 3.6
            bearing_spot = ground.parcel.frame.moved(u, v, INWARD)
            bearing.stand("van", bearing_spot, (5.6, 2.0, 2.6), margin=0.15, look=look)
            yield
        for index in range(3):
            u = u1 - 1.8 - 2.7 * index
            park(bearing, "car", ground.parcel.frame, u, 2.9, INWARD if index else -INWARD)
            yield
        rack_bicycles(bearing, ground.parcel.frame, u0 + 2.8, 1.4, draw.count(4, 6))
        yield
        ground.stand("sign", middle - 4.0, 0.7, (0.2, 2.0, 2.4), turn=STREETWARD)
        yield

    def _rest(self) -> Iterator[None]:
        """Benches round the garden, trees in it, planters at the porch."""
        ground, draw = self.ground, self.ground.draw
        bearing = OpenGround(ground)
        if self._garden:
            garden, platform = self._garden, on_top(ground, self._garden)
            for sign in (-1, 1):
                crown = draw.between(1.8, min(3.0, garden.size[1] - 0.4))
                size = (crown, crown, draw.between(4.5, 6.0))
                at = sign * 0.28 * garden.size[0]
                platform.stand("tree", garden.frame.moved(at, 0.0), size, look={"form": "round"})
                platform.stand("bush", garden.frame.moved(0.45 * at, 0.3), (0.9, 0.9, 0.8))
                spot = garden.frame.moved(at, sign * (garden.size[1] / 2 + 0.7), -sign * QUARTER)
                bearing.stand("bench", spot, (0.6, 1.8, 0.85))
                yield
        if self._porch:
            for sign in (-1, 1):
                spot = self._porch.frame.moved(0.8, sign * (self._porch.size[1] / 2 + 0.7), pi)
                bearing.stand("planter", spot, (0.7, 1.2, 0.9))
                bin_spot = self._porch.frame.moved(-0.9, sign * (self._porch.size[1] / 2 + 0.6))
                bearing.stand("bin", bin_spot, (0.5, 0.5, 0.95))
            yield
        u0, u1, _, v1 = self._court
        names = ("bench", "planter", "tree", "bicycle", "bush")
        yield from fill_up(ground, names, (u0, u1, 0.3, v1), 7)
