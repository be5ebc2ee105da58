"""A building site: walls that rise from a slab, a scaffold, heaps, cabins, stacked material."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER
from aeroscene.corpus.curation.places.boundary import enclose
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.goods import (
    crate_stack,
    pallet_row,
    plastic_crates,
    range_goods,
    set_container,
    stack_container,
)
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import park
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, beneath, on_top

_WALL_M = (0.25, 2.9)
"""Thickness and height of a wall of the first storey."""
_SLAB_M = 0.3
_DOOR_M = 2.4
"""Width of the openings that wait for doors and windows."""
_CABIN_M = (6.06, 2.44, 2.59)


@dataclass(slots=True)
class Construction:
    """Gravel with the shell of a ground floor, open to the sky."""

    ground: Ground
    _slab: Placed | None = None
    _scaffold: Placed | None = None
    _cabin: Placed | None = None
    _upper_cabin: Placed | None = None
    _heap: Placed | None = None
    _side: int = 1

    def structures(self) -> Iterator[None]:
        """Grow slab and walls; then cabins, a heap of earth, a scaffold, the fence."""
        ground, draw = self.ground, self.ground.draw
        gravel = {"rows": 0, "form": "bays"}
        ground.cover("parking_lot", gravel)
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        self._side = side = 1 if draw.chance(0.5) else -1
        self._pour_slab()
        # Two walls at once, so that the building is recognisable after the first step.
        for wall in range(2):
            self._wall_up(wall)
        yield
        u = -side * (half - _CABIN_M[0] / 2 - 0.9)
        self._cabin = set_container(ground, u, 2.4, 0.0)
        yield
        self._tip_heap()
        yield
        self._wall_up(2)
        yield
        self._raise_scaffold()
        yield
        if self._cabin:
            self._upper_cabin = stack_container(ground, self._cabin)
            yield
        self._wall_up(3)
        yield
        gate = (side * 0.45 * half - 3.5, side * 0.45 * half + 3.5)
        yield from enclose(ground, "boards", 1.9, gate)
        set_container(ground, side * (half - 2.2), depth - 4.2, INWARD)
        yield

    def _pour_slab(self) -> None:
        """The slab at the back, where trucks can reach its front."""
        ground = self.ground
        width, depth = ground.parcel.width, ground.parcel.depth
        deep = round(max(5.0, min(13.0, depth - 9.0)), 2)
        length = round(max(5.0, min(14.0, width - 5.5)), 2)
        # Off the middle, so that trucks pass the slab on the other side.
        u = self._side * max(0.0, (width - length) / 2 - 4.8)
        concrete = {"form": "terrace", "finish": "concrete"}
        v = depth - deep / 2 - 1.2
        size = (deep, length, _SLAB_M)
        self._slab = ground.erect("terrain", -u, v, size, turn=-INWARD, look=concrete)

    def _wall_up(self, index: int) -> None:
        """One of four walls on the slab, with an opening in its middle."""
        slab = self._slab
        if slab is None:
            return
        thick, height = _WALL_M
        x, y, _ = slab.size
        # Back, left, right and a wall across the middle: the front stays open.
        places = (
            (-x / 2 + 0.3, 0.0, 0.0),
            (0.0, y / 2 - 0.3, 1),
            (0.0, 0.3 - y / 2, 1),
            (0.8, 0.0, 0),
        )
        u, v, turned = places[index]
        long = x - 1.0 if turned else y - 1.4
        # Doors in the middle of the walls are openings that a drone can pass.
        look = {"door_m": _DOOR_M, "door_height_m": 2.5, "colour": "slate"}
        spot = slab.frame.moved(u + (0.15 if turned else 0.0), v, QUARTER if turned else 0.0)
        size = (thick, round(long, 2), height)
        on_top(self.ground, slab).stand("wall", spot, size, margin=0.0, look=look)

    def _tip_heap(self) -> None:
        """Excavated earth."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        # The heap shrinks with the parcel, and is a sixth as high as wide.
        side = min(7.0, 0.3 * depth)
        size = (round(side, 2), round(0.9 * side, 2), round(0.16 * side, 2))
        earth = {"form": "mound", "finish": "gravel"}
        # The heap goes beside the slab, or else before it.
        for at in ((self._side * (half - side / 2 - 1.0), 0.62 * depth), (0.0, 0.3 * depth)):
            self._heap = ground.stand("terrain", *at, size, turn=draw.between(0, 3), look=earth)
            if self._heap:
                return

    def _raise_scaffold(self) -> None:
        """A working platform on posts along the slab's flank."""
        ground, slab = self.ground, self._slab
        if slab is None:
            return
        form = {"colour": "yellow", "form": "flat"}
        size = (2.0, min(8.0, round(slab.size[0] - 1.0, 2)), 3.2)
        bearing = OpenGround(ground)
        # Either flank of the slab will do.
        for sign in (1, -1):
            v = sign * (slab.size[1] / 2 + size[0] / 2 + 0.15)
            spot = slab.frame.moved(0.0, v, sign * QUARTER)
            self._scaffold = bearing.stand("canopy", spot, size, margin=0.0, look=form)
            if self._scaffold:
                return

    def details(self) -> Iterator[None]:
        """Grow material on the slab and around it, a truck, cabins with their machines."""
        ground = self.ground
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        floor = (-half + 1.0, half - 1.0, 4.5, depth - 1.0)
        bearing = OpenGround(ground)
        yield from interleave(
            self._build(), self._drive(), self._staff(), range_goods(ground, bearing, floor, 8)
        )

    def _build(self) -> Iterator[None]:
        """Bricks and crates on the slab and on the scaffold."""
        ground, draw, slab = self.ground, self.ground.draw, self._slab
        if slab is None:
            return
        platform = on_top(ground, slab)
        x, y, _ = slab.size
        pallet_row(platform, slab.frame.moved(0, 0, QUARTER), -0.2 * y, -0.32 * x, 2)
        yield
        crate_stack(platform, slab.frame, -0.22 * x, -0.25 * y)
        yield
        if self._scaffold:
            top = on_top(ground, self._scaffold)
            for at in (-0.3, 0.3):
                size = (0.8, 0.8, 0.7)
                spot = self._scaffold.frame.moved(0.2, at * self._scaffold.size[1])
                top.stand("crate", spot, size)
            pallet_row(beneath(ground, self._scaffold), self._scaffold.frame, 0.0, 0.0, 1)
            yield
        plastic_crates(platform, slab.frame, -0.3 * x, 0.2 * y, 3)
        yield
        pallet_row(platform, slab.frame.moved(0, 0, QUARTER), 0.15 * y, -0.3 * x, draw.count(1, 2))
        yield

    def _drive(self) -> Iterator[None]:
        """A truck behind the gate, a van at the cabin."""
        ground, draw = self.ground, self.ground.draw
        half, frame = ground.parcel.width / 2, ground.parcel.frame
        bearing = OpenGround(ground)
        turn = INWARD if draw.chance(0.5) else -INWARD
        park(bearing, "truck", frame, self._side * 0.45 * half, 5.4, turn)
        yield
        park(bearing, "van", frame, -self._side * 0.2 * half, 5.8, 0.0)
        yield
        park(bearing, "truck", frame, self._side * 0.1 * half, 0.42 * ground.parcel.depth, pi)
        yield

    def _staff(self) -> Iterator[None]:
        """Cooling and mast on the cabins, a table before them, a tank, lamps, signs."""
        ground = self.ground
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        bearing = OpenGround(ground)
        ground.stand("sign", self._side * 0.45 * half + 4.2, 0.9, (0.1, 2.0, 2.8))
        ground.stand("bin", -self._side * 0.3 * half, 1.2, (0.9, 1.3, 1.2))
        yield
        roof = self._upper_cabin or self._cabin
        if roof:
            on_top(ground, roof).stand("ac_unit", roof.frame.moved(1.8, 0.0), (0.9, 1.0, 0.8))
            on_top(ground, roof).stand("solar_panel", roof.frame.moved(-1.8, 0.0), (1.2, 1.8, 0.5))
            yield
        if self._cabin:
            at = self._cabin.size[1] / 2 + 1.3
            spot = self._cabin.frame.moved(-1.6, at, QUARTER)
            table = bearing.stand("table", spot, (0.8, 1.6, 0.74))
            if table:
                bearing.stand("bench", table.frame.moved(0.75, 0.0, pi), (0.45, 1.6, 0.8))
            yield
        for sign in (-1, 1):
            turn = pi if sign > 0 else 0.0
            size = (1.6, 0.5, 7.0)
            ground.stand("street_lamp", sign * (half - 0.9), 0.7 * depth, size, turn=turn)
        yield
        ground.scatter("water_tank", 1, near=(-half, half, 3.0, depth), turn=0.0)
        yield
        names = ("pallet", "crate", "bin", "bicycle")
        yield from fill_up(ground, names, (-half, half, 1.0, depth), 9)
