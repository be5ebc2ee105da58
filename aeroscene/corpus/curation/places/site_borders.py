"""A place with a border where the site ends: a hedge, a fence or a wall along those sides."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.composition import Place
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.parcels import Parcel, Side
from aeroscene.corpus.curation.places.ground import Ground

_BEYOND_M = 0.6
"""Distance beyond a side at which its neighbour is looked for."""
_SHARES = (0.15, 0.5, 0.85)
"""Places along a side at which its neighbour is looked for."""
_GROUNDS = frozenset(("road", "sidewalk", "lawn", "water", "terrain", "plaza", "parking_lot"))


@dataclass(slots=True)
class Bordered:
    """Another place with fences along some sides of its parcel."""

    place: Place
    ground: Ground
    sides: Sequence[Side]
    form: str
    """Form of the fences."""
    height: float
    """Height of the fences, m."""

    def structures(self) -> Iterator[None]:
        """Place the first step of the wrapped place, its border, then the rest."""
        growth = self.place.structures()
        # A border placed first could take the space of a building, one placed last might not fit.
        next(growth, None)
        for side in self.sides:
            self.ground.fence_border(side, self.form, self.height)
        yield
        yield from growth

    def details(self) -> Iterator[None]:
        """Place the details of the wrapped place."""
        yield from self.place.details()


def outer_sides(builder: Builder, parcel: Parcel, parcels: Sequence[Parcel]) -> list[Side]:
    """Back and flanks of a parcel beyond which the site ends, the back first.

    A side counts only if nothing borders on it at any of three points.
    """
    half = parcel.width / 2 + _BEYOND_M
    lines: dict[Side, list[tuple[float, float]]] = {
        "north": [((s - 0.5) * parcel.width, parcel.depth + _BEYOND_M) for s in _SHARES],
        "east": [(half, s * parcel.depth) for s in _SHARES],
        "west": [(-half, s * parcel.depth) for s in _SHARES],
    }
    # The streets' objects, which stand already; other places are known by their parcels.
    grounds = [
        (Frame(*obj.bbox.p[:2], obj.bbox.yaw_rad), obj.bbox.s)
        for obj in builder.objects
        if obj.category in _GROUNDS
    ]
    others = [other for other in parcels if other is not parcel]

    def is_beyond(point: tuple[float, float]) -> bool:
        x, y = parcel.frame.point(*point)
        if any(_holds(other, x, y) for other in others):
            return False
        places = ((frame.local(x, y), size) for frame, size in grounds)
        return not any(abs(u) <= s[0] / 2 and abs(v) <= s[1] / 2 for (u, v), s in places)

    return [side for side, points in lines.items() if all(map(is_beyond, points))]


def _holds(parcel: Parcel, x: float, y: float) -> bool:
    u, v = parcel.frame.local(x, y)
    return abs(u) <= parcel.width / 2 and 0.0 <= v <= parcel.depth
