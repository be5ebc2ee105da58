"""Furniture and vehicles of streets: bus stops, footbridges, traffic, lamps, trees, benches."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import pi, sin

from aeroscene.corpus.curation.builder import Attributes, Builder, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import QUARTER, STREETWARD, Frame
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.site import Road, Site
from aeroscene.corpus.curation.traffic import call_bus, drive, park, wait

_LAMP_STEP_M = 20.0
_KERB_M = 0.45
"""Distance of posts from the kerb."""
_BRIDGE_Z = (5.1, 4.0)
"""Height of a footbridge with its railings, and of its deck, m."""
_FLIGHT_M = (6.0, 1.2)
"""Length and width of a footbridge's stairs."""


@dataclass(slots=True)
class Streets:
    """Furniture and vehicles of all streets of a site."""

    builder: Builder
    draw: Draw
    site: Site
    bridge_chance: float = 0.2
    _stops: list[tuple[Placed, Placed]] = field(default_factory=list)

    def structures(self) -> Iterator[None]:
        """Grow a footbridge and shelters at bus stops; carriageways and sidewalks are there."""
        # A shorter road has no room for the bridge's stairs.
        roads = [road for road in self.site.roads if road.placed.size[0] > 30]
        if roads and self.draw.chance(self.bridge_chance):
            self._bridge(roads[0])
        yield
        for walk in self.site.sidewalks:
            if walk.size[0] > 20 and walk.size[1] >= 2.2 and self.draw.chance(0.3):
                self._shelter(walk)
                yield

    def _bridge(self, road: Road) -> None:
        """A footbridge from sidewalk to sidewalk with a flight of stairs at each end."""
        placed, walk_m = road.placed, self.site.walk_m
        # Off the middle, where streets meet.
        u = (1 if self.draw.chance(0.5) else -1) * self.draw.between(0.4, 0.6) * placed.size[0] / 2
        end = min(_FLIGHT_M[1], walk_m - 0.5)
        reach = placed.size[1] / 2 + end
        # Both ends must stand on sidewalks.
        walks = [self._walk_at(placed.frame.point(u, sign * (reach - end / 2))) for sign in (-1, 1)]
        base = placed.base + 0.15
        size = (2 * reach, 2.4, _BRIDGE_Z[0])
        beam = {"form": "beam"}
        if None in walks or not self.builder.place(
            "bridge", placed.frame.moved(u, 0, QUARTER), size, base=base, margin=0.1, look=beam
        ):
            return
        for sign, walk in zip((-1, 1), walks, strict=True):
            length, width = _FLIGHT_M
            away = 1 if self.draw.chance(0.5) else -1
            spot = placed.frame.moved(
                u + away * (1.2 + length / 2), sign * (reach - end / 2), pi if away > 0 else 0.0
            )
            self.builder.place(
                "stairs", spot, (length, min(width, end), _BRIDGE_Z[1]), base=base, parent=walk
            )

    def _walk_at(self, point: tuple[float, float]) -> Placed | None:
        for walk in self.site.sidewalks:
            u, v = walk.frame.local(*point)
            if abs(u) < walk.size[0] / 2 and abs(v) < walk.size[1] / 2:
                return walk
        return None

    def _shelter(self, walk: Placed) -> None:
        """A roof over the people who wait for a bus."""
        u = self.draw.between(-0.3, 0.3) * walk.size[0]
        colour = {"colour": self.draw.one_of(("blue", "green", "red"))}
        size = (1.5, self.draw.between(3.2, 4.4), 2.7)
        spot = walk.frame.moved(u, walk.size[1] / 2 - 0.76, STREETWARD)
        shelter = self.builder.place(
            "canopy", spot, size, parent=walk, within=walk, margin=0.2, look=colour
        )
        if shelter:
            self._stops.append((walk, shelter))

    def details(self) -> Iterator[None]:
        """Grow signals, then in turn traffic, lamps and other objects on the sidewalks."""
        for junction in self.site.junctions:
            self._signal(junction)
            yield
        growths = [self._wait_at_stops()]
        for road in self.site.roads:
            growths += [grow(self.builder, self.draw, road) for grow in (wait, drive, park)]
        growths += [self._light(walk) for walk in self.site.sidewalks]
        growths += [self._plant(verge) for verge in self.site.verges]
        growths += [self._furnish(walk) for walk in self.site.sidewalks]
        # In any order, so that a scene that fills up early does not lack the same kind every time.
        yield from interleave(
            *(growths[index] for index in self.draw.shuffled(range(len(growths))))
        )

    def _wait_at_stops(self) -> Iterator[None]:
        """A bench in each shelter, a sign beside it, a bus at the kerb now and then."""
        for walk, shelter in self._stops:
            u, v = walk.frame.local(shelter.frame.x, shelter.frame.y)
            self._stand(walk, "bench", u, v + 0.3)
            self._stand(walk, "sign", u + shelter.size[1] / 2 + 0.6, -walk.size[1] / 2 + _KERB_M)
            yield
            road = self._road_beside(walk, u)
            if road and self.draw.chance(0.5):
                at = road.placed.frame.local(*walk.frame.point(u, -walk.size[1] / 2))
                call_bus(self.builder, self.draw, road, at[0], 1 if at[1] > 0 else -1)
                yield

    def _road_beside(self, walk: Placed, u: float) -> Road | None:
        # A metre before the kerb, on the carriageway.
        x, y = walk.frame.point(u, -walk.size[1] / 2 - 1.0)
        for road in self.site.roads:
            along, across = road.placed.frame.local(x, y)
            length, width, _ = road.placed.size
            if abs(along) < length / 2 and abs(across) < width / 2:
                return road
        return None

    def _light(self, walk: Placed) -> Iterator[None]:
        """Lamps in a row, in random order so that a sparse scene has some everywhere."""
        length, width, _ = walk.size
        count = max(1, round(length / _LAMP_STEP_M))
        height = self.draw.between(5.0, 6.5)
        for index in self.draw.shuffled(range(count)):
            u = -length / 2 + (index + 0.5) * length / count
            spot = walk.frame.moved(u, -width / 2 + 0.15, STREETWARD)
            self.builder.place("street_lamp", spot, (1.2, 0.4, height), parent=walk)
            yield

    def _plant(self, verge: Placed) -> Iterator[None]:
        """A row of trees with bushes between them."""
        length, width, _ = verge.size
        form = self.draw.one_of(("round", "conical", "spreading"))
        count = max(1, int(length // 7.5))
        for index in range(count):
            u = -length / 2 + (index + 0.5) * length / count
            crown = round(min(width - 0.1, self.draw.between(1.9, 2.4)), 2)
            size = (crown, crown, self.draw.between(4.5, 6.5))
            self._stand(verge, "tree", u, 0.0, size, {"form": form})
            yield
            # Halfway between two trees.
            self._stand(verge, "bush", u + length / count / 2, 0.0, (0.9, 1.4, 0.8))
            yield

    def _furnish(self, walk: Placed) -> Iterator[None]:
        """Benches at the back; bins, signs, planters and bicycles at the kerb."""
        length, width, _ = walk.size
        kerb, back = -width / 2 + _KERB_M, width / 2 - 0.5
        for _ in range(max(1, int(length // 9))):
            u = self.draw.between(-0.46, 0.46) * length
            name = self.draw.one_of(("bench", "bin", "sign", "planter", "bicycle", "bin", "bench"))
            match name:
                case "bench":
                    self._stand(walk, name, u, back, None)
                case "planter":
                    self._stand(walk, name, u, kerb + 0.1, (0.6, 1.4, 0.9))
                case "bicycle":
                    self._stand(walk, name, u, back, (1.75, 0.5, 1.05), turn=0.0)
                case _:
                    self._stand(walk, name, u, kerb + 0.1)
            yield

    def _stand(
        self,
        strip: Placed,
        name: str,
        u: float,
        v: float,
        size: tuple[float, float, float] | None = None,
        look: Attributes | None = None,
        turn: float = STREETWARD,
    ) -> Placed | None:
        spot, size = strip.frame.moved(u, v, turn), size or self.draw.size_of(name)
        return self.builder.place(
            name, spot, size, parent=strip, within=strip, margin=0.05, look=look
        )

    def _signal(self, junction: Frame) -> None:
        """Traffic lights on the sidewalk corners around a crossing."""
        # Every light of a crossing has one height.
        height = self.draw.between(3.0, 3.8)
        for walk in self.site.sidewalks:
            if abs(sin(walk.frame.yaw - junction.yaw)) > 0.5:
                continue  # One light a corner, on the sidewalk of the through road.
            u, v = walk.frame.local(junction.x, junction.y)
            reach = self.site.road_m / 2 + self.site.walk_m
            if abs(v) > reach + 1 or abs(u) > walk.size[0] / 2 + reach:
                continue
            end = walk.size[0] / 2 - 0.5
            at = max(-end, min(end, u))
            spot = walk.frame.moved(at, -walk.size[1] / 2 + 0.4, pi if u > at else 0.0)
            self.builder.place("traffic_light", spot, (0.35, 0.4, height), parent=walk)
