"""A depot: a warehouse with a loading dock, trucks backed up to it, a gatehouse and a fence."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.corpus.curation.places.boundary import enclose
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.furnished_buildings import furnish, raise_hall
from aeroscene.corpus.curation.places.goods import (
    crate_stack,
    paint,
    pallet_row,
    plastic_crates,
    range_goods,
    set_container,
)
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import park
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, on_top
from aeroscene.corpus.curation.shells import RoomSpace

_DOCK_M = (2.4, 1.0)
"""Depth and height of a loading dock."""
_STEPS_M = 1.6
_APRON_M = 11.0
"""Depth of the yard before the dock, for trucks to turn."""
_GATE_HALF_M = 4.0
"""Half of the fence's gate to the street."""


@dataclass(slots=True)
class Depot:
    """A warehouse at the back of a yard; if it is furnished, it is open at both ends."""

    ground: Ground
    is_furnished: bool = False
    _hall: Placed | None = None
    _dock: Placed | None = None
    _gatehouse: Placed | None = None
    _boxes: list[Placed] = field(default_factory=list)
    _rooms: tuple[RoomSpace, ...] = ()
    _gate_u: float = 0.0

    def structures(self) -> Iterator[None]:
        """Grow the hall; then its dock, the gatehouse, swap bodies, the fence."""
        ground, draw = self.ground, self.ground.draw
        look = {"rows": 0, "form": "bays"}
        ground.cover("parking_lot", look)
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        side = 1 if draw.chance(0.5) else -1
        # The gate lies off the middle, opposite the hall.
        self._gate_u = side * max(0.0, half - 7.0)
        # The hall stands at the side opposite the gate.
        self._raise_hall(-side)
        yield
        if self._hall and not self.is_furnished:
            self._lay_dock(self._hall)
        yield
        kiosk = (2.4, 2.8, 2.8)
        u = self._gate_u - side * (_GATE_HALF_M + 2.0)
        self._gatehouse = ground.stand("kiosk", u, 2.2, kiosk, turn=0.0, look=paint(draw))
        yield
        for index in range(2):
            v = depth - 4.5 - 7.5 * index
            box = set_container(ground, side * (half - 2.0), v, STREETWARD)
            self._boxes += [box] if box else []
            yield
        gate = (self._gate_u - _GATE_HALF_M, self._gate_u + _GATE_HALF_M)
        yield from enclose(ground, "mesh", 2.0, gate)

    def _raise_hall(self, side: int) -> None:
        """Raise the hall, as deep and long as the yard before it and a lane beside it allow."""
        ground, draw = self.ground, self.ground.draw
        width, depth = ground.parcel.width, ground.parcel.depth
        apron = min(_APRON_M, 0.42 * depth)
        # A furnished hall has gates instead of a dock.
        dock = 0.0 if self.is_furnished else _DOCK_M[0]
        deep = round(min(18.0, max(7.5, depth - apron - dock - 1.2)), 2)
        length = round(min(26.0, width - 3.0 if width < 18 else width - 7.0), 2)
        size = (deep, length, draw.between(5.6, 7.2))
        u = side * (width / 2 - length / 2 - 0.9)
        v = depth - deep / 2 - 0.9
        if not self.is_furnished:
            self._hall = ground.erect("warehouse", u, v, size, look=paint(draw))
            return
        shell = raise_hall(ground, u, v, size, paint(draw))
        if shell:
            self._hall, self._rooms = shell.building, shell.rooms

    def _lay_dock(self, hall: Placed) -> None:
        """A platform along the hall's front with steps at one end."""
        deep, height = _DOCK_M
        bearing = OpenGround(self.ground)
        length = min(14.0, round(hall.size[1] - 2 * _STEPS_M, 2))
        # Clear of the hall's front by 2 cm, more than a touch.
        u = hall.size[0] / 2 + deep / 2 + 0.02
        size = (deep, length, height)
        self._dock = bearing.stand("deck", hall.frame.moved(u, 0.0), size, margin=0.0)
        if self._dock:
            at = length / 2 + _STEPS_M / 2
            steps = (_STEPS_M, 1.4, height)
            bearing.stand("stairs", self._dock.frame.moved(0.0, at, -QUARTER), steps, margin=0.0)

    def details(self) -> Iterator[None]:
        """Grow trucks at the dock, goods, the stock inside, cars and lamps."""
        ground = self.ground
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        apron = (-half + 1.0, half - 1.0, 1.5, 0.45 * depth)
        stock = iter(())
        if self._rooms:
            stock = furnish(ground, self._rooms, (ground.draw.one_of(("racks", "goods")),))
        bearing = OpenGround(ground)
        yield from interleave(
            self._load(), stock, self._attend(), range_goods(ground, bearing, apron, 8)
        )

    def _load(self) -> Iterator[None]:
        """Trucks with their backs to the dock, pallets and crates on it."""
        ground, draw = self.ground, self.ground.draw
        bearing = OpenGround(ground)
        if self._dock is None:
            u = self._gate_u
            turn = INWARD if draw.chance(0.5) else -INWARD
            park(bearing, "truck", ground.parcel.frame, u, 6.0, turn)
            yield
            return
        dock, platform = self._dock, on_top(ground, self._dock)
        # A slot is a truck's width and a passage.
        slots = max(1, int(dock.size[1] / 4.2))
        places = [(index - (slots - 1) / 2) * 4.2 for index in range(slots)]
        for index in draw.shuffled(range(slots)):
            length = draw.between(6.4, 8.0)
            # The lorry's rear is a quarter of a metre from the dock.
            u = dock.size[0] / 2 + 0.25 + length / 2
            spot = dock.frame.moved(u, places[index])
            bearing.stand("truck", spot, (length, 2.45, 3.4), look=paint(draw))
            pallet_row(platform, dock.frame.moved(0, 0, QUARTER), places[index] + 1.2, 0.3, 1)
            yield
        for index in draw.shuffled(range(slots)):
            crate_stack(platform, dock.frame.moved(-0.55, places[index] - 1.0, QUARTER), 0.0, 0.0)
            yield

    def _attend(self) -> Iterator[None]:
        """Staff cars along the fence, a bench at the gatehouse, lamps, a tank, bins."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        bearing = OpenGround(ground)
        ground.stand("sign", self._gate_u + _GATE_HALF_M + 0.6, 0.9, (0.1, 1.2, 2.6))
        for sign in (-1, 1):
            at = sign * (half - 0.8)
            turn = pi if sign > 0 else 0.0
            ground.stand("street_lamp", at, 0.3 * depth, (1.6, 0.5, 6.5), turn=turn)
        yield
        for _ in range(2):
            u = draw.between(-0.8, 0.8) * half
            park(bearing, "car", ground.parcel.frame, u, 3.0, INWARD)
            yield
        if self._gatehouse:
            house = self._gatehouse
            bearing.stand("bin", house.frame.moved(0.0, house.size[1] / 2 + 0.5), (0.5, 0.5, 0.9))
            spot = house.frame.moved(0.0, -house.size[1] / 2 - 0.6)
            bearing.stand("bicycle", spot, (1.75, 0.55, 1.05))
            yield
        plastic_crates(bearing, ground.parcel.frame, draw.between(-0.6, 0.4) * half, 0.4 * depth, 4)
        yield
        for index, box in enumerate(self._boxes):
            at = box.size[0] / 2 + 0.9
            pallet_row(bearing, box.frame.moved(at, 0, QUARTER), 0.0, 0.0, 1 + index)
            yield
        ground.scatter("water_tank", 1, near=(-half, half, 0.2 * depth, depth), turn=0.0)
        yield
        names = ("pallet", "bin", "crate", "bicycle")
        yield from fill_up(ground, names, (-half, half, 0.8, depth), 9)
