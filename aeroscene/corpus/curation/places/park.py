"""A park: paths, a pond, a stage, a mound, picnic tables, benches that face the path."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import pi

from aeroscene.corpus.curation.builder import Attributes, Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.goods import paint
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import line_way
from aeroscene.corpus.curation.places.seating import dine, picnic
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, beneath, on_top
from aeroscene.scene import Vector3

_PATH_M = (2.2, 0.05)
_STEP_M = 0.9
"""Length of the stairs up to a stage."""


@dataclass(slots=True)
class Park:
    """A lawn with a path through it and another that branches off."""

    ground: Ground
    _paths: list[Placed] = field(default_factory=list)
    _pond: Placed | None = None
    _stage: Placed | None = None
    _shelter: Placed | None = None
    _sides: tuple[int, int] = (1, -1)
    """Sides of the pond and of the stage."""

    def structures(self) -> Iterator[None]:
        """Grow lawn and path; then pond, stage, mound, pavilion, branch, hedge."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("lawn", {"form": "plain"})
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        self._sides = (1, -1) if draw.chance(0.5) else (-1, 1)
        path_u = draw.between(-0.15, 0.15) * half
        self._pave(path_u, depth / 2, depth, QUARTER)
        pond, stage = self._sides
        # The pond is on one side of the path, the stage on the other.
        size = (draw.between(0.28, 0.4) * depth, draw.between(0.5, 0.7) * half, 0.25)
        size = (round(max(3.0, size[0]), 2), round(max(3.0, size[1]), 2), 0.1)
        look = {"form": "pond"}
        self._pond = self._on_lawn("water", path_u + pond * 0.55 * half, 0.66 * depth, size, look)
        yield
        self._raise_stage(path_u + stage * 0.55 * half, 0.7 * depth, stage)
        yield
        # A branch only where a lawn of some width remains beside it.
        if half > 9:
            branch = half - abs(path_u) - 2.2
            u = path_u + stage * (branch / 2 + _PATH_M[0] / 2)
            self._pave(u, 0.42 * depth, branch, 0.0)
        yield
        self._raise_mound(path_u + pond * 0.55 * half, 0.26 * depth)
        yield
        name = draw.one_of(("canopy", "canopy", "kiosk"))
        size = (2.6, 3.2, 2.8) if name == "kiosk" else (4.0, 5.0, 3.2)
        u = path_u + stage * min(0.55 * half, half - 3.5)
        look = {**paint(draw), "form": "pitched" if name == "canopy" else "hatch"}
        placed = self._on_lawn(name, u, 0.2 * depth, size, look)
        self._shelter = placed if placed and name == "canopy" else None
        yield
        form = {"form": "hedge"}
        for sign in (-1, 1):
            # The hedge at the back leaves the path open.
            long = half - 2.6 - sign * path_u
            u = path_u + sign * (1.8 + long / 2)
            if long > 2:
                size = (0.3, round(long, 2), 1.3)
                ground.stand("fence", u, depth - 0.4, size, margin=0.0, look=form)
            yield

    def _pave(self, u: float, v: float, long: float, turn: float) -> None:
        size = (round(long, 2), *_PATH_M)
        path = self.ground.stand("sidewalk", u, v, size, turn=turn, margin=0.0)
        if path:
            self._paths.append(path)

    def _raise_stage(self, u: float, v: float, side: int) -> None:
        """A platform that looks to the path, with steps up its flank."""
        ground, draw = self.ground, self.ground.draw
        size = (draw.between(3.5, 5.0), draw.between(4.0, 6.5), draw.between(0.5, 0.9))
        turn = pi if side > 0 else 0.0
        self._stage = self._on_lawn("deck", u, v, size, turn=turn)
        if self._stage:
            reach = size[1] / 2 + _STEP_M / 2
            frame = self._stage.frame
            steps = (_STEP_M, 1.6, size[2])
            OpenGround(ground).stand("stairs", frame.moved(0.0, reach, -QUARTER), steps, margin=0.0)

    def _raise_mound(self, u: float, v: float) -> None:
        """A low hill to sit on."""
        ground, draw = self.ground, self.ground.draw
        side = min(9.0, 0.45 * ground.parcel.depth, 0.8 * ground.parcel.width / 2)
        if side < 5:
            # Flat enough to land on: a tenth of its side.
            return
        size = (round(side, 2), round(side * draw.between(0.85, 1.0), 2), round(0.1 * side, 2))
        look = {"form": "mound", "finish": "grass"}
        self._on_lawn("terrain", u, v, size, look)

    def _on_lawn(
        self,
        name: str,
        u: float,
        v: float,
        size: Vector3,
        look: Attributes | None = None,
        turn: float = STREETWARD,
    ) -> Placed | None:
        return self.ground.stand(name, u, v, size, turn=turn, margin=0.4, look=look)

    def details(self) -> Iterator[None]:
        """Grow benches along the paths and trees first; then picnics, guests, flowers."""
        bearing = OpenGround(self.ground)
        ways: list[Iterator[None]] = []
        for path in self._paths:
            end = path.size[0] / 2 - 1.0
            ways.append(line_way(bearing, path.frame, (-end, end), _PATH_M[0] / 2))
        yield from interleave(interleave(*ways), self._plant(), self._rest(), self._shore())

    def _plant(self) -> Iterator[None]:
        """Groves in the corners, bushes between."""
        ground = self.ground
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        # Quarters of the lawn, the far one of each side first.
        corners = [
            (min(0.0, s * half), max(0.0, s * half), low * depth, (low + 0.5) * depth)
            for s in (-1, 1)
            for low in (0.5, 0.0)
        ]
        for corner in corners:
            ground.plant_trees(3, corner)
            yield
        for corner in corners:
            ground.scatter("bush", 2, near=corner)
            yield
            ground.plant_trees(1, corner)
            yield
        names = ("bush", "tree", "bench", "bicycle", "planter", "bin")
        yield from fill_up(ground, names, (-half, half, 0.3, depth), 10)

    def _rest(self) -> Iterator[None]:
        """A table in the pavilion, picnic tables on the grass, loudspeakers on the stage."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        if self._shelter:
            shelter = self._shelter
            spots = [(0.0, -1.2), (0.0, 1.2)]
            yield from dine(beneath(ground, shelter), shelter.frame, spots, QUARTER)
        if self._stage:
            stage, platform = self._stage, on_top(ground, self._stage)
            for sign in (-1, 1):
                at = sign * (stage.size[1] / 2 - 0.7)
                spot = stage.frame.moved(stage.size[0] / 2 - 0.8, at)
                platform.stand("crate", spot, (0.8, 0.8, 1.2))
            yield
            for index in range(3):
                reach = stage.size[0] / 2 + 2.2
                at = (index - 1) * 2.2
                spot = stage.frame.moved(reach, at, pi)
                OpenGround(ground).stand("bench", spot, (0.5, 1.8, 0.85))
            yield
        for _ in range(2):
            u = draw.between(-0.8, 0.8) * half
            turn = draw.between(-0.5, 0.5)
            picnic(OpenGround(ground), ground.parcel.frame, u, 0.5 * depth, turn)
            yield
        # The sign stands at the path, wherever that enters the parcel.
        sign_u = self._paths[0].frame if self._paths else ground.parcel.frame
        u, _ = ground.parcel.frame.local(sign_u.x, sign_u.y)
        ground.stand("sign", u + 1.8, 0.8, (0.1, 1.0, 2.2))
        ground.stand("bicycle", u - 1.8, 1.4, turn=INWARD)
        yield

    def _shore(self) -> Iterator[None]:
        """Benches that look over the pond, reeds on its banks."""
        ground, pond = self.ground, self._pond
        if pond is None:
            return
        bearing, draw = OpenGround(ground), ground.draw
        for quarter in draw.shuffled(range(4))[:2]:
            frame = pond.frame.moved(0, 0, quarter * QUARTER)
            reach = pond.size[quarter % 2] / 2 + 0.8
            bearing.stand("bench", frame.moved(reach, 0.0, pi), (0.6, 1.8, 0.85))
        yield
        for quarter in draw.shuffled(range(4)):
            frame = pond.frame.moved(0, 0, quarter * QUARTER)
            reach = pond.size[quarter % 2] / 2 + 0.6
            at = draw.between(-0.4, 0.4) * pond.size[1 - quarter % 2]
            bearing.stand("bush", frame.moved(reach, at), (0.8, 1.4, 0.9))
            if quarter % 2:
                yield
        yield
