"""A bus station: platforms with shelters, buses alongside, a kiosk, taxis, bicycles."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import QUARTER
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.goods import paint
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import park, rack_bicycles
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, beneath, on_top

_PLATFORM_M = (3.4, 0.16)
"""Width and height of a platform."""
_LANE_M = 4.0
_SHELTER_M = (2.4, 6.0, 3.1)


@dataclass(slots=True)
class Station:
    """Platforms along the street, lanes between them."""

    ground: Ground
    _platforms: list[Placed] = field(default_factory=list)
    _shelters: list[tuple[Placed, Placed]] = field(default_factory=list)
    """Each shelter with the platform that carries it."""
    _kiosk: Placed | None = None
    _green: Placed | None = None

    def structures(self) -> Iterator[None]:
        """Grow two platforms with a shelter each; then more shelters, a kiosk, a green strip."""
        ground, draw = self.ground, self.ground.draw
        asphalt = {"rows": 0, "form": "bays"}
        ground.cover("parking_lot", asphalt)
        spots = self._spots()
        for v in spots[:2]:
            self._lay_platform(v)
        for platform in self._platforms:
            self._raise_shelter(platform, -0.25)
        yield
        for v in spots[2:]:
            self._lay_platform(v)
            yield
        for platform in self._platforms:
            self._raise_shelter(platform, 0.27)
            yield
        if self._platforms:
            platform = self._platforms[-1]
            end = platform.size[0] / 2 - 2.2
            side = 1 if draw.chance(0.5) else -1
            spot = platform.frame.moved(side * end, 0.0, -QUARTER)
            size = (2.4, 3.0, 2.8)
            self._kiosk = on_top(ground, platform).stand("kiosk", spot, size, look=paint(draw))
            yield
        self._plant_strip(spots)
        yield

    def _spots(self) -> list[float]:
        """Middles of the platforms, v, with a lane before each."""
        depth = self.ground.parcel.depth
        # One lane before each platform and one behind it.
        pitch = _PLATFORM_M[0] + 2 * _LANE_M
        first = _LANE_M + _PLATFORM_M[0] / 2 + 0.4
        count = max(1, min(3, 1 + int((depth - first - _PLATFORM_M[0] / 2 - _LANE_M) / pitch)))
        return [first + index * pitch for index in range(count)]

    def _lay_platform(self, v: float) -> None:
        ground = self.ground
        long = round(ground.parcel.width - 5.0, 2)
        size = (long, *_PLATFORM_M)
        platform = ground.stand("sidewalk", 0.0, v, size, turn=0.0, margin=0.0)
        if platform:
            self._platforms.append(platform)

    def _raise_shelter(self, platform: Placed, share: float) -> None:
        """A roof along the platform."""
        ground = self.ground
        length = min(_SHELTER_M[1], round(0.4 * platform.size[0], 2))
        size = (_SHELTER_M[0], length, _SHELTER_M[2])
        colour = {"colour": "silver"}
        spot = platform.frame.moved(share * platform.size[0], 0.0, -QUARTER)
        shelter = on_top(ground, platform).stand("canopy", spot, size, margin=0.2, look=colour)
        if shelter:
            self._shelters.append((shelter, platform))

    def _plant_strip(self, spots: list[float]) -> None:
        """Green behind the last lane."""
        ground = self.ground
        start = spots[-1] + _PLATFORM_M[0] / 2 + _LANE_M
        deep = round(min(6.0, ground.parcel.depth - start - 0.2), 2)
        if deep < 2.0:
            return
        size = (round(ground.parcel.width - 0.6, 2), deep, 0.12)
        v = ground.parcel.depth - deep / 2 - 0.1
        self._green = ground.stand("lawn", 0.0, v, size, turn=0.0, margin=0.0)

    def details(self) -> Iterator[None]:
        """Grow buses in the lanes, people's things on the platforms, trees behind."""
        yield from interleave(self._drive(), self._wait(), self._surround())

    def _drive(self) -> Iterator[None]:
        """Buses alongside the platforms, all in the same direction on one side of each."""
        ground, draw = self.ground, self.ground.draw
        bearing = OpenGround(ground)
        for side in (-1, 1):
            for platform in self._platforms:
                length = min(draw.between(10.0, 12.0), round(0.8 * platform.size[0], 2))
                # Shorter platforms have no room for a bus.
                if length < 8.5:
                    # The bus is 2.55 m wide and keeps 0.4 m from the kerb.
                    continue
                room = (platform.size[0] - length) / 2
                at = draw.between(-0.8, 0.8) * max(0.0, room)
                v = side * (_PLATFORM_M[0] / 2 + 0.4 + 1.28)
                # Traffic keeps to the right: doors open towards the platform.
                turn = 0.0 if side > 0 else 2 * QUARTER
                size = (length, 2.55, 3.1)
                spot = platform.frame.moved(at, v, turn)
                bearing.stand("bus", spot, size, look=paint(draw))
                yield

    def _wait(self) -> Iterator[None]:
        """Benches under the roofs, signs and bins beside them, lamps on the platforms."""
        ground = self.ground
        for shelter, platform in self._shelters:
            under = beneath(ground, shelter)
            for sign in (-1, 1):
                at = sign * shelter.size[1] / 4
                under.stand("bench", shelter.frame.moved(-0.2, at), (0.6, 1.8, 0.85))
            yield
            deck = on_top(ground, platform)
            u, _ = platform.frame.local(shelter.frame.x, shelter.frame.y)
            beside = u + shelter.size[1] / 2 + 0.7
            deck.stand("sign", platform.frame.moved(beside, -1.2), (0.1, 0.6, 2.6))
            deck.stand("bin", platform.frame.moved(beside + 0.2, 0.2), (0.5, 0.5, 0.95))
            yield
        for platform in self._platforms:
            deck = on_top(ground, platform)
            for sign in (-1, 1):
                at = sign * (platform.size[0] / 2 - 0.8)
                deck.stand("street_lamp", platform.frame.moved(at, 0.0, QUARTER), (1.6, 0.5, 5.0))
            spot = platform.frame.moved(0.02 * platform.size[0], 0.0, QUARTER)
            deck.stand("planter", spot, (2.0 / 2, 2.2, 0.9))
            yield
        for platform in self._platforms:
            deck = on_top(ground, platform)
            for at in (-0.4, -0.08, 0.1, 0.42):
                spot = platform.frame.moved(at * platform.size[0], 0.9, -QUARTER)
                deck.stand("bench", spot, (0.55, 1.8, 0.85))
            yield

    def _surround(self) -> Iterator[None]:
        """Bicycles, taxis, trees on the green."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        bearing = OpenGround(ground)
        if self._green:
            strip, platform = self._green, on_top(ground, self._green)
            rack_bicycles(platform, strip.frame, -0.3 * strip.size[0], 0.0, 4)
            yield
            for index in range(4):
                at = (index / 3 - 0.4) * 0.9 * strip.size[0] * 0.6
                height = draw.between(4.5, 7.0)
                width = min(2.4, strip.size[1] - 0.2)
                platform.stand("tree", strip.frame.moved(at, 0.0), (width, width, height))
                platform.stand("bush", strip.frame.moved(at + 1.9, 0.0), (0.9, 0.9, 0.8))
                yield
        for index in range(3):
            park(bearing, "car", ground.parcel.frame, -0.6 * half + index * 6.0, 1.4, 0.0)
            yield
        for index in range(2):
            park(bearing, "car", ground.parcel.frame, 0.2 * half + index * 6.0, depth - 1.4, 0.0)
            yield
        names = ("planter", "bicycle", "bin", "bush", "planter")
        yield from fill_up(ground, names, (-half, half, 0.2, depth), 9)
