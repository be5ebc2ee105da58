"""A furnished building of one or two storeys with a forecourt: offices, flats or a cafe."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER
from aeroscene.corpus.curation.places.furnished_buildings import furnish, raise_furnished
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import line_way, park, rack_bicycles
from aeroscene.corpus.curation.places.rooftops import (
    add_flat_roof,
    furnish_flat_roof,
    furnish_roof_deck,
    lay_roof_deck,
)
from aeroscene.corpus.curation.places.seating import dine
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, beneath, on_top
from aeroscene.corpus.curation.shells import RoomSpace
from aeroscene.solids.shapes.materials import WALL_COLOURS

_PROGRAMMES = {
    "offices": ("office", "meeting", "office", "washroom", "office", "store"),
    "flats": ("living", "kitchen", "bedroom", "bathroom", "bedroom"),
    "cafe": ("cafe", "galley", "store", "office"),
    "studio": ("open_office", "meeting", "workshop", "kitchen"),
    "library": ("library", "office", "meeting", "washroom"),
}
"""Kinds of rooms of each use, in the order in which a building offers them."""
_LEAST_SHELL_M = (11.5, 16.0)
"""Width and depth of a parcel whose building can be entered."""
_BAY_M = (3.2, 3.36)
"""Range of the length of front for each window."""
_BAYS_M = (5.2, 7.7, 0.02)
"""Field of three bays for visitors: depth, width and thickness."""


@dataclass(slots=True)
class Offices:
    """Offices, flats or a cafe that a drone can fly into."""

    ground: Ground
    _use: str = ""
    _rooms: list[RoomSpace] = field(default_factory=list)
    _building: Placed | None = None
    _roof: Placed | None = None
    _roof_deck: Placed | None = None
    _terrace: Placed | None = None
    _pavilion: Placed | None = None
    _bays: Placed | None = None
    _walk: Placed | None = None

    def structures(self) -> Iterator[None]:
        """Grow the furnished building and its roof, then terrace, bays, garden path, pavilion."""
        ground, draw = self.ground, self.ground.draw
        self._use = draw.one_of(tuple(_PROGRAMMES))
        ground.cover(draw.one_of(("lawn", "plaza", "lawn")))
        u, setback, deep, length = self._raise(draw.between(5.0, 6.5))
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        yield
        if self._building and setback > 4.2:
            size = (3.2, min(8.0, round(length - 2, 2)), 0.15)
            self._terrace = ground.stand("deck", u, setback - 1.75, size, margin=0.02)
        yield
        if self._roof and draw.chance(0.4):
            self._roof_deck = lay_roof_deck(ground.builder, draw, self._roof)
        yield
        # The bays are opposite the building, as far as it is off the middle.
        side = 1 if u < 0 else -1
        bays = {"rows": 1}
        at = (side * (half - _BAYS_M[1] / 2 - 0.3), _BAYS_M[0] / 2 + 0.2)
        size = (_BAYS_M[1], _BAYS_M[0], _BAYS_M[2])
        self._bays = ground.stand("parking_lot", *at, size, turn=0.0, look=bays)
        yield
        garden = depth - setback - deep
        if garden > 5:
            long = round(min(2 * half - 3, 22.0), 2)
            v = setback + deep + 1.6
            # Just behind the building, and along the whole back.
            self._walk = ground.stand("sidewalk", 0.0, v, (long, 1.6, 0.05), turn=0.0)
            yield
            size = (3.6, 4.4, 3.0)
            colour = {"colour": draw.one_of(("white", "green", "red"))}
            self._pavilion = ground.stand(
                "canopy", -side * 0.5 * half, depth - 2.6, size, look=colour
            )
            yield
        ground.fence_line((-half + 0.4, depth - 0.3), (half - 0.4, depth - 0.3), "hedge", 1.3)
        yield

    def _raise(self, setback: float) -> tuple[float, float, float, float]:
        """Put the building up.

        Returns:
            Place along the street, setback, depth and length, m.
        """
        ground, draw = self.ground, self.ground.draw
        width, depth = ground.parcel.width, ground.parcel.depth
        # Two storeys are shorter, so that both have about the same number of rooms.
        storeys = 1 if draw.chance(0.6) else 2
        bays = 4 if storeys == 1 else 3
        length = round(min(bays * draw.between(*_BAY_M), width - 2.0), 2)
        deep = round(min(draw.between(7.5, 9.5), depth - setback - 1.0), 2)
        u = draw.between(-0.5, 0.5) * max(0.0, width - length - 3)
        if width >= _LEAST_SHELL_M[0] and depth >= _LEAST_SHELL_M[1]:
            shell = raise_furnished(
                ground,
                "building",
                u,
                setback + deep / 2,
                deep=deep,
                length=length,
                storeys=storeys,
                kinds=_PROGRAMMES[self._use],
            )
            if shell:
                self._building, self._rooms = shell.building, list(shell.rooms)
        # Without space for a shell, a plain mass keeps the parcel built up.
        else:
            deep = round(max(6.0, deep), 2)
            setback = round(max(0.6, min(setback, depth - deep - 0.6)), 2)
            look = {"colour": draw.one_of(WALL_COLOURS), "form": "plain"}
            size = (deep, length, 6.4)
            self._building = ground.erect("building", u, setback + deep / 2, size, look=look)
        if self._building:
            self._roof = add_flat_roof(ground.builder, self._building)
        return u, setback, deep, length

    def details(self) -> Iterator[None]:
        """Grow furniture inside and on the terrace, machines on the roof, the forecourt."""
        ground, draw = self.ground, self.ground.draw
        roofs: list[Iterator[None]] = []
        if self._roof:
            roofs.append(furnish_flat_roof(ground.builder, draw, self._roof))
        if self._roof_deck:
            roofs.append(furnish_roof_deck(ground.builder, draw, self._roof_deck))
        rooms = furnish(ground, self._rooms)
        yield from interleave(rooms, self._receive(), *roofs, self._garden())

    def _receive(self) -> Iterator[None]:
        """Planters and tables on the terrace, bicycles, cars in the visitors' bays."""
        ground, draw = self.ground, self.ground.draw
        half = ground.parcel.width / 2
        if self._terrace:
            terrace, platform = self._terrace, on_top(ground, self._terrace)
            reach = terrace.size[1] / 2
            for sign in (-1, 1):
                spot = terrace.frame.moved(-0.9, sign * (reach - 0.7))
                platform.stand("planter", spot, (0.5, 1.2, 0.9))
            yield
            if reach > 2.6:
                spots = [(0.3, sign * (reach - 1.2)) for sign in (-1, 1)]
                yield from dine(platform, terrace.frame, spots, 0.0, chairs=2)
        if self._bays:
            bays = on_top(ground, self._bays)
            for index in draw.shuffled(range(3)):
                at = (index - 1) * 2.5
                turn = INWARD if draw.chance(0.6) else -INWARD
                park(bays, "car", self._bays.frame, at, 0.0, turn)
                yield
        bearing = OpenGround(ground)
        u = draw.between(-0.7, 0.7) * half
        rack_bicycles(bearing, ground.parcel.frame, u, 1.4, draw.count(3, 4))
        # Anywhere along the front.
        yield
        ground.stand("sign", -0.3 * half, 0.7, (0.12, 1.6, 2.2))
        for _ in range(2):
            ground.stand("bench", draw.between(-0.8, 0.8) * half, 1.2, turn=INWARD)
        yield
        for _ in range(2):
            ground.scatter("planter", 1, near=(-half, half, 0.4, 4.5), turn=0.0)
            ground.scatter("bush", 1, near=(-half, half, 0.4, 4.5))
            yield

    def _garden(self) -> Iterator[None]:
        """Trees, seats along the path, a table in the pavilion."""
        ground = self.ground
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        back = (-half, half, 0.6 * depth, depth)
        ground.plant_trees(2, back)
        yield
        if self._pavilion:
            pavilion = self._pavilion
            yield from dine(beneath(ground, pavilion), pavilion.frame, [(0.0, 0.0)], QUARTER)
        if self._walk:
            end = self._walk.size[0] / 2
            yield from line_way(OpenGround(ground), self._walk.frame, (-end, end), 0.8)
        for _ in range(2):
            ground.plant_trees(1, back)
            ground.scatter("bush", 2, near=back)
            yield
        ground.plant_trees(1, (-half, half, 0.3, 5.0))
        ground.scatter("bin", 1, turn=0.0)
        yield
