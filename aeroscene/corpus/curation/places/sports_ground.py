"""A sports ground: a fenced court, seats beside it, changing rooms, lamps at the corners."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import park, rack_bicycles
from aeroscene.corpus.curation.places.rooftops import add_flat_roof, furnish_flat_roof
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, on_top
from aeroscene.solids.shapes.materials import WALL_COLOURS

_COURT_M = 0.05
"""Height of the court's surface above the grass."""
_FRONT_M = 6.5
"""Depth of the strip along the street: changing rooms, bicycles, benches."""
_LODGE_M = (5.2, 9.0, 3.6)
_STAND_M = (2.4, 6.0, 0.45)
"""Depth, length and height of a spectators' platform."""


@dataclass(slots=True)
class SportsGround:
    """A hard court behind a strip of green."""

    ground: Ground
    _court: Placed | None = None
    _roof: Placed | None = None
    _stands: tuple[Placed, ...] = ()

    def structures(self) -> Iterator[None]:
        """Grow court and changing rooms; then platforms for spectators, and the fence."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("lawn", {"form": "plain"})
        width, depth = ground.parcel.width, ground.parcel.depth
        long, wide = round(width - 7.6, 2), round(depth - _FRONT_M - 2.0, 2)
        if min(long, wide) >= 5.0:
            size = (min(long, 32.0), min(wide, 18.0), _COURT_M)
            look = {"form": "border", "paving": "red_paving"}
            v = _FRONT_M + size[1] / 2 + 0.6
            self._court = ground.stand("plaza", 0.0, v, size, turn=0.0, margin=0.0, look=look)
        yield
        side = 1 if draw.chance(0.5) else -1
        look = {"colour": draw.one_of(WALL_COLOURS), "storeys": 1, "form": "plain"}
        deep, length, high = _LODGE_M
        # Buildings are at least 6 m deep in the catalogue.
        size = (max(6.0, deep), min(length, round(0.5 * width, 2)), high)
        if size[1] >= 6.0:
            u = side * (width / 2 - size[1] / 2 - 0.8)
            lodge = ground.erect("building", u, size[0] / 2 + 0.3, size, look=look)
            self._roof = add_flat_roof(ground.builder, lodge) if lodge else None
        yield
        for sign in (-1, 1):
            self._raise_stand(sign)
            yield
        yield from self._fence()

    def _raise_stand(self, side: int) -> None:
        """A platform for spectators beside the court."""
        ground, court = self.ground, self._court
        if court is None:
            return
        deep, length, high = _STAND_M
        u = side * (court.size[0] / 2 + deep / 2 + 0.3)
        # Platforms are longest along y, and so is this one, whose back is to the hedge.
        spot = court.frame.moved(u, 0.0, pi if side > 0 else 0.0)
        size = (deep, min(length, round(court.size[1] - 1.0, 2)), high)
        stand = OpenGround(ground).stand("deck", spot, size, margin=0.0, look={"form": "platform"})
        self._stands += (stand,) if stand else ()

    def _fence(self) -> Iterator[None]:
        """Mesh along the court's two ends."""
        ground, court = self.ground, self._court
        if court is None:
            return
        _, v = ground.parcel.frame.local(court.frame.x, court.frame.y)
        half = court.size[0] / 2 - 0.2
        for sign in (-1, 1):
            at = v + sign * (court.size[1] / 2 + 0.2)
            ground.fence_line((-half, at), (half, at), "mesh", 2.4)
            yield

    def details(self) -> Iterator[None]:
        """Grow benches along the court, lamps, bicycles, spectators' things, trees behind."""
        ground, draw = self.ground, self.ground.draw
        roof = iter(())
        if self._roof:
            roof = furnish_flat_roof(ground.builder, draw, self._roof)
        yield from interleave(self._light(), self._arrive(), self._seat(), roof, self._plant())

    def _seat(self) -> Iterator[None]:
        """Benches in two ranks on each platform, looking at the court."""
        for stand in self._stands:
            platform = on_top(self.ground, stand)
            count = max(1, int(stand.size[1] / 2.2))
            for index in range(count):
                at = (index - (count - 1) / 2) * 2.2
                # Two ranks, the rear one at the hedge.
                for back in (-0.7, 0.4):
                    platform.stand("bench", stand.frame.moved(back, at), (0.5, 1.8, 0.85))
                yield

    def _light(self) -> Iterator[None]:
        """Floodlights at the corners; benches for both teams."""
        ground, court = self.ground, self._court
        if court is None:
            return
        bearing = OpenGround(ground)
        x, y, _ = court.size
        for su in (-1, 1):
            for sv in (-1, 1):
                spot = court.frame.moved(
                    su * (x / 2 + 0.6), sv * (y / 2 - 0.6), 0.0 if su < 0 else pi
                )
                bearing.stand("street_lamp", spot, (1.4, 0.5, 8.0))
            yield
        for sign in (-1, 1):
            for at in (-2.2, 2.2):
                spot = court.frame.moved(sign * x / 4 + at, -y / 2 - 1.1, INWARD)
                bearing.stand("bench", spot, (0.5, 2.0, 0.85))
            yield
        for sign in (-1, 1):
            spot = court.frame.moved(sign * (x / 4), -y / 2 - 1.2)
            bearing.stand("crate", spot, (0.8, 0.8, 0.7))
            bearing.stand("bin", court.frame.moved(sign * 0.9, -y / 2 - 1.1), (0.5, 0.5, 0.95))
            yield

    def _arrive(self) -> Iterator[None]:
        """Bicycles by the street, a car or two, a board with the fixtures."""
        ground, draw = self.ground, self.ground.draw
        half, bearing = ground.parcel.width / 2, OpenGround(ground)
        rack_bicycles(bearing, ground.parcel.frame, 0.0, 1.4, draw.count(4, 6))
        yield
        ground.stand("sign", 3.2, 0.7, (0.1, 1.6, 2.2), turn=STREETWARD)
        for sign in (-1, 1):
            park(bearing, "car", ground.parcel.frame, sign * 0.45 * half, 1.6, 0.0)
        yield
        ground.stand("bench", -3.0, 2.8, turn=STREETWARD)
        ground.stand("planter", 0.0, 3.2, (0.7, 2.2, 0.9))
        yield

    def _plant(self) -> Iterator[None]:
        """Trees and bushes round the ground."""
        ground = self.ground
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        for near in (
            (-half, -half + 3.4, 0.3, depth),
            (half - 3.4, half, 0.3, depth),
            (-half, half, 0.2, _FRONT_M - 1.0),
        ):
            ground.plant_trees(2, near)
            yield
            ground.scatter("bush", 2, near=near)
            yield
        yield from fill_up(ground, ("tree", "bench", "bush"), (-half, half, 0.3, depth), 8)
        ground.stand("bench", 0.0, depth - 0.8, turn=-QUARTER)
        yield
