"""A school: a long building, a yard with climbing towers and a sand pit, a fenced ball court."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.furnished_buildings import furnish, raise_furnished
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import park, rack_bicycles
from aeroscene.corpus.curation.places.rooftops import (
    add_flat_roof,
    add_monopitch_roof,
    furnish_flat_roof,
)
from aeroscene.corpus.curation.places.seating import picnic
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, beneath, on_top
from aeroscene.corpus.curation.shells import RoomSpace
from aeroscene.solids.shapes.materials import WALL_COLOURS

_TOWER_M = (3.0, 3.0, 1.1)
_COURT_M = (14.0, 8.0)
_LEAST_SHELL_M = 18.0
"""Width and depth of a parcel whose school can be entered."""
_ROOMS = ("classroom", "library", "classroom", "office")


@dataclass(slots=True)
class School:
    """A building across the back, the yard before it."""

    ground: Ground
    is_furnished: bool = False
    _rooms: tuple[RoomSpace, ...] = ()
    _roof: Placed | None = None
    _is_flat: bool = False
    _yard_v: float = 0.0
    """Depth of the yard, to the beginning of the building."""
    _towers: list[Placed] = field(default_factory=list)
    _sand: Placed | None = None
    _court: Placed | None = None
    _shade: Placed | None = None
    _side: int = 1

    def structures(self) -> Iterator[None]:
        """Grow building and a climbing tower; then court, sand pit, shade, fences."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("plaza")
        half = ground.parcel.width / 2
        self._side = side = 1 if draw.chance(0.5) else -1
        self._raise_building()
        self._raise_tower(side * 0.55 * half, 0.45 * self._yard_v)
        yield
        self._lay_court(-side)
        yield
        sand = {"form": "terrace", "finish": "gravel"}
        # The pit lies behind the tower, or before the building in a shallow yard.
        at = (side * 0.55 * half, min(self._yard_v - 2.4, 0.45 * self._yard_v + 5.6))
        self._sand = ground.stand("terrain", *at, (3.6, 4.2, 0.2), margin=0.3, look=sand)
        yield
        colour = {"colour": draw.one_of(("yellow", "orange", "green"))}
        at = (-side * 0.1 * half, self._yard_v - 2.8)
        self._shade = ground.stand("canopy", *at, (3.6, 5.0, 2.9), margin=0.4, look=colour)
        yield
        self._raise_tower(side * (half - 2.6), 0.2 * self._yard_v)
        yield
        yield from self._fence()

    def _raise_building(self) -> None:
        """Two storeys across the back."""
        ground, draw = self.ground, self.ground.draw
        width, depth = ground.parcel.width, ground.parcel.depth
        deep = round(max(6.0, min(9.5, 0.36 * depth)), 2)
        length = round(min(30.0, width - 1.6), 2)
        self._yard_v = depth - deep - 1.2
        look = {"colour": draw.one_of((*WALL_COLOURS, "brick")), "storeys": 2, "form": "ledges"}
        size = (deep, length, 6.4)
        v = depth - deep / 2 - 0.6
        school = None
        if self.is_furnished and min(width, depth) >= _LEAST_SHELL_M:
            shell = raise_furnished(
                ground,
                "building",
                0,
                v,
                deep=deep,
                length=min(length, 18.0),
                storeys=2,
                kinds=_ROOMS,
            )
            if shell:
                school, self._rooms = shell.building, shell.rooms
        else:
            school = ground.erect("building", 0, v, size, look=look)
        if school is None:
            return
        # A flat roof carries machines; a monopitch roof is a slope to land on.
        self._is_flat = draw.chance(0.6)
        if self._is_flat:
            self._roof = add_flat_roof(ground.builder, school)
        else:
            self._roof = add_monopitch_roof(ground.builder, school)

    def _raise_tower(self, u: float, v: float) -> None:
        """A platform to climb with steps on one side and a roof over it."""
        ground = self.ground
        turn = STREETWARD if ground.draw.chance(0.5) else 0.0
        tower = ground.stand("deck", u, v, _TOWER_M, turn=turn, margin=0.6)
        if tower is None:
            return
        self._towers.append(tower)
        # Steps at one end, so that children can climb up.
        at = _TOWER_M[0] / 2 + 0.6
        steps = (1.2, 1.2, _TOWER_M[2])
        OpenGround(ground).stand("stairs", tower.frame.moved(at, 0.0, pi), steps, margin=0.0)
        colour = {"colour": ground.draw.one_of(("red", "blue", "green"))}
        on_top(ground, tower).stand("canopy", tower.frame, (2.6, 2.6, 2.7), look=colour)

    def _lay_court(self, side: int) -> None:
        """A ball court with a fence along each end."""
        ground, half = self.ground, self.ground.parcel.width / 2
        width = min(_COURT_M[0], round(half - 1.5, 2))
        deep = min(_COURT_M[1], round(self._yard_v - 3.0, 2))
        if min(width, deep) < 5:
            return
        look = {"rows": 0, "form": "bays"}
        size = (width, deep, 0.03)
        u = side * (half - width / 2 - 0.8)
        self._court = ground.stand(
            "parking_lot", u, 1.0 + deep / 2, size, turn=0.0, margin=0.0, look=look
        )
        if self._court is None:
            return
        # The fences at the ends are the goals.
        rails = {"form": "mesh"}
        for sign in (-1, 1):
            at = sign * (width / 2 - 0.15)
            goal = (0.1, round(min(4.0, 0.6 * deep), 2), 2.2)
            spot = self._court.frame.moved(at, 0.0)
            on_top(ground, self._court).stand("fence", spot, goal, margin=0.0, look=rails)

    def _fence(self) -> Iterator[None]:
        """Along the street with a gate, and along both flanks of the yard."""
        ground, half = self.ground, self.ground.parcel.width / 2
        # The gate is 4 m wide, in the middle.
        edge = half - 0.25
        ground.fence_line((-edge, 0.25), (-2.0, 0.25), "rails", 1.4)
        ground.fence_line((2.0, 0.25), (edge, 0.25), "rails", 1.4)
        yield
        for side in (-1, 1):
            ground.fence_line((side * edge, 0.5), (side * edge, self._yard_v - 0.2), "hedge", 1.3)
            yield

    def details(self) -> Iterator[None]:
        """Grow bicycles and benches, playthings, trees, machines on the roof."""
        ground = self.ground
        roof = iter(())
        if self._roof and self._is_flat:
            roof = furnish_flat_roof(ground.builder, ground.draw, self._roof)
        rooms = furnish(ground, self._rooms)
        yield from interleave(rooms, self._play(), self._arrive(), roof, self._plant())

    def _play(self) -> Iterator[None]:
        """Benches from which to watch the towers and the sand, tables in the shade, crates."""
        ground, bearing = self.ground, OpenGround(self.ground)
        for watched in (*self._towers, self._sand):
            if watched is None:
                continue
            for quarter in (1, 3):
                frame = watched.frame.moved(0, 0, quarter * QUARTER)
                at = watched.size[1] / 2 + 1.4
                bearing.stand("bench", frame.moved(at, 0.0, pi), (0.5, 1.8, 0.85))
            yield
        if self._shade:
            shade = beneath(ground, self._shade)
            picnic(shade, self._shade.frame, 0.0, 0.0, QUARTER)
            yield
        for tower in self._towers:
            bearing.stand("bin", tower.frame.moved(-2.4, 1.0), (0.5, 0.5, 0.9))
            bearing.stand("crate", tower.frame.moved(-2.6, -0.6), (0.8, 0.8, 0.6))
            yield
        if self._court:
            court = self._court
            for sign in (-1, 1):
                at = (sign * court.size[0] / 4, court.size[1] / 2 + 0.7)
                bearing.stand("bench", court.frame.moved(*at, -QUARTER), (0.5, 2.0, 0.85))
            yield
            spot = court.frame.moved(0.0, court.size[1] / 2 + 2.4)
            bearing.stand("table", spot, (1.4, 2.4, 0.76))
            yield

    def _arrive(self) -> Iterator[None]:
        """Bicycles before the building, bins, a sign at the gate, the school bus."""
        ground, draw = self.ground, self.ground.draw
        half, bearing = ground.parcel.width / 2, OpenGround(ground)
        for sign in (-1, 1):
            u = sign * 0.5 * half
            rack_bicycles(bearing, ground.parcel.frame, u, self._yard_v - 0.6, draw.count(3, 5))
            yield
        ground.stand("sign", 2.8, 0.8, (0.1, 1.2, 2.0))
        ground.stand("bin", -2.6, 0.9, (0.5, 0.5, 0.95))
        yield
        for sign in (-1, 1):
            ground.stand("planter", sign * 3.2, self._yard_v - 0.5, (0.6, 1.8, 1.0))
            lamp = sign * (half - 0.9)
            turn = pi if sign > 0 else 0.0
            ground.stand("street_lamp", lamp, 0.5 * self._yard_v, (0.9, 0.4, 4.2), turn=turn)
            yield
        for index in range(4):
            u = (index - 1.5) * 0.4 * half
            ground.stand("bench", u, self._yard_v - 0.7, (0.5, 1.8, 0.85), turn=STREETWARD)
            ground.stand("planter", u + 1.7, self._yard_v - 0.6, (0.7, 0.9, 0.9))
            if index % 2:
                yield
        park(bearing, "van", ground.parcel.frame, 0.0, 0.5 * self._yard_v, INWARD)
        yield

    def _plant(self) -> Iterator[None]:
        """Trees along the fence, then where there is room."""
        ground = self.ground
        half = ground.parcel.width / 2
        yard = (-half, half, 0.6, self._yard_v)
        for index in range(4):
            # Left and right in turn, two on each side.
            side = 1 if index % 2 else -1
            v = (0.2 + 0.5 * (index // 2)) * self._yard_v
            height = ground.draw.between(4.5, 7.0)
            size = (1.7, 1.7, height)
            form = {"form": "poplar"}
            ground.stand("tree", side * (half - 1.4), v, size, turn=0.0, look=form)
            yield
        ground.plant_trees(2, yard)
        yield
        names = ("planter", "tree", "bush", "bench", "bin", "tree", "bicycle", "bush", "crate")
        yield from fill_up(ground, names, yard, 14)
