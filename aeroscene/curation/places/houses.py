"""Detached houses with gardens, garages and hedges; one may be furnished."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from aeroscene.curation.frame import INWARD, STREETWARD
from aeroscene.curation.interiors import FURNISHINGS, Interior
from aeroscene.curation.places.ground import Ground
from aeroscene.curation.rooftops import add_chimney, add_flat_roof, add_pitched_roof
from aeroscene.curation.shells import RoomSpace, raise_shell
from aeroscene.scene import AttributeValue
from aeroscene.shapes.materials import PAINT_COLOURS, WALL_COLOURS

_DRIVE_M = 3.4


@dataclass(slots=True)
class Houses:
    """One or two plots side by side along the street."""

    ground: Ground
    is_furnished: bool = False
    _drives: list[float] = field(default_factory=list)
    _rooms: list[RoomSpace] = field(default_factory=list)
    _edges: list[float] = field(default_factory=list)

    def structures(self) -> Iterator[None]:
        """On each plot a house with a pitched roof, a garage on its drive, a hedge."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("lawn")
        width, depth = ground.parcel.width, ground.parcel.depth
        plots = 2 if width >= 28 else 1
        for plot in range(plots):
            low = -width / 2 + plot * width / plots
            self._plot(low, low + width / plots, is_furnished=self.is_furnished and plot == 0)
        for edge in self._edges[:-1]:
            form = draw.one_of(("hedge", "boards"))
            ground.fence_line((edge, 2.0), (edge, depth - 0.5), form, draw.between(1.0, 1.6))
        if draw.chance(0.6):
            back = depth - 0.3
            ground.fence_line((-width / 2 + 0.5, back), (width / 2 - 0.5, back), "boards", 1.6)
        yield

    def _plot(self, low: float, high: float, *, is_furnished: bool) -> None:
        ground, draw = self.ground, self.ground.draw
        self._edges.append(high)
        drive = high - 0.6 - _DRIVE_M / 2
        space = drive - _DRIVE_M / 2 - low
        u = low + space / 2
        setback = draw.between(4.0, 6.0)
        house_v = setback + 4.2
        if is_furnished and space >= 12.2:
            shell = raise_shell(
                ground.builder,
                draw,
                ground.parcel.frame,
                (u, house_v + 0.4),
                name="house",
                depth=8.4,
                length=min(14.0, space - 1.4),
                storeys=1,
                base=ground.level,
                turn=STREETWARD,
                colour=draw.one_of((*WALL_COLOURS, "brick")),
            )
            if shell:
                self._rooms += shell.rooms
                add_flat_roof(ground.builder, shell.building, parapet=False)
        else:
            size = (8.0, min(draw.between(8.5, 11), space - 2.0), draw.between(3.0, 6.2))
            attributes: dict[str, AttributeValue] = {
                "colour": draw.one_of((*WALL_COLOURS, "brick"))
            }
            house = ground.erect("house", u, house_v, size, attributes=attributes)
            roof = add_pitched_roof(ground.builder, draw, house) if house else None
            if roof and draw.chance(0.7):
                add_chimney(ground.builder, draw, roof)
        if draw.chance(0.7):
            ground.erect("garage", drive, setback + 6.5, (5.8, 3.2, 2.7))
        self._drives.append(drive)
        if draw.chance(0.4):
            shed: dict[str, AttributeValue] = {"form": "shed"}
            at = (u, ground.parcel.depth - 2.6)
            ground.erect("garage", *at, (2.4, 3.0, 2.4), attributes=shed)

    def details(self) -> Iterator[None]:
        """Furniture, cars on the drives, garden trees, a table in the garden."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        for space, kind in zip(self._rooms, ("living", "kitchen", "bedroom"), strict=False):
            yield from FURNISHINGS[kind](Interior(ground.builder, draw, space))
        for drive in self._drives:
            if draw.chance(0.8):
                turn = STREETWARD if draw.chance(0.5) else INWARD
                colour: dict[str, AttributeValue] = {"colour": draw.one_of(PAINT_COLOURS)}
                ground.stand("car", drive, 2.7, turn=turn, attributes=colour)
            ground.stand("bin", drive - 2.4, draw.between(4, 6))
        back = (-half, half, 0.55 * depth, depth)
        for table in ground.scatter("table", draw.count(0, 1), near=back, turn=0.0):
            for sign in (-1, 1):
                size = draw.size_of("chair")
                u = sign * (table.size[0] / 2 + size[0] / 2 + 0.1)
                ground.builder.place(
                    "chair",
                    table.frame,
                    u,
                    0.0,
                    size,
                    base=ground.level,
                    turn=3.141592653589793 if sign > 0 else 0.0,
                    parent=ground.surface,
                )
        ground.plant_trees(draw.count(2, 4), back)
        ground.plant_trees(draw.count(0, 1), (-half, half, 0.3, 5.0))
        ground.scatter("bush", draw.count(1, 4))
        yield
