"""Ground that is not flat: terraces above the street, slopes of grass."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from aeroscene.corpus.curation.builder import Builder, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import INWARD, QUARTER
from aeroscene.corpus.curation.parcels import Parcel
from aeroscene.corpus.curation.places.ground import Ground

_STRIP_M = 0.06
"""Height of the strip of green before a terrace."""
_PARAPET = (0.25, 0.6)
"""Thickness and height of the wall on a terrace's edge, m."""
_STAIRS_M = 2.4
_RAMP_M = 2.1
"""Widths of stairs and ramp."""
_TREAD_PER_RISE = 1.75
_RUN_PER_RISE = 8.0
"""Length of stairs, and of a ramp, for each metre of height."""
_LEAST_DEPTH_M = 14.0


def raise_terrace(builder: Builder, draw: Draw, parcel: Parcel) -> Parcel:
    """Lift a parcel above the street behind a strip of green.

    Args:
        builder: Builder of the scene.
        draw: Randomness.
        parcel: Flat parcel.

    Returns:
        The parcel on its terrace; the given one if it is too shallow or no longer flat.
    """
    height = draw.between(0.55, 1.3)
    # The strip has room for the stairs, or the ramp beside them.
    strip_m = round(max(_RAMP_M, _TREAD_PER_RISE * height) + draw.between(0.5, 1.0), 2)
    depth = round(parcel.depth - strip_m, 2)
    if depth - _PARAPET[0] < _LEAST_DEPTH_M or parcel.rise or parcel.level:
        return parcel
    look = {
        "form": "terrace",
        "finish": draw.one_of(("concrete", "paving")),
        "wall": draw.one_of(("stone", "brick", "dark_concrete")),
    }
    frame = parcel.frame.moved(0, strip_m)
    size = (parcel.width, depth, height)
    block = builder.place("terrain", frame.moved(0, depth / 2), size, look=look)
    if block is None:
        return parcel
    name = draw.one_of(("lawn", "lawn", "sidewalk"))
    spot = parcel.frame.moved(0, strip_m / 2)
    strip = builder.place(name, spot, (parcel.width, strip_m, _STRIP_M))
    if strip:
        _join(builder, draw, parcel, strip, block)
    return replace(
        parcel,
        # Places begin behind the parapet.
        frame=frame.moved(0, _PARAPET[0]),
        depth=round(depth - _PARAPET[0], 2),
        level=height,
        bearer=block,
    )


def _join(builder: Builder, draw: Draw, parcel: Parcel, strip: Placed, block: Placed) -> None:
    """Place stairs and perhaps a ramp up to a terrace, and a parapet between them."""
    height = block.top - strip.top
    edge = strip.size[1]
    half = parcel.width / 2
    side = 1 if draw.chance(0.5) else -1
    stairs_u = side * draw.between(0.1, 0.6) * (half - _STAIRS_M)
    run = max(1.0, round(_TREAD_PER_RISE * height, 2))
    spot = parcel.frame.moved(stairs_u, edge - run / 2, INWARD)
    builder.place("stairs", spot, (run, _STAIRS_M, height), parent=strip)
    gaps = [(stairs_u, _STAIRS_M)]
    long = round(_RUN_PER_RISE * height, 2)
    far = -side * (half - 0.3)
    # A ramp of one in eight needs half of the front.
    if draw.chance(0.6) and long < half + 0.1 * half:
        low_end = far + side * long
        spot = parcel.frame.moved(
            (far + low_end) / 2, edge - _RAMP_M / 2, 0.0 if side < 0 else 2 * QUARTER
        )
        size = (long, _RAMP_M, height)
        look = {"form": "ramp", "finish": "paving"}
        ramp = builder.place("terrain", spot, size, parent=strip, look=look)
        # Open at the ramp's upper end.
        if ramp:
            gaps.append((far + side * 0.9, 2.2))
    _parapet(builder, parcel, block, edge, gaps)


def _parapet(
    builder: Builder, parcel: Parcel, block: Placed, edge: float, gaps: list[tuple[float, float]]
) -> None:
    """Place walls along a terrace's edge, apart from the gaps (middle, width)."""
    thick, height = _PARAPET
    at = -parcel.width / 2
    # A gap beyond the end closes the last piece.
    for middle, width in [*sorted(gaps), (parcel.width / 2 + 0.5, 1.0)]:
        low, high = at, middle - width / 2
        at = middle + width / 2
        if high - low < 1.0:
            continue
        spot = parcel.frame.moved((low + high) / 2, edge + thick / 2, QUARTER)
        builder.place("wall", spot, (thick, round(min(high - low, 24.0), 2), height), parent=block)


@dataclass(slots=True)
class Slope:
    """A hillside of grass with a path, trees and benches with a view."""

    ground: Ground

    def structures(self) -> Iterator[None]:
        """Grow the hill, a path up it, and a platform to look from."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("lawn")
        yield
        self._lay_path(draw.between(-0.6, 0.6) * ground.parcel.width / 2)
        yield
        v = draw.between(0.4, 0.7) * ground.parcel.depth
        u = draw.between(-0.6, 0.6) * ground.parcel.width / 2
        ground.stand("deck", u, v, (3.2, draw.between(3, 5), 0.9), margin=0.3)
        yield

    def _lay_path(self, u: float) -> None:
        """Lay paving a little above the grass, at the hill's own slope."""
        ground, parcel = self.ground, self.ground.parcel
        ground.builder.place(
            "terrain",
            parcel.frame.moved(u, parcel.depth / 2, INWARD),
            (parcel.depth, 2.0, parcel.rise),
            base=parcel.level + 0.02,
            parent=ground.surface,
            within=ground.surface,
            look={"form": "ramp", "finish": "paving"},
        )

    def details(self) -> Iterator[None]:
        """Grow trees and bushes between benches that look down the hill."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        for _ in range(6):
            ground.plant_trees(1)
            yield
            ground.stand("bench", draw.between(-0.9, 0.9) * half, draw.between(0.3, 0.8) * depth)
            ground.scatter("bush", 2)
            yield
