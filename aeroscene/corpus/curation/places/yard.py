"""A container yard: stacks in rows with lanes between, goods, trucks, an office in a container."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.corpus.curation.places.boundary import enclose
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.goods import (
    CONTAINER_M,
    pallet_row,
    range_goods,
    set_container,
    stack_container,
)
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import park
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, beneath, on_top

_PITCH_M = 3.0
"""Distance between the middles of containers in a row."""
_LANE_M = 6.5
_GATE_M = 7.0


@dataclass(slots=True)
class Yard:
    """Asphalt with container stacks at the back and along one side, fenced."""

    ground: Ground
    _stacks: list[Placed] = field(default_factory=list)
    _office: Placed | None = None
    _shelter: Placed | None = None
    _side: int = 1

    def structures(self) -> Iterator[None]:
        """Grow two stacks, then an office, a shelter for goods, more stacks, fences with a gate."""
        ground, draw = self.ground, self.ground.draw
        look = {"rows": 0, "form": "bays"}
        ground.cover("parking_lot", look)
        self._side = 1 if draw.chance(0.5) else -1
        spots = self._spots()
        for spot in spots[:2]:
            self._stack(*spot)
        yield
        self._set_office()
        yield
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        if half > 8 and depth > 18:
            size = (6.0, 4.5, 4.2)
            colour = {"colour": "silver", "form": "flat"}
            at = (-self._side * (half - 3.2), min(0.45 * depth, depth - 11))
            self._shelter = ground.stand("canopy", *at, size, turn=INWARD, look=colour)
        yield
        for spot in spots[2:6]:
            self._stack(*spot)
            yield
        gate = (self._side * half / 2 - _GATE_M / 2, self._side * half / 2 + _GATE_M / 2)
        # The fence comes before the last stacks, because it shows the place's use.
        yield from enclose(ground, "mesh", 2.0, gate)
        for spot in spots[6:]:
            self._stack(*spot)
            yield

    def _spots(self) -> list[tuple[float, float, float]]:
        """Places and headings of stacks: a row at the back, half a row before it."""
        half, depth = self.ground.parcel.width / 2, self.ground.parcel.depth
        long = CONTAINER_M[0]
        back, reach = depth - 1.0 - long / 2, half - 1.0 - CONTAINER_M[1] / 2
        count = max(1, int(2 * reach / _PITCH_M) + 1)
        rows = [back]
        if back - long - _LANE_M - long / 2 > 9:
            rows.append(back - long - _LANE_M)
        spots: list[tuple[float, float, float]] = []
        for row, v in enumerate(rows):
            # The second row is half as long, so that trucks reach the first.
            usable = count if row == 0 else count // 2
            order = range(usable)
            # Stacks stand close together from one side on, and leave the other side open.
            spots += [(self._side * (reach - index * _PITCH_M), v, STREETWARD) for index in order]
        return spots[:9]

    def _stack(self, u: float, v: float, turn: float) -> None:
        ground, draw = self.ground, self.ground.draw
        top = set_container(ground, u, v, turn)
        for _ in range(draw.count(0, 2) if top else 0):
            top = stack_container(ground, top) if top and draw.chance(0.75) else top
        if top:
            self._stacks.append(top)

    def _set_office(self) -> None:
        """A container with a door by the gate, steps before it."""
        ground, half = self.ground, self.ground.parcel.width / 2
        look = {"colour": "white", "form": "office"}
        u = -self._side * (half - CONTAINER_M[0] / 2 - 0.8)
        self._office = ground.erect("container", u, 2.2, CONTAINER_M, turn=0.0, look=look)
        if self._office:
            ground.stand("deck", u, 4.7, (3.0, 1.8 * 2, 0.2), turn=0.0, margin=0.02)

    def details(self) -> Iterator[None]:
        """Grow trucks in the lane, pallets and crates, machines on the office, lights."""
        ground = self.ground
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        apron = (-half + 1.0, half - 1.0, 4.0, depth - 2.0)
        yield from interleave(
            self._drive(), range_goods(ground, OpenGround(ground), apron, 9), self._staff()
        )

    def _drive(self) -> Iterator[None]:
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        frame, bearing = ground.parcel.frame, OpenGround(ground)
        lane = depth - 1.5 - CONTAINER_M[0] - _LANE_M / 2
        park(bearing, "truck", frame, draw.between(-0.3, 0.3) * half, lane, draw.count(0, 1) * pi)
        yield
        gate_u = self._side * half / 2
        park(bearing, draw.one_of(("truck", "van")), frame, gate_u, 5.5, INWARD)
        yield
        if self._shelter:
            under = beneath(ground, self._shelter)
            for v in (-1.1, 1.1):
                pallet_row(under, self._shelter.frame, 0.0, v, 3)
                yield
        park(bearing, "van", frame, -gate_u, 6.4, 0.0)
        yield

    def _staff(self) -> Iterator[None]:
        """Cooling on the office, bins, lamps at the corners, a tank, a sign at the gate."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        if self._office:
            office = on_top(ground, self._office)
            office.stand("ac_unit", self._office.frame.moved(1.8, 0.0), (0.9, 1.0, 0.8))
            office.stand("solar_panel", self._office.frame.moved(-1.8, 0.0), (1.2, 1.8, 0.5))
            yield
            beside = OpenGround(ground)
            reach = self._office.size[1] / 2 + 0.7
            beside.stand("bench", self._office.frame.moved(-1.8, reach, QUARTER), (0.5, 1.6, 0.85))
            beside.stand("bin", self._office.frame.moved(2.4, reach), (0.7, 0.9, 1.1))
            yield
        ground.stand("sign", self._side * half / 2 + 4.0, 0.8, (0.1, 1.4, 2.6))
        for sign in (-1, 1):
            at = sign * (half - 0.9)
            ground.stand(
                "street_lamp", at, 0.35 * depth, (1.6, 0.5, 6.5), turn=sign * QUARTER + QUARTER
            )
        yield
        size = draw.size_of("water_tank")
        ground.stand("water_tank", -self._side * (half - 2.2), depth - 2.4, size)
        yield
        # The topmost containers are the only ones with a free upper face.
        for top in self._stacks[:3]:
            draw_size = (0.6, 0.6, 0.5)
            on_top(ground, top).stand("crate", top.frame.moved(draw.between(-2, 2), 0.0), draw_size)
        yield
        names = ("pallet", "bin", "crate", "bicycle")
        yield from fill_up(ground, names, (-half, half, 1.0, depth), 9)
