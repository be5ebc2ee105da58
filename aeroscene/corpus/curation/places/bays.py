"""Painted bays for cars: their places, the cars in them, roofs over some of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, STREETWARD
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.roadside import park
from aeroscene.corpus.curation.places.support_surfaces import Bearing, beneath, on_top
from aeroscene.solids.shapes.ground import BAY_WIDTH_M

TWO_ROWS_M = 15.6
"""Depth of two rows of bays with a lane between."""
_PAINTED_M = 0.02
"""Thickness of a field of bays, an object of its own on the asphalt."""
_BAY_HALF_M = 2.65
"""Distance from the border of a field to the middle of its bays."""
_CARPORT_M = (5.2, 2.9)
"""Depth and height of a roof over bays."""
_SOLAR_M = (2.0, 3.0, 0.5)


@dataclass(frozen=True, slots=True)
class Bay:
    """One space: its middle in the field's frame, m, and the sign of its row along v."""

    u: float
    v: float
    row: int


@dataclass(slots=True)
class BayField:
    """A field of bays in one or two rows along the parcel's u axis."""

    lot: Placed
    bays: list[Bay]
    carport: Placed | None = None
    covered: frozenset[int] = frozenset()
    """Numbers of the bays under the carport."""

    def park_cars(self, ground: Ground) -> Iterator[None]:
        """Park cars in most of the bays, two in each step, nose in or out.

        Args:
            ground: Parcel of the field.
        """
        draw = ground.draw
        share = draw.between(0.65, 0.92)
        for step, index in enumerate(draw.shuffled(range(len(self.bays)))):
            if step > share * len(self.bays):
                break
            bay, bearing = self.bays[index], on_top(ground, self.lot)
            is_covered = self.carport is not None and index in self.covered
            if is_covered and self.carport:
                # A car under the roof belongs to the roof.
                bearing = beneath(ground, self.carport)
            # Vans are higher than a carport allows.
            name = "van" if not is_covered and draw.chance(0.12) else "car"
            turn = INWARD if draw.chance(0.5) else STREETWARD
            park(bearing, name, self.lot.frame, bay.u, bay.v, turn)
            if step % 2:
                yield
        yield

    def raise_carport(self, ground: Ground) -> None:
        """Place a roof over some bays of the far row, on which solar panels can lie.

        A row of fewer than three bays has none.

        Args:
            ground: Parcel of the field.
        """
        row = [index for index, bay in enumerate(self.bays) if bay.row == 1]
        # At least one bay stays open, so that the field is recognisable from above.
        count = min(5, len(row) - 1)
        if count < 2:
            return
        first = ground.draw.count(0, len(row) - count)
        covered = row[first : first + count]
        middle = sum(self.bays[index].u for index in covered) / count
        size = (_CARPORT_M[0], round(count * BAY_WIDTH_M - 0.1, 2), _CARPORT_M[1])
        look = {"colour": "silver", "form": "flat"}
        spot = self.lot.frame.moved(middle, self.bays[covered[0]].v, STREETWARD)
        self.carport = on_top(ground, self.lot).stand("canopy", spot, size, margin=0.0, look=look)
        self.covered = frozenset(covered)

    def equip(self, ground: Ground) -> Iterator[None]:
        """Place solar panels in a row on the carport, and a lamp at each end of the lane."""
        if self.carport:
            # A panel is 3 m wide, and a tenth of a metre lies between two.
            platform = on_top(ground, self.carport)
            count = max(1, int((self.carport.size[1] - 0.2) / 3.1))
            for index in range(count):
                at = (index - (count - 1) / 2) * 3.1
                platform.stand("solar_panel", self.carport.frame.moved(0.6, at), _SOLAR_M)
            yield
        reach = self.lot.size[0] / 2 - 0.5
        lot = on_top(ground, self.lot)
        for sign in (-1, 1):
            turn = pi if sign > 0 else 0.0
            lot.stand("street_lamp", self.lot.frame.moved(sign * reach, 0, turn), (1.6, 0.5, 5.5))
        yield


def paint_bays(
    ground: Ground, bearing: Bearing, span: tuple[float, float], v0: float, deep: float
) -> BayField | None:
    """Paint a field of bays.

    Args:
        ground: Parcel, whose frame counts.
        bearing: Surface that carries the field.
        span: Its ends along u, m.
        v0: Its side towards the street, m.
        deep: Its depth, m; one or two rows.
    """
    low, high = span
    rows = 2 if deep >= TWO_ROWS_M - 0.5 else 1
    look = {"rows": rows}
    size = (round(high - low, 2), round(deep, 2), _PAINTED_M)
    middle = ((low + high) / 2, v0 + deep / 2)
    spot = ground.parcel.frame.moved(*middle)
    lot = bearing.stand("parking_lot", spot, size, margin=0.0, look=look)
    if lot is None:
        return None
    # The bays share what is left at both ends.
    count = int((size[0] - 0.1) // BAY_WIDTH_M)
    bays = [
        Bay((index - (count - 1) / 2) * BAY_WIDTH_M, row * (deep / 2 - _BAY_HALF_M), row)
        for row in (1, -1)[:rows]
        for index in range(count)
    ]
    return BayField(lot, bays)
