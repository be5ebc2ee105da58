"""A car park: marked bays along lanes, an upper level on a ramp, solar carports, a kiosk."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER
from aeroscene.corpus.curation.places.bays import TWO_ROWS_M, BayField, paint_bays
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import rack_bicycles
from aeroscene.corpus.curation.places.rooftops import add_flat_roof, furnish_flat_roof
from aeroscene.corpus.curation.places.seating import picnic
from aeroscene.corpus.curation.places.support_surfaces import Bearing, OpenGround, Platform, on_top
from aeroscene.solids.shapes.materials import WALL_COLOURS

_BACK_M = {"level": 11.0, "shop": 8.5, "bays": 7.0, "green": 2.2}
"""Possible uses behind the first field of bays, with the depth that each needs."""
_AISLE_M = 5.4
_ISLAND_M = 2.6
_RISE_M = 1.0
"""Height of the upper level."""
_RAMP_M = 9.0
_LEVEL_V_M = 17.4
"""Start of an upper level, v."""


@dataclass(slots=True)
class Parking:
    """Asphalt with one or two fields of bays, an island of green and an aisle at the side."""

    ground: Ground
    _fields: list[BayField] = field(default_factory=list)
    _island: Placed | None = None
    _level: Placed | None = None
    _strip: Placed | None = None
    _roof: Placed | None = None
    _side: int = 1

    def structures(self) -> Iterator[None]:
        """Grow bays at the street; behind them more bays, an upper level or a shop."""
        ground, draw = self.ground, self.ground.draw
        rows = {"rows": 0, "form": "bays"}
        ground.cover("parking_lot", rows)
        self._side = 1 if draw.chance(0.5) else -1
        depth = ground.parcel.depth
        # One or two rows, with less depth in a shallow parcel.
        first = min(TWO_ROWS_M, depth - 0.4)
        self._paint(OpenGround(ground), 0.2, first)
        yield
        self._use_back(depth - _LEVEL_V_M)
        yield
        self._plant_island(first)
        yield
        for bays in self._fields:
            bays.raise_carport(ground)
            yield
        kiosk = {"colour": "blue"}
        if self._island:
            spot = self._island.frame.moved(-0.3 * first, 0.0)
            on_top(ground, self._island).stand("kiosk", spot, (2.0, 2.0, 2.5), look=kiosk)
            yield
        half = ground.parcel.width / 2
        edge = -self._side * (half - 0.2)
        ground.fence_line((edge, 0.4), (edge, depth - 0.4), "hedge", 1.1)
        yield

    def _use_back(self, rest: float) -> None:
        """An upper level, a shop, a row of bays or green, whatever fits the rest of the depth."""
        uses = [use for use, least in _BACK_M.items() if rest >= least]
        # The three largest uses that fit: a deep parcel is not left to green alone.
        match self.ground.draw.one_of(uses[:3]) if uses else "":
            case "level":
                self._raise_level(rest)
            case "shop":
                self._raise_shop(rest)
            case "bays":
                self._paint(OpenGround(self.ground), _LEVEL_V_M, min(TWO_ROWS_M, rest - 0.2))
            case "green":
                self._sow(rest)
            case _:
                pass

    def _sow(self, rest: float) -> None:
        """A strip of lawn along the back."""
        ground, depth = self.ground, self.ground.parcel.depth
        size = (round(rest - 0.2, 2), round(ground.parcel.width - 1.0, 2), 0.1)
        self._strip = ground.stand("lawn", 0, depth - size[0] / 2 - 0.1, size, margin=0.0)

    def _span(self) -> tuple[float, float]:
        """Ends of the bays along u, between island and aisle."""
        half = self.ground.parcel.width / 2
        # A narrow car park has neither island nor aisle.
        if half < 10:
            return (-half + 0.2, half - 0.2)
        inner, outer = half - _AISLE_M, half - _ISLAND_M - 0.6
        return (-outer, inner) if self._side > 0 else (-inner, outer)

    def _paint(self, bearing: Bearing, v0: float, deep: float) -> None:
        """A field of bays on some ground, from v0 on."""
        bays = paint_bays(self.ground, bearing, self._span(), v0, deep)
        self._fields += [bays] if bays else []

    def _plant_island(self, deep: float) -> None:
        """A strip of green along the side that has no aisle."""
        ground, half = self.ground, self.ground.parcel.width / 2
        if half < 10:
            return
        size = (round(deep - 1.0, 2), _ISLAND_M, 0.12)
        u = -self._side * (half - _ISLAND_M / 2 - 0.45)
        self._island = ground.stand("lawn", u, 0.6 + size[0] / 2, size, turn=QUARTER, margin=0.0)

    def _raise_level(self, rest: float) -> None:
        """An upper level of bays at the back, and the ramp that leads there along the aisle."""
        ground, half = self.ground, self.ground.parcel.width / 2
        if half < 10:
            return
        deep = round(min(rest, TWO_ROWS_M + 0.6), 2)
        width = round(2 * half - 0.2, 2)
        asphalt = {"form": "terrace", "finish": "asphalt"}
        v = _LEVEL_V_M + deep / 2
        size = (deep, width, _RISE_M)
        self._level = ground.erect("terrain", 0, v, size, turn=INWARD, look=asphalt)
        if self._level is None:
            return
        ramp = {"form": "ramp", "finish": "asphalt"}
        # The ramp lies in the aisle and ends where the upper level begins.
        u = self._side * (half - _AISLE_M / 2)
        v = _LEVEL_V_M - _RAMP_M / 2
        size = (_RAMP_M, _AISLE_M - 0.8, _RISE_M)
        ground.stand("terrain", u, v, size, turn=INWARD, margin=0.0, look=ramp)
        platform = on_top(ground, self._level)
        self._paint(platform, _LEVEL_V_M + 0.2, deep - 0.4)
        self._rail(platform)

    def _rail(self, platform: Platform) -> None:
        """A railing along the upper level's edge, apart from the head of the ramp."""
        ground, half = self.ground, self.ground.parcel.width / 2
        # Free where the ramp arrives.
        long = round(2 * half - _AISLE_M - 0.6, 2)
        u = -self._side * (half - long / 2 - 0.3)
        rails = {"form": "rails"}
        spot = ground.parcel.frame.moved(u, _LEVEL_V_M + 0.1, QUARTER)
        platform.stand("fence", spot, (0.1, long, 1.0), margin=0.0, look=rails)

    def _raise_shop(self, rest: float) -> None:
        ground, draw = self.ground, self.ground.draw
        deep, length = min(10.0, rest - 0.8), min(18.0, ground.parcel.width - 3)
        look = {"colour": draw.one_of(WALL_COLOURS), "storeys": 1, "form": "plain"}
        size = (round(deep, 2), round(length, 2), 4.2)
        v = ground.parcel.depth - deep / 2 - 0.3
        shop = ground.erect("building", 0, v, size, look=look)
        self._roof = add_flat_roof(ground.builder, shop) if shop else None

    def details(self) -> Iterator[None]:
        """Grow cars in half the bays, panels on the carports, lamps, trees on the island."""
        ground, draw = self.ground, self.ground.draw
        roof = iter(())
        if self._roof:
            roof = furnish_flat_roof(ground.builder, draw, self._roof)
        cars = interleave(*(bays.park_cars(ground) for bays in self._fields))
        extras = interleave(*(bays.equip(ground) for bays in self._fields))
        yield from interleave(cars, extras, roof, self._green())

    def _green(self) -> Iterator[None]:
        """Trees and bushes on the island; bins and trolleys elsewhere."""
        ground, draw = self.ground, self.ground.draw
        if self._island:
            island, platform = self._island, on_top(ground, self._island)
            end = island.size[0] / 2 - 1.4
            for index in range(3):
                at = -end + index * end
                height = draw.between(4.5, 6.5)
                size = (2.2, 2.2, height)
                spot = island.frame.moved(at + 0.8, 0.0)
                platform.stand("tree", spot, size, look={"form": "round"})
                platform.stand("bush", island.frame.moved(at - 1.0, 0.0), (0.9, 0.9, 0.8))
                yield
        if self._strip:
            yield from self._plant_strip(self._strip)
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        ground.stand("sign", self._side * (half - 0.5), 0.6, (0.1, 0.8, 2.4))
        yield
        aisle = self._side * (half - 0.7)
        rack_bicycles(OpenGround(ground), ground.parcel.frame.moved(aisle, 0, QUARTER), 9.0, 0, 4)
        yield
        names = ("planter", "bin", "bicycle", "bush")
        yield from fill_up(ground, names, (-half, half, 0.0, depth), 5)
        yield from fill_up(ground, ("tree", "bench", "bush"), (-half, half, _LEVEL_V_M, depth), 6)

    def _plant_strip(self, strip: Placed) -> Iterator[None]:
        """Trees in a row behind the bays, benches between them, a table for a break."""
        ground, draw = self.ground, self.ground.draw
        platform, frame = on_top(ground, strip), strip.frame
        deep, width, _ = strip.size
        count = max(2, int(width / 6.0))
        for index in range(count):
            at = (index - (count - 1) / 2) * width / count
            height = draw.between(4.5, 7.5)
            crown = round(min(0.48 * height, deep - 0.3), 2)
            spot = frame.moved(-deep / 2 + crown / 2 + 0.1, at)
            platform.stand("tree", spot, (crown, crown, height))
            platform.stand("bush", frame.moved(0.2 * deep, at + 1.6), (0.9, 1.2, 0.9))
            if index % 2:
                # Behind the trees, which stand towards the bays.
                platform.stand("bench", frame.moved(0.3 * deep, at - 1.2), (0.6, 1.8, 0.85))
            yield
        if deep > 4:
            picnic(platform, frame, 0.2 * deep, 0.5, QUARTER)
            yield
