"""A furnished tower: storeys that repeat one floor plan, each furnished anew.

Repeating the plan keeps walls above walls, as in real buildings.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import STREETWARD
from aeroscene.corpus.curation.indoor.partitions import raise_walls
from aeroscene.corpus.curation.indoor.room_placement import lay_room
from aeroscene.corpus.curation.indoor.themes import FINISHES
from aeroscene.corpus.curation.indoor.walls import insets
from aeroscene.corpus.curation.indoor.zones import choose_doors, find_borders
from aeroscene.corpus.curation.places.furnished_buildings import furnish
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.rooftops import add_flat_roof, furnish_flat_roof
from aeroscene.corpus.curation.room_space import RoomSpace
from aeroscene.corpus.curation.shells import STOREY_M
from aeroscene.corpus.curation.storeys import plan_storey
from aeroscene.solids.shapes.facade import (
    LINTEL_M,
    SILL_M,
    SLAB_M,
    SLAB_TOP_M,
    WALL_M,
    FacadePlan,
    count_bays,
    opening_width,
)
from aeroscene.solids.shapes.materials import WALL_COLOURS

LEAST_M = (15.0, 17.0)
"""Width and depth of the least parcel for a tower."""
_PROGRAMMES = (
    ("living", "kitchen", "bedroom", "bathroom", "bedroom"),
    ("office", "meeting", "office", "washroom", "office", "store"),
)
"""Kinds of rooms of a storey: flats or offices."""
_SIZE_M = (9.0, 12.6)
"""Depth and length of the tower."""
_BEARING_M = 0.1
"""Depth by which an upper slab extends into the walls that carry it."""
_APRON_M = 1.3
"""Depth of the air kept free on either side of an opening."""


@dataclass(slots=True)
class FurnishedTower:
    """A tower that a drone can enter on every storey, as a place of a district."""

    ground: Ground
    n_storeys: int
    _tower: Placed | None = None
    _roof: Placed | None = None
    _rooms: list[RoomSpace] = field(default_factory=list)

    def structures(self) -> Iterator[None]:
        """Grow the shell with slabs, rooms and walls, and its roof; then a hedge behind it."""
        ground, draw = self.ground, self.ground.draw
        ground.cover("plaza")
        deep, length = _SIZE_M
        # A short way before the door, unless the parcel is too shallow for it.
        setback = min(3.5, ground.parcel.depth - deep - 1.0)
        look = {
            "is_enterable": True,
            "storeys": self.n_storeys,
            "colour": draw.one_of(WALL_COLOURS),
        }
        size = (deep, length, round(self.n_storeys * STOREY_M, 3))
        self._tower = ground.erect("building", 0.0, setback + deep / 2, size, look=look)
        if self._tower:
            self._fit_out(self._tower)
            self._roof = add_flat_roof(ground.builder, self._tower)
        yield
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        ground.fence_line((-half + 0.4, depth - 0.3), (half - 0.4, depth - 0.3), "hedge", 1.3)
        yield

    def _fit_out(self, tower: Placed) -> None:
        """Fit out every storey with the same rooms: the plan is redrawn from one number."""
        draw, kinds = self.ground.draw, _PROGRAMMES[self.ground.draw.count(0, 1)]
        seed = draw.count(0, 2**31)
        for storey in range(self.n_storeys):
            foot = tower.base + storey * STOREY_M
            self._lay_slab(tower, foot, is_upper=storey > 0)
            is_top = storey == self.n_storeys - 1
            # A storey ends at the underside of the next slab; the last one ends at the roof.
            ceiling = STOREY_M if is_top else STOREY_M + SLAB_TOP_M - SLAB_M
            level, clear = round(foot + SLAB_TOP_M, 4), round(ceiling - SLAB_TOP_M, 4)
            # The same seed on each storey repeats the plan; only the furniture draws from another
            # stream.
            again = Draw(np.random.default_rng(seed))
            zones = plan_storey(again, tower.size[:2], deque(kinds), level, clear)
            borders = find_borders(zones)
            builder = self.ground.builder
            for zone, margin in zip(zones, insets(zones, borders), strict=True):
                finish = again.one_of(FINISHES.get(zone.kind, ("floor_tiles",)))
                room = lay_room(builder, tower, zone, margin, finish)
                self._rooms += [room] if room else []
            raise_walls(builder, again, tower, zones, borders, choose_doors(zones, borders))
            self._keep_openings_free(tower, storey)

    def _lay_slab(self, tower: Placed, foot: float, *, is_upper: bool) -> None:
        """Lay a storey's floor; an upper one hangs lower and extends into the walls."""
        # A slab between two storeys rests in the walls; the lowest one ends at their inner faces.
        under = SLAB_TOP_M - SLAB_M if is_upper else 0.0
        reach = 2 * (_BEARING_M * is_upper - WALL_M)
        size = (tower.size[0] + reach, tower.size[1] + reach, SLAB_TOP_M - under)
        self.ground.builder.place(
            "floor", tower.frame, size, base=foot + under, parent=tower, domain="indoor"
        )

    def _keep_openings_free(self, tower: Placed, storey: int) -> None:
        """Reserve the air before and behind each window and door, so that a drone can pass."""
        depth, length, _ = tower.size
        door_bay = count_bays(length) // 2
        plan = FacadePlan(length, self.n_storeys, STOREY_M, door_bay, "open")
        foot = tower.base + storey * STOREY_M
        for bay in range(plan.n_bays):
            low, high = plan.opening(bay)
            for sign in (-1, 1):
                # The door is on the front, in the middle; every other opening is a window.
                is_door = sign > 0 and storey == 0 and bay == door_bay
                sill = SLAB_TOP_M + 0.03 if is_door else SILL_M + 0.05
                size = (2 * _APRON_M, opening_width(length), LINTEL_M - sill)
                spot = tower.frame.moved(sign * (depth / 2 - WALL_M / 2), (low + high) / 2)
                self.ground.builder.reserve(spot, size, foot + sill)

    def details(self) -> Iterator[None]:
        """Grow furniture of all rooms, machines on the roof, and a forecourt."""
        ground, draw = self.ground, self.ground.draw
        growths = [furnish(ground, self._rooms)]
        if self._roof:
            growths.append(furnish_flat_roof(ground.builder, draw, self._roof))
        growths.append(self._forecourt())
        yield from interleave(*growths)

    def _forecourt(self) -> Iterator[None]:
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        for side in (-1, 1):
            ground.stand("bench", side * 0.6 * half, 1.2, turn=-STREETWARD)
            ground.scatter("planter", 1, near=(-half, half, 0.4, 3.0), turn=0.0)
            yield
            ground.plant_trees(1, (-half, half, 0.7 * depth, depth))
            ground.scatter("bush", draw.count(1, 2), near=(-half, half, 0.7 * depth, depth))
            yield
