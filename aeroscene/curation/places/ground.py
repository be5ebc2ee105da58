"""The ground of a parcel, and the moves that every kind of place shares."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi

from aeroscene.curation.builder import Builder, Placed
from aeroscene.curation.draw import Draw
from aeroscene.curation.frame import QUARTER, STREETWARD, Frame
from aeroscene.curation.site import Parcel
from aeroscene.scene import AttributeValue, Vector3

GROUND_M = {"lawn": 0.06, "plaza": 0.1, "parking_lot": 0.04, "sidewalk": 0.1}
"""Heights of the surfaces of parcels above the ground."""
_MARGIN_M = 0.4
_TRIES = 6


@dataclass(slots=True)
class Ground:
    """One parcel with its surface; positions are in the parcel's frame, v from the street."""

    builder: Builder
    draw: Draw
    parcel: Parcel
    surface: Placed | None = None
    lawns: list[Placed] = field(default_factory=list)

    @property
    def level(self) -> float:
        """Height on which things stand."""
        return self.surface.top if self.surface else self.parcel.level

    def cover(self, name: str, attributes: dict[str, AttributeValue] | None = None) -> None:
        """Give the whole parcel a surface."""
        parcel = self.parcel
        size = (parcel.width, parcel.depth, GROUND_M[name])
        self.surface = self.builder.place(
            name,
            parcel.frame,
            0,
            parcel.depth / 2,
            size,
            base=parcel.level,
            attributes=attributes,
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
        on: Placed | None = None,
        base: float | None = None,
        attributes: dict[str, AttributeValue] | None = None,
    ) -> Placed | None:
        """Stand something on the parcel's surface, if there is space."""
        bearer = on or self.surface
        return self.builder.place(
            name,
            self.parcel.frame,
            u,
            v,
            size or self.draw.size_of(name),
            base=self.level if base is None else base,
            turn=turn,
            parent=bearer,
            within=bearer,
            margin=margin,
            attributes=attributes,
        )

    def erect(
        self,
        name: str,
        u: float,
        v: float,
        size: Vector3,
        *,
        turn: float = STREETWARD,
        attributes: dict[str, AttributeValue] | None = None,
    ) -> Placed | None:
        """Put up a structure that is a root of its own, if there is space."""
        return self.builder.place(
            name,
            self.parcel.frame,
            u,
            v,
            size,
            base=self.level,
            turn=turn,
            parent=None,
            within=self.surface,
            margin=_MARGIN_M,
            attributes=attributes,
        )

    def scatter(
        self,
        name: str,
        count: int,
        *,
        margin: float = 0.3,
        near: tuple[float, float, float, float] | None = None,
        turn: float | None = None,
        attributes: dict[str, AttributeValue] | None = None,
    ) -> list[Placed]:
        """Stand several of a kind at random places (u0, u1, v0, v1) of the parcel."""
        half, depth = self.parcel.width / 2, self.parcel.depth
        u0, u1, v0, v1 = near or (-half, half, 0.0, depth)
        found: list[Placed] = []
        for _ in range(count):
            size = self.draw.size_of(name)
            reach = max(size[0], size[1]) / 2
            for _ in range(_TRIES):
                u, v = self._spot(u0, u1, reach), self._spot(v0, v1, reach)
                heading = self.draw.between(-pi, pi) if turn is None else turn
                placed = self.stand(
                    name, u, v, size, turn=heading, margin=margin, attributes=attributes
                )
                if placed:
                    found.append(placed)
                    break
        return found

    def plant_trees(
        self, count: int, near: tuple[float, float, float, float] | None = None
    ) -> None:
        """Trees of one or two forms, square in outline so that the crown is round."""
        form = self.draw.one_of(("round", "spreading", "conical"))
        leaves = self.draw.one_of(("leaves", "leaves", "leaves_dark", "leaves_autumn"))
        half, depth = self.parcel.width / 2, self.parcel.depth
        u0, u1, v0, v1 = near or (-half, half, 0.0, depth)
        for _ in range(count):
            height = self.draw.between(4.5, 10.5)
            width = round(height * self.draw.between(0.4, 0.58), 2)
            if form == "conical":
                width = round(0.7 * width, 2)
            reach = width / 2 + 0.2
            for _ in range(_TRIES):
                u, v = self._spot(u0, u1, reach), self._spot(v0, v1, reach)
                attributes: dict[str, AttributeValue] = {"form": form, "leaves": leaves}
                size = (width, width, height)
                if self.stand("tree", u, v, size, turn=0.0, attributes=attributes):
                    break

    def _spot(self, low: float, high: float, reach: float) -> float:
        """A place between two borders, at least `reach` away from both where they allow."""
        if high - low <= 2 * reach:
            return (low + high) / 2
        return self.draw.between(low + reach, high - reach)

    def fence_line(
        self, start: tuple[float, float], end: tuple[float, float], form: str, height: float
    ) -> None:
        """A fence between two points of the parcel that share u or v."""
        (u0, v0), (u1, v1) = start, end
        is_along_u = abs(u1 - u0) > abs(v1 - v0)
        length = abs(u1 - u0) if is_along_u else abs(v1 - v0)
        thick = 0.3 if form == "hedge" else 0.1
        self.builder.place(
            "fence",
            self.parcel.frame,
            (u0 + u1) / 2,
            (v0 + v1) / 2,
            (thick, length, height),
            base=self.level,
            turn=QUARTER if is_along_u else 0.0,
            parent=self.surface,
            attributes={"form": form},
        )

    def facing(self, frame: Frame, turn: float) -> float:
        """Turn in the parcel's frame of a heading in another frame."""
        return frame.yaw + turn - self.parcel.frame.yaw
