"""A logistics yard: an open hall, containers, pallets, a truck."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi

from aeroscene.curation.builder import Placed
from aeroscene.curation.frame import STREETWARD
from aeroscene.curation.places.ground import Ground
from aeroscene.scene import AttributeValue
from aeroscene.shapes.materials import PAINT_COLOURS


@dataclass(slots=True)
class Yard:
    """A paved yard with goods."""

    ground: Ground
    _hall: Placed | None = None

    def structures(self) -> Iterator[None]:
        """A hall with a gate at each end, containers along the side, a fence."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("parking_lot", {"rows": 0})
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        deep, length = min(14.0, depth - 10), min(draw.between(11, 14), 2 * half - 6)
        side = 1 if draw.chance(0.5) else -1
        hall_u = side * (half - length / 2 - 0.8)
        attributes: dict[str, AttributeValue] = {
            "is_enterable": True,
            "colour": draw.one_of(PAINT_COLOURS),
        }
        size = (deep, length, draw.between(5.6, 7.0))
        self._hall = ground.erect(
            "warehouse", hall_u, depth - deep / 2 - 1.5, size, attributes=attributes
        )
        if self._hall:
            for sign in (-1, 1):
                gate = (7.0, 4.6, 3.8)
                at = sign * size[0] / 2
                ground.builder.reserve(self._hall.frame, at, 0, gate, ground.level + 0.05)
        for index in range(draw.count(2, 4)):
            colour: dict[str, AttributeValue] = {"colour": draw.one_of(PAINT_COLOURS)}
            v = depth - 3.6 - 3.1 * index
            long = 6.06 if draw.chance(0.7) else 12.2
            u = -side * (half - 0.6 - long / 2)
            turn = 0.0 if side > 0 else pi
            box = ground.erect("container", u, v, (long, 2.44, 2.59), turn=turn, attributes=colour)
            if box and draw.chance(0.35):
                ground.builder.place(
                    "container",
                    box.frame,
                    0,
                    0,
                    (6.06, 2.44, 2.59),
                    base=box.top,
                    parent=box,
                    attributes={"colour": draw.one_of(PAINT_COLOURS)},
                )
        ground.fence_line((-half + 0.3, depth - 0.2), (half - 0.3, depth - 0.2), "rails", 1.8)
        yield

    def details(self) -> Iterator[None]:
        """Goods in the hall, a truck at the gate, barrels and crates outside."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        if self._hall:
            self._stock(self._hall)
        colour: dict[str, AttributeValue] = {"colour": draw.one_of(PAINT_COLOURS)}
        turn = 0.0 if draw.chance(0.5) else pi
        truck = (draw.between(6.5, 8), 2.4, 3.2)
        ground.stand(
            "truck", draw.between(-0.4, 0.4) * half, 3.0, truck, turn=turn, attributes=colour
        )
        ground.stand("van", draw.between(-0.6, 0.6) * half, 6.5, turn=turn)
        for name, low, high in (("pallet", 2, 4), ("crate", 2, 3), ("barrel", 2, 3)):
            ground.scatter(name, draw.count(low, high), near=(-half, half, 4.0, depth))
        ground.stand("sign", 0.85 * half, 0.6, turn=STREETWARD)
        yield

    def _stock(self, hall: Placed) -> None:
        """Shelves along the walls, pallets in the middle, a desk in a corner."""
        draw = self.ground.draw
        x, y, _ = hall.size
        for sign in (-1, 1):
            for slot in (-0.25, 0.05, 0.3):
                size = (0.5, 2.0, 2.2)
                turn = -sign * 1.5707963267948966
                self._inside(hall, "shelf", slot * x, sign * (y / 2 - 0.6), size, turn)
        for _ in range(draw.count(3, 5)):
            size = draw.size_of("pallet")
            u, v = draw.between(-0.25, 0.25) * x, draw.between(-0.34, 0.34) * y
            self._inside(hall, "pallet", u, v, size, 0.0)
        for _ in range(2):
            u = draw.between(-0.3, 0.3) * x
            self._inside(hall, "box", u, -(y / 2 - 1.3), draw.size_of("box"), 0.0)

    def _inside(
        self,
        hall: Placed,
        name: str,
        u: float,
        v: float,
        size: tuple[float, float, float],
        turn: float,
    ) -> None:
        self.ground.builder.place(
            name,
            hall.frame,
            u,
            v,
            size,
            base=hall.base,
            turn=turn,
            parent=hall,
            within=hall,
            margin=0.1,
            domain="indoor",
        )
