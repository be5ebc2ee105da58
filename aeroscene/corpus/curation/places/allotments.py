"""Allotments: small gardens side by side along a path, each with its hut and beds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.seating import set_table
from aeroscene.corpus.curation.places.support_surfaces import OpenGround

_PLOT_M = 7.6
"""Typical width of one garden."""
_PATH_M = 1.8
_HUT_M = (2.2, 2.6, 2.4)


@dataclass(frozen=True, slots=True)
class _Garden:
    """One garden, bounded by u and v; its gate is at the path."""

    u0: float
    u1: float
    v0: float
    v1: float
    gate: int
    """Direction of the path: -1 towards the street, 1 away from it."""

    @property
    def middle(self) -> float:
        """Middle along u, m."""
        return (self.u0 + self.u1) / 2

    def at(self, share: float) -> float:
        """Place between the path (0) and the far end (1), as v, m."""
        near, far = (self.v1, self.v0) if self.gate > 0 else (self.v0, self.v1)
        return near + share * (far - near)


@dataclass(slots=True)
class Allotments:
    """Gardens on both sides of a path along the parcel; a shallow parcel has one row only."""

    ground: Ground
    _gardens: list[_Garden] = field(default_factory=list)
    _huts: list[Placed] = field(default_factory=list)

    def structures(self) -> Iterator[None]:
        """Grow the path; then a hut in each garden and hedges between them."""
        ground = self.ground
        ground.cover("lawn", {"form": "plain"})
        width, depth = ground.parcel.width, ground.parcel.depth
        # In a shallow parcel the path runs along the back, and all gardens lie before it.
        middle = round(depth / 2, 2) if depth > 15.0 else round(depth - 1.2, 2)
        size = (round(width - 0.8, 2), _PATH_M, 0.05)
        ground.stand("sidewalk", 0.0, middle, size, turn=0.0, margin=0.0)
        self._part(middle)
        yield
        for garden in self._gardens:
            # Off the fence at the back, in a corner of the garden.
            far = garden.at(1.0) + (1.7 if garden.gate > 0 else -1.7)
            u = garden.u0 + 1.9
            look = {"form": "shed"}
            turn = INWARD if garden.gate > 0 else STREETWARD
            hut = ground.erect("garage", u, far, _HUT_M, turn=turn, look=look)
            self._huts += [hut] if hut else []
            yield
        for garden in self._gardens:
            if garden.u1 < width / 2 - 1.0:
                start, end = (garden.u1, garden.v0 + 0.2), (garden.u1, garden.v1 - 0.2)
                ground.fence_line(start, end, "hedge", 0.9)
                yield

    def _part(self, middle: float) -> None:
        """Gardens of equal width on either side of the path."""
        width, depth = self.ground.parcel.width, self.ground.parcel.depth
        count = max(1, round((width - 0.8) / _PLOT_M))
        share = (width - 0.8) / count
        rows = [(0.4, middle - _PATH_M / 2 - 0.2, 1)]
        # A second row needs some depth behind the path.
        if depth - middle > 6.0:
            rows.append((middle + _PATH_M / 2 + 0.2, depth - 0.4, -1))
        for v0, v1, gate in rows:
            for index in range(count):
                u0 = round(-width / 2 + 0.4 + index * share, 2)
                self._gardens.append(_Garden(u0, round(u0 + share, 2), v0, v1, gate))

    def details(self) -> Iterator[None]:
        """Grow beds, fruit trees, compost bins, a table here and there, objects along the path."""
        ground = self.ground
        growths = [self._tend(garden) for garden in self._gardens]
        yield from interleave(*growths, self._line_path())
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        ground.scatter("bush", 3, near=(-half, half, 0.2, depth))
        yield

    def _tend(self, garden: _Garden) -> Iterator[None]:
        """Two beds and a tree, then the objects that each gardener chooses."""
        ground, draw = self.ground, self.ground.draw
        right = garden.u1 - 1.6
        for share in (0.25, 0.55):
            size = (1.2, min(2.6, round(garden.u1 - garden.u0 - 3.0, 2)), 0.6)
            ground.stand("planter", right - 0.5, garden.at(share), size, margin=0.1)
        yield
        crown = draw.between(1.9, 2.6)
        size = (crown, crown, draw.between(3.0, 3.8))
        look = {"form": draw.one_of(("round", "spreading"))}
        ground.stand("tree", right, garden.at(0.84), size, turn=0.0, look=look)
        yield
        ground.stand("bin", garden.u0 + 3.7, garden.at(0.9), (0.7, 0.7, 0.9), turn=0.0)
        ground.stand("bush", garden.u0 + 0.9, garden.at(0.2), (1.0, 1.2, 0.8))
        yield
        # A table, a bench or crates, so that gardens differ.
        match draw.count(0, 2):
            case 0:
                frame = ground.parcel.frame
                set_table(OpenGround(ground), frame, garden.u0 + 1.9, garden.at(0.5), chairs=2)
            case 1:
                turn = STREETWARD if garden.gate < 0 else INWARD
                ground.stand("bench", garden.u0 + 1.6, garden.at(0.45), turn=turn)
            case _:
                size = (1.0, 1.0, 0.8)
                ground.stand("crate", garden.u0 + 1.4, garden.at(0.4), size, turn=QUARTER)
        yield

    def _line_path(self) -> Iterator[None]:
        """A notice board at the entrance, bicycles and bins along the path."""
        ground, draw = self.ground, self.ground.draw
        half = ground.parcel.width / 2
        # The path runs just beyond the ends of the first row's gardens.
        v = next((garden.v1 for garden in self._gardens), 0.0) + 0.2 + _PATH_M / 2
        ground.stand("sign", -half + 0.6, v, (0.1, 1.0, 2.0), turn=0.0)
        for _ in range(3):
            u = draw.between(-0.85, 0.85) * half
            ground.stand("bicycle", u, v + 0.5, (1.75, 0.5, 1.05), turn=0.0)
            yield
