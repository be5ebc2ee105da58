"""A park: lawn, pond, stage, trees, benches."""

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
class Park:
    """Green with a path across it."""

    ground: Ground
    _path_u: float = 0.0
    _stage: Placed | None = None

    def structures(self) -> Iterator[None]:
        """Two lawns beside a path, a pond, a stage, a kiosk or a canopy."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("lawn")
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        self._path_u = draw.between(-0.25, 0.25) * half
        self._path(self._path_u)
        side = 1 if draw.chance(0.5) else -1
        if draw.chance(0.75):
            size = (draw.between(4, 8), draw.between(5, 9), 0.25)
            self._on_lawn("water", side * half * 0.55, depth * draw.between(0.4, 0.7), size)
        if draw.chance(0.7):
            size = (draw.between(3.5, 6), draw.between(4, 7), draw.between(0.4, 0.9))
            v = depth * draw.between(0.3, 0.75)
            self._stage = self._on_lawn("deck", -side * half * 0.6, v, size)
            if self._stage:
                self._steps(self._stage)
        colour: dict[str, AttributeValue] = {"colour": draw.one_of(PAINT_COLOURS)}
        name, size = ("kiosk", (2.6, 3.2, 2.8)) if draw.chance(0.5) else ("canopy", (4, 5, 3.2))
        self._on_lawn(name, -side * half * 0.6, 3.2, size, colour)
        if draw.chance(0.5):
            ground.fence_line((-half + 0.5, depth - 0.3), (half - 0.5, depth - 0.3), "hedge", 1.4)
        yield

    def _path(self, u: float) -> None:
        ground = self.ground
        depth = ground.parcel.depth
        ground.builder.place(
            "sidewalk",
            ground.parcel.frame,
            u,
            depth / 2,
            (depth, 2.2, 0.04),
            base=ground.level,
            turn=-STREETWARD,
            parent=ground.surface,
        )

    def _steps(self, stage: Placed) -> None:
        """Steps up to the stage on its front."""
        self.ground.builder.place(
            "stairs",
            stage.frame,
            stage.size[0] / 2 + 0.45,
            0.0,
            (0.9, 1.8, stage.size[2]),
            base=stage.base,
            turn=pi,
            parent=self.ground.surface,
        )

    def _on_lawn(
        self,
        name: str,
        u: float,
        v: float,
        size: tuple[float, float, float],
        attributes: dict[str, AttributeValue] | None = None,
    ) -> Placed | None:
        return self.ground.stand(name, u, v, size, margin=0.5, attributes=attributes)

    def details(self) -> Iterator[None]:
        """Benches and bins along the path, trees and bushes on the green."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        for index in range(draw.count(2, 4)):
            sign = 1 if index % 2 else -1
            v = depth * (0.12 + 0.19 * index)
            turn = pi if sign > 0 else 0.0
            if ground.stand("bench", self._path_u + sign * 1.7, v, turn=turn) and draw.chance(0.3):
                ground.stand("bin", self._path_u + sign * 1.6, v + 1.7, turn=turn)
        if self._stage:
            ground.builder.place(
                "crate",
                self._stage.frame,
                -0.25 * self._stage.size[0],
                0.25 * self._stage.size[1],
                (1.0, 1.0, 0.8),
                base=self._stage.top,
                parent=self._stage,
            )
        ground.plant_trees(draw.count(2, 4))
        ground.plant_trees(draw.count(2, 4), (-half, half, 0.5 * depth, depth))
        ground.scatter("bush", draw.count(2, 6))
        ground.stand("sign", self._path_u + 1.7, 0.7)
        yield
