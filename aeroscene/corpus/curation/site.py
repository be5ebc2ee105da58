"""The ground plan of a scene: the surfaces that plans lay down, from carriageways to parcels."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from aeroscene.corpus.curation.builder import Attributes, Builder, Placed
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.parcels import (
    FLAT,
    Block,
    Land,
    Parcel,
    Rectangle,
    Side,
    cut_unequal,
)

ROAD_M = 0.04
SIDEWALK_M = 0.15
VERGE_M = 0.12
WATER_M = 0.15
PARKING_LANE_M = 2.2
"""Width of a lane for parked vehicles; above it, heights of the surfaces above the ground."""


@dataclass(frozen=True, slots=True)
class Road:
    """A carriageway for both directions, driven on the right: towards +x at negative y."""

    placed: Placed
    parking: tuple[int, ...] = ()
    """Sides along y, -1 or 1, whose outer lane is for parked vehicles."""
    zebra_end: int = 0
    """End along x where people cross, 0 for neither."""

    def lane(self, side: int) -> float:
        """Middle of the lane for moving traffic on a side.

        Args:
            side: Side along y, -1 or 1.

        Returns:
            Place along y, m; parked vehicles take a part of the width.
        """
        low, high = (
            sign * (self.placed.size[1] / 2 - (PARKING_LANE_M if sign in self.parking else 0.0))
            for sign in (-1, 1)
        )
        return (low + high) / 2 + side * (high - low) / 4


@dataclass(slots=True)
class Site:
    """Streets laid out and parcels to fill; plans are drawn in the site's own frame."""

    builder: Builder
    frame: Frame
    """Frame of the plan in the world, because a city need not lie along the axes."""
    half_x: float
    half_y: float
    road_m: float
    """Width of a carriageway."""
    walk_m: float
    """Width of a sidewalk."""
    parking: tuple[int, ...] = ()
    """Sides of the streets along which vehicles are parked."""
    style: Mapping[str, str] = field(default_factory=dict)
    """Forms that all surfaces of a category share."""
    roads: list[Road] = field(default_factory=list)
    sidewalks: list[Placed] = field(default_factory=list)
    """Their frames have u along the street and v leading away from the kerb."""
    verges: list[Placed] = field(default_factory=list)
    """Strips of green or parking between carriageway and sidewalk, framed likewise."""
    parcels: list[Parcel] = field(default_factory=list)
    slopes: list[Parcel] = field(default_factory=list)
    """Ground that climbs, for grass and trees alone."""
    waters: list[Placed] = field(default_factory=list)
    """Basins and canals; their x axis runs along the quay on their -y side."""
    junctions: list[Frame] = field(default_factory=list)

    @property
    def half_extent(self) -> tuple[float, float]:
        # A turned rectangle reaches as far as its corners.
        """Half sides of the upright rectangle around the turned plan, m."""
        c, s = abs(math.cos(self.frame.yaw)), abs(math.sin(self.frame.yaw))
        return (c * self.half_x + s * self.half_y, s * self.half_x + c * self.half_y)

    def world(self, frame: Frame) -> Frame:
        """Give a frame of the plan in the world, where objects are placed."""
        return self.frame.moved(frame.x, frame.y, frame.yaw)

    def raise_land(self, area: Rectangle, level: float, finish: str, wall: str) -> Land:
        """Raise ground on a rectangle of the plan; its sides are retaining walls.

        Args:
            area: Rectangle.
            level: Height of the raised ground, m.
            finish: Finish of its upper face.
            wall: Material of its sides.

        Returns:
            The raised land, or the flat one if there is no space.
        """
        frame, width, depth = area.side_frame("south")
        look = {"form": "terrace", "finish": finish, "wall": wall}
        size = (width, depth, level)
        spot = self.world(frame).moved(0, depth / 2)
        block = self.builder.place("terrain", spot, size, look=look)
        return Land(level, block) if block else FLAT

    def fill_with_water(self, area: Rectangle, quay: Side) -> Placed | None:
        """Fill a rectangle of the plan with water.

        Args:
            area: Rectangle.
            quay: Side from which people see it, and at which boats are moored.

        Returns:
            The water; None if there is no space.
        """
        frame, width, depth = area.side_frame(quay)
        spot = self.world(frame).moved(0, depth / 2)
        size = (width, depth, WATER_M)
        water = self.builder.place("water", spot, size, look={"form": "open"})
        if water:
            self.waters.append(water)
        return water

    def lay_road(
        self,
        frame: Frame,
        length: float,
        *,
        width: float | None = None,
        zebra_end: int = 0,
        land: Land = FLAT,
        after: Placed | None = None,
        height: float = ROAD_M,
    ) -> Placed | None:
        """Lay a carriageway along the x axis of a frame of the plan.

        Args:
            frame: Its middle.
            length: Length along x, m.
            width: Width, m; the site's by default.
            zebra_end: End along x at which people cross it (-1 or 1); 0 for neither.
            land: Ground that carries it.
            after: Carriageway that this one continues, and may overlap at the bend.
            height: Height of its surface above the land, m.

        Returns:
            The carriageway, or None if it does not fit.
        """
        size = (length, width or self.road_m, height)
        look = {"zebra_end": zebra_end, **self._form("road")}
        road = self.builder.place(
            "road", self.world(frame), size, base=land.level, parent=after or land.bearer, look=look
        )
        if road:
            # Roads of a width of their own, such as turning heads, have no parked vehicles.
            parking = self.parking if width is None else ()
            self.roads.append(Road(road, parking, zebra_end))
        return road

    def lay_sidewalk(
        self,
        frame: Frame,
        length: float,
        *,
        land: Land = FLAT,
        after: Placed | None = None,
        height: float = SIDEWALK_M,
    ) -> Placed | None:
        """Lay a sidewalk whose kerb lies on the x axis of a frame of the plan.

        Args:
            frame: Middle of the kerb; the sidewalk lies on the side of positive y.
            length: Length along x, m.
            land: Ground that carries it.
            after: Sidewalk that this one continues, and may overlap at the bend.
            height: Height of its surface above the land, m.

        Returns:
            The sidewalk, or None if it does not fit.
        """
        spot = self.world(frame).moved(0, self.walk_m / 2)
        size, look = (length, self.walk_m, height), self._form("sidewalk")
        strip = self.builder.place(
            "sidewalk", spot, size, base=land.level, parent=after or land.bearer, look=look
        )
        if strip:
            self.sidewalks.append(strip)
        return strip

    def lay_verge(self, frame: Frame, length: float, width: float) -> None:
        """Lay a strip of green between carriageway and sidewalk.

        Args:
            frame: Middle of the kerb, with the strip on the side of positive y.
            length: Length along x, m.
            width: Width, m.
        """
        spot = self.world(frame).moved(0, width / 2)
        size = (length, width, VERGE_M)
        strip = self.builder.place("lawn", spot, size, look={"form": "plain"})
        if strip:
            self.verges.append(strip)

    def _form(self, name: str) -> Attributes:
        return {"form": self.style[name]} if name in self.style else {}

    def pave(self, block: Block, rng: np.random.Generator) -> None:
        """Lay sidewalks along the block's streets; divide the rest into parcels of unequal size.

        The parcels face one of the streets, drawn by chance.

        Args:
            block: Block.
            rng: Draws the front and the cuts.
        """
        rest = block.area
        for side in block.street_sides:
            frame, length, _ = rest.side_frame(side)
            self.lay_sidewalk(frame, length, land=block.land)
            rest = rest.without(side, self.walk_m)
        # The street that the parcels face; the other streets run along their sides or backs.
        front = str(rng.choice(list(block.street_sides)))
        self.part(rest, front, rng, land=block.land, uses=block.uses)

    def part(
        self,
        area: Rectangle,
        front: Side,
        rng: np.random.Generator,
        *,
        land: Land = FLAT,
        uses: tuple[str, ...] = (),
    ) -> None:
        """Cut a rectangle across its front into unequal parcels; a wanted use keeps it whole.

        Args:
            area: Rectangle.
            front: Side at the street.
            rng: Draws the cuts.
            land: Ground that carries the parcels.
            uses: Kinds of places of which the plan wants one here.
        """
        frame, width, depth = area.side_frame(front)
        for low, high in [(-width / 2, width / 2)] if uses else cut_unequal(width, rng):
            at = self.world(frame.moved((low + high) / 2, 0))
            parcel = Parcel(at, high - low, depth, land.level, bearer=land.bearer, uses=uses)
            self.parcels.append(parcel)
