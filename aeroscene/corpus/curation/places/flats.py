"""Blocks of flats and towers: slabs round a green court, with balconies and roof gardens."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import line_way, park, rack_bicycles
from aeroscene.corpus.curation.places.rooftops import (
    add_flat_roof,
    furnish_flat_roof,
    furnish_roof_deck,
    lay_roof_deck,
)
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, Platform, beneath, on_top
from aeroscene.solids.shapes.materials import WALL_COLOURS

_STOREY_M = 3.2
_BAY_M = 3.0
_TOWER_M = 9.0
"""Side of a tower."""
_BALCONY_M = (2.2, 3.6, 0.2)
_BEARING_M = 0.12
"""Depth by which a balcony extends into the wall that carries it."""
_PATH_M = (1.8, 0.05)


@dataclass(slots=True)
class Flats:
    """One or two tall buildings and a court behind them.

    Balconies hang only on plain masses, because ledges already project from the others.
    """

    ground: Ground
    _masses: list[Placed] = field(default_factory=list)
    """Buildings with a plain wall for balconies to hang on."""
    _roofs: list[Placed] = field(default_factory=list)
    _roof_deck: Placed | None = None
    _balconies: list[Placed] = field(default_factory=list)
    _shelter: Placed | None = None
    _path: Placed | None = None
    _court_v: float = 0.0

    def structures(self) -> Iterator[None]:
        """Grow a slab along the street, then a second mass, a path, a roof garden, balconies."""
        ground, draw = self.ground, self.ground.draw
        ground.cover(draw.one_of(("lawn", "lawn", "plaza")))
        self._raise_slab()
        yield
        self._raise_behind()
        yield
        self._pave_path()
        yield
        self._raise_shelter()
        yield
        if self._roofs and draw.chance(0.5):
            # The first roof becomes a garden, the others carry machines.
            roof = self._roofs.pop(0)
            self._roof_deck = lay_roof_deck(ground.builder, draw, roof)
            if self._roof_deck is None:
                self._roofs.insert(0, roof)
            yield
        for storey in range(2):
            self._hang_balcony(storey)
            yield
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        for side in (-1, 1):
            edge = side * (half - 0.4)
            if depth - self._court_v > 3:
                ground.fence_line((edge, self._court_v + 0.5), (edge, depth - 0.5), "hedge", 1.2)
            yield

    def _raise_slab(self) -> None:
        """The main block, with room for its length behind the sidewalk."""
        ground, draw = self.ground, self.ground.draw
        width, depth = ground.parcel.width, ground.parcel.depth
        bays = max(2, min(8, int((width - 3) / _BAY_M)))
        length = _BAY_M * draw.count(max(2, bays - 2), bays)
        # Whole bays of the facade, so that windows are not cut.
        deep = min(_BAY_M * draw.count(3, 4), max(6.0, round(depth - 5.5, 2)))
        setback = min(draw.between(3.0, 5.0), max(0.5, depth - deep - 0.5))
        u = draw.between(-0.5, 0.5) * max(0.0, width - length - 2)
        # A tower replaces the slab now and then, and leaves more of the court.
        if deep >= _TOWER_M and draw.chance(0.3):
            self._raise_tower(u, setback + _TOWER_M / 2)
            self._court_v = setback + _TOWER_M
            return
        self._mass(u, setback + deep / 2, deep, length, draw.count(3, 5))
        self._court_v = setback + deep

    def _raise_behind(self) -> None:
        """A tower or a lower block at the back of the court."""
        ground, draw = self.ground, self.ground.draw
        width, depth = ground.parcel.width, ground.parcel.depth
        if depth - self._court_v < 15.0:
            return
        v = depth - 1.5 - _TOWER_M / 2
        u = draw.between(-0.5, 0.5) * (width - _TOWER_M - 5)
        if draw.chance(0.5):
            self._raise_tower(u, v)
        else:
            form = draw.one_of(("ledges", "ledges", "plain"))
            self._mass(u, v, _TOWER_M, _TOWER_M + _BAY_M, draw.count(2, 4), form)

    def _raise_tower(self, u: float, v: float) -> None:
        draw = self.ground.draw
        look = {"colour": draw.one_of(WALL_COLOURS)}
        size = (_TOWER_M, _TOWER_M, draw.between(16, 21))
        self.ground.erect("tower", u, v, size, look=look)

    def _mass(
        self, u: float, v: float, deep: float, length: float, storeys: int, form: str = "plain"
    ) -> None:
        ground, draw = self.ground, self.ground.draw
        look = {"colour": draw.one_of((*WALL_COLOURS, "brick")), "storeys": storeys, "form": form}
        size = (deep, length, round(storeys * _STOREY_M, 2))
        mass = ground.erect("building", u, v, size, look=look)
        if mass is None:
            return
        if form == "plain":
            self._masses.append(mass)
        roof = add_flat_roof(ground.builder, mass)
        if roof:
            self._roofs.append(roof)

    def _pave_path(self) -> None:
        """A path through the court, past the slab's flank or from its back door."""
        ground, depth = self.ground, self.ground.parcel.depth
        long = depth - self._court_v - 0.6
        if long < 4:
            return
        u = ground.draw.between(-0.2, 0.2) * ground.parcel.width
        v = self._court_v + 0.5 + long / 2
        size = (round(long, 2), *_PATH_M)
        self._path = ground.stand("sidewalk", u, v, size, turn=QUARTER, margin=0.0)

    def _raise_shelter(self) -> None:
        """A roof for bicycles behind the slab, or in front of it."""
        ground, draw = self.ground, self.ground.draw
        half = ground.parcel.width / 2
        look = {"colour": draw.one_of(("silver", "green", "blue"))}
        side = 1 if draw.chance(0.5) else -1
        for v in (self._court_v + 1.8, 1.4):
            u = side * (half - 3.2)
            size = (2.2, 4.6, 2.6)
            self._shelter = ground.stand("canopy", u, v, size, margin=0.3, look=look)
            if self._shelter:
                return

    def _hang_balcony(self, storey: int) -> None:
        """A slab that reaches into the court or over the front garden, with a railing."""
        ground, draw = self.ground, self.ground.draw
        if not self._masses:
            return
        mass = self._masses[0]
        # Towards the court if there is one, otherwise over the front garden.
        side = -1 if ground.parcel.depth - self._court_v > 4 else 1
        reach = mass.size[1] / 2 - _BALCONY_M[1] / 2 - 0.3
        u = side * (mass.size[0] / 2 + _BALCONY_M[0] / 2 - _BEARING_M)
        v = draw.between(-1, 1) * reach
        base = mass.base + (storey + 1) * _STOREY_M - _BALCONY_M[2]
        # The balcony and its building overlap by `_BEARING_M`, which only parent and child may.
        balcony = ground.builder.place(
            "floor", mass.frame.moved(u, v), _BALCONY_M, base=base, parent=mass, within=None
        )
        if balcony is None:
            return
        rail = (0.08, _BALCONY_M[1], 1.0)
        edge = side * (_BALCONY_M[0] / 2 - 0.06)
        look = {"form": "rails"}
        spot = balcony.frame.moved(edge, 0.0)
        on_top(ground, balcony).stand("fence", spot, rail, margin=0.0, look=look)
        self._balconies.append(balcony)

    def details(self) -> Iterator[None]:
        """Grow machines on the roofs, bicycles, life in the court, plants on the balconies."""
        ground, draw = self.ground, self.ground.draw
        roofs = [furnish_flat_roof(ground.builder, draw, roof) for roof in self._roofs]
        if self._roof_deck:
            roofs.append(furnish_roof_deck(ground.builder, draw, self._roof_deck))
        yield from interleave(*roofs, self._live_outside(), self._plant())

    def _live_outside(self) -> Iterator[None]:
        ground, draw = self.ground, self.ground.draw
        half = ground.parcel.width / 2
        if self._shelter:
            shelter = beneath(ground, self._shelter)
            rack_bicycles(shelter, self._shelter.frame.moved(0, 0, QUARTER), 0, 0, draw.count(3, 5))
            yield
        for _ in range(2):
            u = draw.between(-0.8, 0.8) * half
            turn = 0.0 if draw.chance(0.5) else 2 * QUARTER
            park(OpenGround(ground), draw.one_of(("car", "van")), ground.parcel.frame, u, 1.4, turn)
            yield
        if self._path:
            end = self._path.size[0] / 2
            yield from line_way(
                OpenGround(ground), self._path.frame, (-end, end), self._path.size[1] / 2
            )
        for balcony in self._balconies:
            self._furnish_balcony(balcony)
            yield

    def _furnish_balcony(self, balcony: Placed) -> None:
        platform = on_top(self.ground, balcony)
        self._chair(platform, -0.9)
        platform.stand("plant", balcony.frame.moved(0.0, 1.3), (0.5, 0.5, 1.0))

    def _chair(self, platform: Platform, along: float) -> None:
        turn = INWARD if along < 0 else STREETWARD
        platform.stand("chair", platform.bearer.frame.moved(0.0, along, turn), (0.5, 0.5, 0.9))

    def _plant(self) -> Iterator[None]:
        """Trees in the court and before the front, bushes, bins."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        court = (-half, half, self._court_v, depth)
        for _ in range(3):
            ground.plant_trees(2, court)
            yield
            ground.scatter("bush", 2, near=court)
            yield
        for _ in range(2):
            bin_u = draw.between(-0.9, 0.9) * half
            ground.stand("bin", bin_u, self._court_v + 0.7, (0.7, 0.6, 1.1), turn=INWARD)
            ground.scatter("planter", 1, near=(-half, half, 0.2, 2.6), turn=0.0)
            yield
        names = ("bench", "tree", "bush", "bicycle", "planter", "tree", "table")
        yield from fill_up(ground, names, (-half, half, 0.2, depth), 10)
