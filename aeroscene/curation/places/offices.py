"""A furnished building of one or two storeys with a terrace: the scene's interior."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from aeroscene.curation.builder import Placed
from aeroscene.curation.frame import STREETWARD
from aeroscene.curation.interiors import FURNISHINGS, Interior
from aeroscene.curation.places.ground import Ground
from aeroscene.curation.rooftops import add_flat_roof, add_roof_pad, equip_flat_roof
from aeroscene.curation.shells import Shell, raise_shell
from aeroscene.shapes.materials import WALL_COLOURS

_PROGRAMMES = {
    "offices": ("office", "meeting", "office", "store"),
    "flats": ("living", "kitchen", "bedroom", "living"),
    "cafe": ("cafe", "kitchen", "office", "meeting"),
}
"""Rooms of a use, in the order in which a building offers them."""


@dataclass(slots=True)
class Offices:
    """Offices, flats or a cafe that a drone can fly into."""

    ground: Ground
    _shells: list[tuple[Shell, Placed | None]] = field(default_factory=list)
    _terrace: Placed | None = None

    def structures(self) -> Iterator[None]:
        """Ground, the furnished building, its roof, and a terrace before the door."""
        ground, draw = self.ground, self.ground.draw
        ground.cover(draw.one_of(("lawn", "plaza", "lawn")))
        width, depth = ground.parcel.width, ground.parcel.depth
        length = min(draw.between(12, 16.5), width - 3.5)
        deep = min(draw.between(7.5, 9.5), depth - 9)
        setback = draw.between(5.0, 6.5)
        u = draw.between(-0.5, 0.5) * (width - length - 3)
        shell = raise_shell(
            ground.builder,
            draw,
            ground.parcel.frame,
            (u, setback + deep / 2),
            name="building",
            depth=deep,
            length=length,
            storeys=draw.count(1, 2) if draw.chance(0.3) else 2,
            base=ground.level,
            turn=STREETWARD,
            colour=draw.one_of((*WALL_COLOURS, "brick")),
        )
        if shell is None:
            return
        roof = add_flat_roof(ground.builder, shell.building)
        self._shells.append((shell, roof))
        size = (3.2, min(8.0, length - 2), 0.15)
        self._terrace = ground.stand("deck", u, setback - 1.9, size, margin=0.02)
        yield

    def details(self) -> Iterator[None]:
        """Furniture inside, machines and a pad on the roof, plants and seats outside."""
        ground, draw = self.ground, self.ground.draw
        programme = _PROGRAMMES[draw.one_of(tuple(_PROGRAMMES))]
        for shell, roof in self._shells:
            for index, space in enumerate(shell.rooms):
                kind = programme[index % len(programme)]
                yield from FURNISHINGS[kind](Interior(ground.builder, draw, space))
            if roof:
                if draw.chance(0.6):
                    add_roof_pad(ground.builder, draw, roof)
                equip_flat_roof(ground.builder, draw, roof, items=draw.count(2, 5))
        self._furnish_outside()
        yield

    def _furnish_outside(self) -> None:
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        if self._terrace:
            for sign in (-1, 1):
                ground.builder.place(
                    "planter",
                    self._terrace.frame,
                    0.9,
                    sign * (self._terrace.size[1] / 2 - 0.7),
                    (0.5, 1.2, 0.9),
                    base=self._terrace.top,
                    parent=self._terrace,
                )
        ground.plant_trees(draw.count(1, 3), (-half, half, 0.6 * depth, depth))
        ground.scatter("bush", draw.count(1, 2), near=(-half, half, 0.5, 4.0))
        if draw.chance(0.7):
            ground.stand("bench", draw.between(-0.8, 0.8) * half, 1.2)
        for _ in range(draw.count(0, 2)):
            ground.stand("bicycle", draw.between(-0.8, 0.8) * half, 2.6, margin=0.1)
