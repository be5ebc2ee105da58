"""The single place of an indoor scene: its features, its furniture, and the start of a flight."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import cycle, islice

from aeroscene.corpus.curation.builder import Builder, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.indoor.building import PAD_RISE_M
from aeroscene.corpus.curation.indoor.features import FEATURES, suits
from aeroscene.corpus.curation.indoor.floor_plan import Building
from aeroscene.corpus.curation.indoor.plans import clear_end_m
from aeroscene.corpus.curation.indoor.zones import Zone
from aeroscene.corpus.curation.interiors import FURNISHINGS, Interior
from aeroscene.corpus.curation.rooms.extras import furnish_rest
from aeroscene.corpus.curation.rooms.uses import USES
from aeroscene.corpus.curation.start import PAD_M, NoStartError

_PAD_M = (1.8, 1.8, 0.06)
"""Size of the pads in halls and on galleries."""
_WITH_PADS = frozenset(("lobby", "concourse", "court", "gym", "garden", "goods", "stand", "lounge"))
"""Kinds of halls in which drones come and go besides the start."""
_ROUNDS = 7
"""Number of passes through the list of features."""
FEATURED_M2 = 48.0
"""Least area of a zone in which coarse structures stand."""


@dataclass(slots=True)
class IndoorPlace:
    """The inside of a building."""

    builder: Builder
    draw: Draw
    building: Building
    features: tuple[str, ...]
    _interiors: list[Interior] = field(default_factory=list)

    def place_start(self) -> Placed:
        """Put the home pad into the first hall.

        Raises:
            NoStartError: If the plan has left no space for it.
        """
        hall, base = self.building.spaces[0].placed, self.building.spaces[0].floor
        size, look = (PAD_M, PAD_M, PAD_RISE_M), {"is_start": True}
        pad = self.builder.place(
            "landing_pad", hall.frame, size, base=base, parent=hall, within=hall, look=look
        )
        if pad is None:
            raise NoStartError(f"{self.builder.scene_id}: no space for the home pad in the hall")
        return pad

    def structures(self) -> Iterator[None]:
        """Place coarse structures in wide zones, one a step, the most characteristic first."""
        pairs = list(zip(self.building.plan.zones, self._all(), strict=True))
        wide = [pair for pair in pairs if pair[0].area >= FEATURED_M2]
        # Halls before rooms.
        wide.sort(key=lambda pair: pair[0].role == "room")
        yield
        rooms = {
            name: [room for zone, room in wide if suits(name, zone.kind)] for name in self.features
        }
        for name in islice(cycle(self.features), _ROUNDS * len(self.features)):
            for _ in range(len(rooms[name])):
                # The next room in turn, so that structures spread over the building.
                rooms[name].append(rooms[name].pop(0))
                if FEATURES[name](rooms[name][-1]):
                    yield
                    break

    def details(self) -> Iterator[None]:
        """Place furniture where a zone has least for its use; pads in halls and on galleries."""
        zones = self.building.plan.zones
        growths = [
            _furnish(zone, interior) for zone, interior in zip(zones, self._all(), strict=True)
        ]
        shares = [zone.area * USES[zone.kind].per_100_m2 / 100 for zone in zones]
        filled = dict.fromkeys(range(len(zones)), 0.0)
        while filled:
            index = min(filled, key=lambda i: filled[i])
            before = self.builder.n_fine
            # A generator that has ended returns the default, here this object itself.
            if next(growths[index], self) is self:
                del filled[index]
                continue
            # A step that finds no space counts too, so that others come to their turn.
            filled[index] += max(0.5, self.builder.n_fine - before) / shares[index]
            yield

    def _all(self) -> list[Interior]:
        # Made once and kept, because both generators share what the rooms hold.
        if not self._interiors:
            self._interiors += [
                Interior(self.builder, self.draw, space, sides, clear_end_m(zone))
                for zone, space, sides in zip(
                    self.building.plan.zones,
                    self.building.spaces,
                    self.building.sides,
                    strict=True,
                )
            ]
        return self._interiors


def _furnish(zone: Zone, interior: Interior) -> Iterator[None]:
    """First the furniture that makes the kind, a pad where drones come and go, then the rest."""
    growth = FURNISHINGS[zone.kind](interior)
    yield from islice(growth, 1)
    if zone.kind in _WITH_PADS:
        interior.anywhere("landing_pad", _PAD_M, keep=0.6)
        yield
    yield from growth
    yield from furnish_rest(interior, zone.kind)
