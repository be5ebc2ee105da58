"""A market square: stalls, tables under a canopy, planters."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import pi

from aeroscene.curation.builder import Placed
from aeroscene.curation.frame import STREETWARD
from aeroscene.curation.places.ground import Ground
from aeroscene.scene import AttributeValue
from aeroscene.shapes.materials import PAINT_COLOURS


@dataclass(slots=True)
class Market:
    """Paving with stalls along the back and tables in front of them."""

    ground: Ground
    _canopy: Placed | None = None
    _stalls: list[Placed] = field(default_factory=list)

    def structures(self) -> Iterator[None]:
        """A row of kiosks, a canopy, a stage, perhaps a fountain."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("plaza")
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        count = draw.count(2, 4)
        for index in range(count):
            u = -half + (index + 0.5) * 2 * half / count + draw.between(-0.8, 0.8)
            colour: dict[str, AttributeValue] = {"colour": draw.one_of(PAINT_COLOURS)}
            size = (2.8, draw.between(3, 4.5), 2.9)
            stall = ground.stand("kiosk", u, depth - 2.5, size, margin=0.4, attributes=colour)
            if stall:
                self._stalls.append(stall)
        colour = {"colour": draw.one_of(PAINT_COLOURS)}
        u = draw.between(-0.4, 0.4) * half
        size = (draw.between(4.5, 6.5), draw.between(6, 9), 3.4)
        self._canopy = ground.stand("canopy", u, 0.55 * depth, size, attributes=colour)
        if draw.chance(0.6):
            ground.stand("water", -u - 0.5 * half if u < 0 else u - half, 4.5, (4.0, 4.0, 0.4))
        elif draw.chance(0.6):
            ground.stand("deck", 0.5 * half, 4.0, (3.5, 5.0, 0.5))
        yield

    def details(self) -> Iterator[None]:
        """Tables with chairs, planters, crates by the stalls, lamps."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        if self._canopy:
            reach = self._canopy.size[1] / 2 - 1.2
            for v in (-reach, 0.0, reach):
                self._seats(v)
        for stall in self._stalls:
            for name in draw.shuffled((0, 1)):
                kind = ("crate", "barrel")[name]
                side = stall.size[1] / 2 + 0.8
                self._beside(stall, kind, -0.5, side if name else -side)
        for index in range(draw.count(2, 3)):
            u = -0.85 * half + 0.42 * half * index
            ground.stand("planter", u, 1.2, (0.7, 1.8, 1.1), turn=STREETWARD)
        for _ in range(draw.count(1, 2)):
            ground.stand("bench", draw.between(-0.8, 0.8) * half, draw.between(2.5, 0.4 * depth))
        ground.stand("bin", draw.between(-0.8, 0.8) * half, 2.4)
        ground.stand("sign", draw.between(-0.8, 0.8) * half, 1.0)
        for sign in (-1, 1):
            ground.stand("street_lamp", sign * 0.8 * half, 0.35 * depth, (0.8, 0.5, 4.2))
        ground.plant_trees(draw.count(1, 3), (-half, half, 0.15 * depth, 0.9 * depth))
        yield

    def _seats(self, v: float) -> None:
        ground, draw = self.ground, self.ground.draw
        canopy = self._canopy
        if canopy is None:
            return
        u = draw.between(-0.15, 0.15) * canopy.size[0]
        table = ground.builder.place(
            "table", canopy.frame, u, v, (0.9, 1.2, 0.74), base=canopy.base, parent=canopy
        )
        if table is None:
            return
        for sign in (-1, 1):
            size = draw.size_of("chair")
            ground.builder.place(
                "chair",
                table.frame,
                sign * (table.size[0] / 2 + size[0] / 2 + 0.08),
                0.0,
                size,
                base=canopy.base,
                turn=pi if sign > 0 else 0.0,
                parent=canopy,
                within=canopy,
            )
        if draw.chance(0.5):
            cup = draw.size_of("cup")
            ground.builder.place(
                "cup", table.frame, 0.2, 0.3, cup, base=table.top, parent=table, within=table
            )

    def _beside(self, stall: Placed, kind: str, u: float, v: float) -> None:
        ground = self.ground
        ground.builder.place(
            kind,
            stall.frame,
            u,
            v,
            ground.draw.size_of(kind),
            base=ground.level,
            parent=ground.surface,
            within=ground.surface,
            margin=0.05,
        )
