"""A hillside garden: terraces that step up from the street, joined by stairs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.goods import crate_stack
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import line_way
from aeroscene.corpus.curation.places.rooftops import add_chimney, add_pitched_roof
from aeroscene.corpus.curation.places.seating import dine, picnic
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, Platform, beneath, on_top
from aeroscene.scene import Vector3
from aeroscene.solids.shapes.materials import WALL_COLOURS

_STRIP_M = 7.0
"""Least depth of one terrace."""
_DEEP_M = 34.0
"""Depth from which a parcel has three terraces."""
_RISE_M = 0.9
_STEPS_M = (1.8, 1.6)
"""Length and width of the stairs from one terrace to the next."""
_WALL_M = (0.25, 0.3)
"""Thickness of a retaining wall, and its rim above the terrace."""


@dataclass(slots=True)
class Terraces:
    """Strips of garden, each higher than the one before, and a house on the highest."""

    ground: Ground
    _steps: list[Placed] = field(default_factory=list)
    """Terraces from low to high."""
    _stairs: list[float] = field(default_factory=list)
    """Place of the stairs that arrive at each of them, u."""
    _lowest: float = 0.0
    """Depth of the strip at the street."""
    _pavilion: Placed | None = None
    _roof: Placed | None = None
    _path: Placed | None = None

    def structures(self) -> Iterator[None]:
        """Grow terraces with stairs; then their walls, a house on top, a pavilion, a path."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("lawn")
        self._raise_terraces()
        yield
        for number in range(len(self._steps)):
            self._retain(number)
            yield
            # The house comes early, right after the first walls: it characterises the place.
            if number == 0:
                self._raise_house()
                yield
        half = ground.parcel.width / 2
        if self._steps:
            colour = {"colour": draw.one_of(("white", "green"))}
            middle, at = self._steps[0], draw.between(-0.5, 0.5) * half
            spot = middle.frame.moved(0.2, at)
            self._pavilion = on_top(ground, middle).stand(
                "canopy", spot, (3.4, 4.2, 3.0), margin=0.4, look=colour
            )
            yield
        size = (round(2 * half - 2.0, 2), 1.6, 0.05)
        self._path = ground.stand("sidewalk", 0.0, 0.45 * self._lowest, size, turn=0.0, margin=0.0)
        yield

    def _raise_terraces(self) -> None:
        """Blocks of earth side by side, higher towards the back, with stairs before each."""
        ground, draw = self.ground, self.ground.draw
        width, depth = ground.parcel.width, ground.parcel.depth
        count = max(1, min(3 if depth > _DEEP_M else 2, int(depth / _STRIP_M) - 1))
        strip = round(depth / (count + 1), 2)
        self._lowest = strip
        earth = {"form": "terrace", "finish": "grass"}
        u = draw.between(0.12, 0.3) * width * (1 if draw.chance(0.5) else -1)
        for index in range(count):
            size = (strip, round(width - 0.2, 2), round(_RISE_M * (index + 1), 2))
            v = strip * (index + 1.5) - 0.05
            terrace = ground.stand("terrain", 0, v, size, turn=INWARD, margin=0.0, look=earth)
            if terrace is None:
                return
            # Stairs stand on the terrace below, so that one has to exist before.
            self._climb(self._steps[-1] if self._steps else None, u, strip * (index + 1) - 0.05)
            self._steps.append(terrace)
            self._stairs.append(u)
            # Stairs change sides from terrace to terrace.
            u = -u

    def _climb(self, below: Placed | None, u: float, front: float) -> None:
        """Stairs that end at a terrace's front edge."""
        ground = self.ground
        bearing = on_top(ground, below) if below else OpenGround(ground)
        size = (*_STEPS_M, _RISE_M)
        v = front - _STEPS_M[0] / 2
        bearing.stand("stairs", ground.parcel.frame.moved(u, v, INWARD), size, margin=0.0)

    def _raise_house(self) -> None:
        """A small house on the highest terrace, or a shed where it is narrow."""
        ground, draw = self.ground, self.ground.draw
        if not self._steps:
            return
        top = self._steps[-1]
        platform = on_top(ground, top)
        deep, width, _ = top.size
        at = draw.between(-0.25, 0.25) * (width - 9.0) if width > 9 else 0.0
        if deep >= 7.2:
            size: Vector3 = (6.0, min(8.6, round(width - 1.0, 2)), 3.2)
            colour = {"colour": draw.one_of((*WALL_COLOURS, "brick"))}
            spot = top.frame.moved(deep / 2 - 3.5, at, -2 * QUARTER)
            house = platform.stand("house", spot, size, look=colour)
            self._roof = add_pitched_roof(ground.builder, draw, house) if house else None
            return
        shed = {"form": "shed"}
        spot = top.frame.moved(deep / 2 - 1.8, at, 2 * QUARTER)
        platform.stand("garage", spot, (2.6, 3.2, 2.4), look=shed)

    def _retain(self, number: int) -> None:
        """Walls along a terrace's front on either side of the stairs, with a rim above it."""
        ground, terrace = self.ground, self._steps[number]
        below = on_top(ground, self._steps[number - 1]) if number else OpenGround(ground)
        half = terrace.size[1] / 2
        v = self._lowest * (number + 1) - 0.05 - _WALL_M[0] / 2
        colour = {"colour": "sand"}
        gap = _STEPS_M[1] / 2 + 0.02
        # Walls are cut at the stairs.
        for low, high in ((-half, self._stairs[number] - gap), (self._stairs[number] + gap, half)):
            # 24 m is the longest wall of the catalogue.
            size = (_WALL_M[0], round(min(high - low, 24.0), 2), _RISE_M + _WALL_M[1])
            if size[1] > 1.0:
                spot = ground.parcel.frame.moved((low + high) / 2, v, INWARD)
                below.stand("wall", spot, size, margin=0.0, look=colour)

    def details(self) -> Iterator[None]:
        """Grow beds, tables and trees on every terrace, benches along the path."""
        ground = self.ground
        growths = [self._tend(on_top(ground, terrace), terrace) for terrace in self._steps]
        yield from interleave(self._sit(), *growths, self._front())

    def _sit(self) -> Iterator[None]:
        """A table in the pavilion, a chimney on the house, a picnic table above."""
        ground, draw = self.ground, self.ground.draw
        if self._pavilion:
            pavilion = self._pavilion
            yield from dine(beneath(ground, pavilion), pavilion.frame, [(0.0, 0.0)], QUARTER)
        if self._roof:
            add_chimney(ground.builder, draw, self._roof)
            yield
        if self._steps:
            top = self._steps[-1]
            at = draw.between(-0.35, 0.35) * top.size[1]
            picnic(on_top(ground, top), top.frame, -0.25 * top.size[0], at, QUARTER)
            yield

    def _tend(self, platform: Platform, terrace: Placed) -> Iterator[None]:
        """Beds in a row along the back, trees at the ends, a bench that looks downhill."""
        draw, frame = platform.draw, terrace.frame
        deep, width, _ = terrace.size
        start = draw.between(-0.35, 0.0) * width
        for pair in range(2):
            for index in range(2):
                at = start + (2 * pair + index) * 3.1
                spot = frame.moved(deep / 2 - 1.0, at)
                platform.stand("planter", spot, (1.2, 2.6, 0.7), margin=0.1)
            yield
        for sign in (-1, 1):
            height = draw.between(4.0, 6.5)
            size = (round(0.45 * height, 2), round(0.45 * height, 2), height)
            at = sign * (width / 2 - size[1] / 2 - 0.5)
            platform.stand("tree", frame.moved(draw.between(-0.1, 0.2) * deep, at), size)
            platform.stand("bush", frame.moved(-0.1 * deep, at - sign * 2.2), (1.2, 1.2, 0.9))
            yield
        at = draw.between(-0.3, 0.3) * width
        platform.stand("bench", frame.moved(-deep / 2 + 1.6, at, 2 * QUARTER), (0.6, 1.8, 0.85))
        yield
        at = draw.between(-0.4, 0.4) * width
        picnic(platform, frame, -0.1 * deep, at, draw.between(-0.3, 0.3))
        yield
        crate_stack(platform, frame, 0.1 * deep, draw.between(-0.4, 0.4) * width)
        yield
        for step in range(6):
            for name, size in (("bush", (1.0, 1.4, 1.0)), ("planter", (0.7, 0.7, 0.9))):
                u, at = draw.between(-0.35, 0.35) * deep, draw.between(-0.45, 0.45) * width
                platform.stand(name, frame.moved(u, at), size)
            if step % 3 == 0:
                at = draw.between(-0.45, 0.45) * width
                platform.stand("crate", frame.moved(0.3 * deep, at), (0.7, 0.7, 0.6))
            yield

    def _front(self) -> Iterator[None]:
        """The strip at the street: path with benches, trees, bins, a sign."""
        ground = self.ground
        half = ground.parcel.width / 2
        if self._path:
            end = self._path.size[0] / 2 - 1.0
            yield from line_way(OpenGround(ground), self._path.frame, (-end, end), 0.8)
        low = (-half, half, 0.3, self._lowest - 0.3)
        ground.plant_trees(2, low)
        yield
        ground.stand("sign", 0.7 * half, 0.7, (0.1, 1.0, 2.0), turn=STREETWARD)
        ground.scatter("bush", 2, near=low)
        yield
        yield from fill_up(ground, ("planter", "tree", "bush", "bicycle", "bin"), low, 7)
