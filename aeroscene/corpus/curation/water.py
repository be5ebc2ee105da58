"""Water between quays: jetties and boats."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import pi

from aeroscene.corpus.curation.builder import Builder, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import QUARTER
from aeroscene.solids.shapes.materials import PAINT_COLOURS

_DRAUGHT_M = 0.03
"""Height of a keel above the bed: hulls lie in the water, not on it."""
_JETTY_M = 0.7
"""Height of a jetty's planks above the bottom."""
_RIM_M = 0.4
"""Fenders between a quay and a boat."""


@dataclass(slots=True)
class Basin:
    """A harbour basin or a canal: boats along its quay and along jetties."""

    builder: Builder
    draw: Draw
    water: Placed
    _jetties: list[float] = field(default_factory=list)

    def structures(self) -> Iterator[None]:
        """Jetties from the quay, as many as the basin has room for."""
        # A boat has to pass behind the jetties.
        length, depth, _ = self.water.size
        reach = min(8.0, depth - 6.0)
        yield
        # One jetty for each 24 m of quay.
        count = int(length // 24) if reach >= 4 else 0
        for index in range(count):
            u = -length / 2 + (index + 0.5) * length / count + self.draw.between(-3, 3)
            v = -depth / 2 + reach / 2
            size = (3.0, reach, _JETTY_M)
            if self.builder.place(
                "deck", self.water.frame.moved(u, v), size, base=self.water.base, parent=self.water
            ):
                self._jetties.append(u)
            yield

    def details(self) -> Iterator[None]:
        """Boats beside the jetties, then along both quays."""
        _, depth, _ = self.water.size
        for u in self._jetties:
            for side in (-1, 1):
                size = self._boat_size(6.5)
                across = side * (1.5 + size[1] / 2 + 0.35)
                v = -depth / 2 + _RIM_M + 0.3 + size[0] / 2
                self._moor(u + across, v, size, QUARTER * self._sign())
                yield
        yield from self._moor_along_quays()

    def _moor_along_quays(self) -> Iterator[None]:
        length, depth, _ = self.water.size
        for _ in range(int(length // 9)):
            size = self._boat_size(9.0)
            side = self._sign()
            v = side * (depth / 2 - _RIM_M - size[1] / 2)
            u = self.draw.between(-0.5, 0.5) * (length - size[0] - 2)
            self._moor(u, v, size, 0.0 if side < 0 else pi)
            yield

    def _boat_size(self, longest: float) -> tuple[float, float, float]:
        length = self.draw.between(4.2, longest)
        # A mast about as high as the boat is long, or a cabin.
        high = length if self.draw.chance(0.4) else 1.0 + 0.14 * length
        return (length, round(max(1.7, 0.32 * length), 2), round(high, 2))

    def _sign(self) -> int:
        return 1 if self.draw.chance(0.5) else -1

    def _moor(self, u: float, v: float, size: tuple[float, float, float], turn: float) -> None:
        colour = {"colour": self.draw.one_of(PAINT_COLOURS)}
        water, spot = self.water, self.water.frame.moved(u, v, turn)
        base = water.base + _DRAUGHT_M
        self.builder.place(
            "boat", spot, size, base=base, parent=water, within=water, margin=0.25, look=colour
        )
