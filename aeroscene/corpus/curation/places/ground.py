"""The ground of a parcel, and the moves that every kind of place shares."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, cos, pi, sin

from aeroscene.corpus.curation.builder import Attributes, Builder, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import QUARTER, STREETWARD, Frame
from aeroscene.corpus.curation.parcels import Parcel, Side
from aeroscene.scene import Vector3

GROUND_M = {"lawn": 0.06, "plaza": 0.1, "parking_lot": 0.04, "sidewalk": 0.1}
"""Heights of the surfaces of parcels above the ground."""
_FINISH = {"lawn": "grass", "plaza": "paving", "parking_lot": "asphalt", "sidewalk": "paving"}
"""Cover of a slope that replaces a surface of its own."""
_MARGIN_M = 0.4
_TRIES = 6
_BORDER_M = 0.3
"""Distance of a fence from the border that it marks."""
_FENCE_STEP_M = 3.0
"""Length of the pieces in which a fence climbs a slope."""


@dataclass(slots=True)
class Ground:
    """One parcel with its surface; positions are in the parcel's frame, v from the street.

    On a slope, objects stand at the lowest point below their outline, sunk into the hill behind it.
    """

    builder: Builder
    draw: Draw
    parcel: Parcel
    surface: Placed | None = None

    @property
    def level(self) -> float:
        """Height of the surface, m; on a slope the height of its foot."""
        if self.parcel.rise or not self.surface:
            return self.parcel.level
        return self.surface.top

    def height_under(self, v: float, size: Vector3, turn: float) -> float:
        """Height of the lowest ground below an outline, m.

        Args:
            v: Middle of the outline, m from the street.
            size: Extents of the object.
            turn: Heading of the object in the parcel's frame, rad.
        """
        if not self.parcel.rise:
            return self.level
        # Half the outline's depth along the slope.
        reach = (abs(sin(turn)) * size[0] + abs(cos(turn)) * size[1]) / 2
        share = min(1.0, max(0.0, (v - reach) / self.parcel.depth))
        return self.parcel.level + share * self.parcel.rise

    def cover(self, name: str, look: Attributes | None = None) -> None:
        """Give the whole parcel a surface; on a slope the surface is the hill itself.

        Args:
            name: Category of the surface, a key of `GROUND_M`.
            look: Attributes; a slope has its own.
        """
        parcel = self.parcel
        turn, size = 0.0, (parcel.width, parcel.depth, GROUND_M[name])
        if parcel.rise:
            look = {"form": "ramp", "finish": _FINISH[name]}
            # A ramp rises along its own x, so that a quarter turn makes it rise away from the
            # street.
            name, turn, size = "terrain", QUARTER, (parcel.depth, parcel.width, parcel.rise)
        spot = parcel.frame.moved(0, parcel.depth / 2, turn)
        self.surface = self.builder.place(
            name, spot, size, base=parcel.level, parent=parcel.bearer, look=look
        )

    def stand(
        self,
        name: str,
        u: float,
        v: float,
        size: Vector3 | None = None,
        *,
        turn: float = STREETWARD,
        margin: float = 0.15,
        look: Attributes | None = None,
    ) -> Placed | None:
        """Stand an object on the parcel's surface if there is space.

        Args:
            name: Category.
            u: Middle along the street, m.
            v: Middle, m from the street.
            size: Extents; drawn by default.
            turn: Heading in the parcel's frame; by default the front faces the street.
            margin: Distance to keep from other objects, m.
            look: Attributes.
        """
        size = size or self.draw.size_of(name)
        bearer, base = self.surface, self.height_under(v, size, turn)
        spot = self.parcel.frame.moved(u, v, turn)
        return self.builder.place(
            name, spot, size, base=base, parent=bearer, within=bearer, margin=margin, look=look
        )

    def erect(
        self,
        name: str,
        u: float,
        v: float,
        size: Vector3,
        *,
        turn: float = STREETWARD,
        margin: float = _MARGIN_M,
        look: Attributes | None = None,
    ) -> Placed | None:
        """Put up a structure if there is space: a root of its own, or a part of its hill.

        Args:
            name: Category.
            u: Middle along the street, m.
            v: Middle, m from the street.
            size: Extents.
            turn: Heading in the parcel's frame; by default the front faces the street.
            margin: Distance to keep from other objects, m.
            look: Attributes.
        """
        bearer, base = self.surface, self.height_under(v, size, turn)
        spot, parent = self.parcel.frame.moved(u, v, turn), bearer if self.parcel.rise else None
        return self.builder.place(
            name, spot, size, base=base, parent=parent, within=bearer, margin=margin, look=look
        )

    def scatter(
        self,
        name: str,
        count: int,
        *,
        near: tuple[float, float, float, float] | None = None,
        turn: float | None = None,
    ) -> list[Placed]:
        """Stand several objects of a category at random places of the parcel.

        Args:
            name: Category.
            count: Number of objects; those that find no space after some tries are left out.
            near: Area u0, u1, v0, v1; the whole parcel by default.
            turn: Heading; random by default.
        """
        half, depth = self.parcel.width / 2, self.parcel.depth
        u0, u1, v0, v1 = near or (-half, half, 0.0, depth)
        found: list[Placed] = []
        for _ in range(count):
            size = self.draw.size_of(name)
            reach = max(size[0], size[1]) / 2
            for _ in range(_TRIES):
                u, v = self._spot(u0, u1, reach), self._spot(v0, v1, reach)
                heading = self.draw.between(-pi, pi) if turn is None else turn
                placed = self.stand(name, u, v, size, turn=heading, margin=0.3)
                if placed:
                    found.append(placed)
                    break
        return found

    def plant_trees(
        self, count: int, near: tuple[float, float, float, float] | None = None
    ) -> None:
        """Plant trees of one form and colour, square in outline so that crowns are round.

        Args:
            count: Number of trees; those that find no space after some tries are left out.
            near: Area u0, u1, v0, v1; the whole parcel by default.
        """
        form = self.draw.one_of(("round", "spreading", "conical"))
        leaves = self.draw.one_of(("leaves", "leaves", "leaves_dark", "leaves_autumn"))
        half, depth = self.parcel.width / 2, self.parcel.depth
        u0, u1, v0, v1 = near or (-half, half, 0.0, depth)
        for _ in range(count):
            height = self.draw.between(4.5, 10.5)
            width = round(height * self.draw.between(0.4, 0.58), 2)
            if form == "conical":
                # Conical trees are slender.
                width = round(0.7 * width, 2)
            reach = width / 2 + 0.2
            for _ in range(_TRIES):
                u, v = self._spot(u0, u1, reach), self._spot(v0, v1, reach)
                look = {"form": form, "leaves": leaves}
                size = (width, width, height)
                if self.stand("tree", u, v, size, turn=0.0, look=look):
                    break

    def _spot(self, low: float, high: float, reach: float) -> float:
        """A place between two borders, at least `reach` away from both if they allow it."""
        if high - low <= 2 * reach:
            return (low + high) / 2
        return self.draw.between(low + reach, high - reach)

    def fence_line(
        self, start: tuple[float, float], end: tuple[float, float], form: str, height: float
    ) -> None:
        """Stand a fence between two points of the parcel that share u or v.

        Args:
            start: One end, u and v.
            end: The other end.
            form: Form of the fence.
            height: Height, m.
        """
        (u0, v0), (u1, v1) = start, end
        is_along_u = abs(u1 - u0) > abs(v1 - v0)
        length = abs(u1 - u0) if is_along_u else abs(v1 - v0)
        # Up a slope a fence climbs in steps; along it one piece is level.
        pieces = ceil(length / _FENCE_STEP_M) if self.parcel.rise and not is_along_u else 1
        turn = QUARTER if is_along_u else 0.0
        size = (0.3 if form == "hedge" else 0.1, length / pieces, height)
        for piece in range(pieces):
            share = (piece + 0.5) / pieces
            u, v = u0 + share * (u1 - u0), v0 + share * (v1 - v0)
            spot, base = self.parcel.frame.moved(u, v, turn), self.height_under(v, size, turn)
            look = {"form": form}
            self.builder.place("fence", spot, size, base=base, parent=self.surface, look=look)

    def fence_border(self, side: Side, form: str, height: float) -> None:
        """Stand a fence just inside a side of the parcel: its back or a flank.

        The front has none, because it is open to the street.

        Args:
            side: Side as seen with the street in the south.
            form: Form of the fence.
            height: Height, m.
        """
        half, depth = self.parcel.width / 2 - _BORDER_M, self.parcel.depth - _BORDER_M
        match side:
            case "north":
                self.fence_line((-half, depth), (half, depth), form, height)
            case "east":
                # Flanks end half a metre before the back, so that corners stay clear.
                self.fence_line((half, _BORDER_M), (half, depth - 0.5), form, height)
            case "west":
                self.fence_line((-half, _BORDER_M), (-half, depth - 0.5), form, height)
            case _:
                pass

    def facing(self, spot: Frame) -> float:
        """Heading of a spot in the parcel's frame, rad."""
        return spot.yaw - self.parcel.frame.yaw
