"""A town square: a town hall with its tower, trees in rows, a fountain, a cafe in the open."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.goods import paint
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import rack_bicycles
from aeroscene.corpus.curation.places.rooftops import (
    TILES,
    add_flat_roof,
    add_row_roof,
    furnish_flat_roof,
)
from aeroscene.corpus.curation.places.seating import dine
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, beneath
from aeroscene.solids.shapes.materials import WALL_COLOURS

_HALL_DEEP_M = (8.0, 10.5)
_TOWER_M = 5.6
_TREE_PITCH_M = 5.6
_WIDE_M = 16.0
"""Half the width from which a square has four rows of trees."""
_LEAST_OPEN_M = 9.0
"""Least depth of the square before the hall."""


@dataclass(slots=True)
class Square:
    """Paving open towards the street, a public building behind it."""

    ground: Ground
    _hall: Placed | None = None
    _roof: Placed | None = None
    _fountain: Placed | None = None
    _cafe: Placed | None = None
    _edge: float = 0.0
    """End of the open square, v."""

    def structures(self) -> Iterator[None]:
        """Grow the hall; then its tower and roof, the fountain, an awning, a kiosk."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("plaza", {"form": draw.one_of(("cross", "bands", "border"))})
        side = 1 if draw.chance(0.5) else -1
        # Until a hall stands, the square takes the whole depth.
        self._edge = ground.parcel.depth
        self._raise_hall(side)
        yield
        if self._hall and draw.chance(0.35):
            add_row_roof(ground.builder, self._hall, draw.one_of(TILES))
        elif self._hall:
            self._roof = add_flat_roof(ground.builder, self._hall)
        yield
        # A fountain needs space to walk round it.
        side_m = min(5.0, round(0.34 * self._edge, 2))
        if side_m >= 3.0:
            size = (side_m, side_m, 0.45)
            at = draw.between(0.42, 0.55) * self._edge
            look = {"form": "basin", "rim": "stone"}
            self._fountain = ground.stand("water", 0.0, at, size, margin=1.0, look=look)
        yield
        half = ground.parcel.width / 2
        size = (3.4, draw.between(4.6, 7.0), 3.1)
        look = {**paint(draw), "form": "flat"}
        u, v = side * (half - 2.4), 0.5 * self._edge
        self._cafe = ground.stand("canopy", u, v, size, turn=0.0, margin=0.3, look=look)
        yield
        u = -side * (half - 2.2)
        look = {**paint(draw), "form": "round"}
        ground.stand("kiosk", u, 0.3 * self._edge, (2.4, 2.4, 2.9), margin=0.4, look=look)
        yield

    def _raise_hall(self, side: int) -> None:
        """A wide building along the back with a tower flush at one end."""
        ground, draw = self.ground, self.ground.draw
        width, depth = ground.parcel.width, ground.parcel.depth
        deep = min(draw.between(*_HALL_DEEP_M), round(depth - _LEAST_OPEN_M, 2))
        if deep < 6.0:
            return
        has_tower = width > 18.0 and deep >= _TOWER_M
        length = round(min(width - 1.0 - (_TOWER_M if has_tower else 0.0), 26.0), 2)
        shift = -side * _TOWER_M / 2 if has_tower else 0.0
        storeys = draw.count(2, 3)
        colour = draw.one_of((*WALL_COLOURS, "brick"))
        look = {"colour": colour, "storeys": storeys, "form": "plain"}
        size = (deep, length, round(3.9 * storeys, 2))
        v = depth - deep / 2 - 0.2
        self._hall = ground.erect("building", shift, v, size, margin=0.0, look=look)
        self._edge = round(depth - deep - 0.2, 2)
        if self._hall and has_tower:
            # Towers are never of brick, so a brick hall has a tower of sand-coloured plaster.
            look = {"colour": colour if colour != "brick" else "sand", "form": "crown"}
            u = shift + side * (length / 2 + _TOWER_M / 2)
            size = (_TOWER_M, _TOWER_M, round(size[2] + draw.between(6.0, 9.0), 2))
            at = self._edge + _TOWER_M / 2
            ground.erect("tower", u, at, size, margin=0.0, look=look)

    def details(self) -> Iterator[None]:
        """Grow trees in rows with benches between, tables under the awning, lamps, bicycles."""
        ground, draw = self.ground, self.ground.draw
        roof = iter(())
        if self._roof:
            roof = furnish_flat_roof(ground.builder, draw, self._roof)
        yield from interleave(self._line_trees(), self._rest(), self._serve(), roof)

    def _line_trees(self) -> Iterator[None]:
        """Two rows of equal trees towards the hall, four on a wide square, benches between them."""
        ground, draw = self.ground, self.ground.draw
        half = ground.parcel.width / 2
        crown = draw.between(2.6, 3.4)
        size = (crown, crown, draw.between(5.5, 7.0))
        look = {"form": draw.one_of(("round", "spreading"))}
        count = max(1, int((self._edge - 3.0) / _TREE_PITCH_M))
        for index in range(count):
            v = 2.6 + index * _TREE_PITCH_M
            for share in (-0.64, 0.64, -0.3, 0.3) if half > _WIDE_M else (-0.56, 0.56):
                u, sign = share * half, 1 if share > 0 else -1
                ground.stand("tree", u, v, size, turn=0.0, look=look)
                # Benches between two trees, and none behind the last.
                if index < count - 1:
                    turn = pi if sign > 0 else 0.0
                    ground.stand("bench", u, v + _TREE_PITCH_M / 2, (0.6, 1.8, 0.85), turn=turn)
            yield

    def _rest(self) -> Iterator[None]:
        """Benches round the fountain, lamps in the corners, bins, bicycles, a sign."""
        ground, bearing = self.ground, OpenGround(self.ground)
        half = ground.parcel.width / 2
        if self._fountain:
            reach = self._fountain.size[0] / 2 + 0.9
            for quarter in range(4):
                frame = self._fountain.frame.moved(0, 0, quarter * QUARTER)
                bearing.stand("bench", frame.moved(reach, 0.0, pi), (0.6, 1.8, 0.85))
            yield
        for sign in (-1, 1):
            for v in (1.4, self._edge - 1.2):
                u = sign * (half - 1.0)
                ground.stand("street_lamp", u, v, (0.9, 0.4, 4.6), turn=0.0 if sign < 0 else pi)
            ground.stand("planter", sign * 0.3 * half, 0.8, (0.7, 2.2, 1.0))
            yield
        rack_bicycles(bearing, ground.parcel.frame, 0.4 * half, self._edge - 1.2, 5)
        yield
        ground.stand("sign", -0.42 * half, 0.7, (0.1, 1.2, 2.2), turn=STREETWARD)
        ground.stand("bin", 0.42 * half, 0.7, (0.5, 0.5, 0.95))
        yield
        names = ("planter", "bench", "tree", "bicycle", "bin")
        rounds = 12 if half > _WIDE_M else 6
        yield from fill_up(ground, names, (-half, half, 0.4, self._edge), rounds)

    def _serve(self) -> Iterator[None]:
        """The cafe's tables in two ranks under its awning."""
        if self._cafe is None:
            return
        width = self._cafe.size[1]
        count = max(1, int((width - 0.6) / 2.3))
        spots = [(0.0, (index - (count - 1) / 2) * 2.3) for index in range(count)]
        yield from dine(beneath(self.ground, self._cafe), self._cafe.frame, spots, QUARTER)
        bearing = OpenGround(self.ground)
        for sign in (-1, 1):
            spot = self._cafe.frame.moved(0.0, sign * (width / 2 + 0.6), INWARD)
            bearing.stand("planter", spot, (0.6, 2.0, 0.9))
        yield
