"""What stands and drives on streets: cars in lanes, lamps, lights, hydrants."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi, sin

from aeroscene.curation.builder import Builder, Placed
from aeroscene.curation.draw import Draw
from aeroscene.curation.frame import STREETWARD
from aeroscene.curation.site import Site
from aeroscene.shapes.materials import PAINT_COLOURS

_CURB_M = 0.45
"""Distance of posts from the curb."""


@dataclass(frozen=True, slots=True)
class Streets:
    """All streets of a site."""

    builder: Builder
    draw: Draw
    site: Site

    def structures(self) -> Iterator[None]:
        """Carriageways and sidewalks are laid with the site's plan."""
        yield

    def details(self) -> Iterator[None]:
        """Signals, then traffic, then street furniture."""
        for crossing in self.site.crossings:
            _signal(self.builder, self.draw, self.site, crossing.x, crossing.y)
        yield
        for road in self.site.roads:
            _drive(self.builder, self.draw, road)
            yield
        for walk in self.site.sidewalks:
            _furnish_sidewalk(self.builder, self.draw, walk)
            yield


def _drive(builder: Builder, draw: Draw, road: Placed) -> None:
    """Vehicles in both lanes, on the right-hand side."""
    length, width, _ = road.size
    slots = max(1, int(length // 11))
    for lane in (-1, 1):
        for slot in range(slots):
            if not draw.chance(0.27):
                continue
            u = -length / 2 + (slot + 0.5) * length / slots + draw.between(-1, 1)
            name = "car"
            if draw.chance(0.15):
                name = draw.one_of(("van", "bus", "truck"))
            size = draw.size_of(name, 0.3)
            builder.place(
                name,
                road.frame,
                u,
                lane * width / 4,
                size,
                base=road.top,
                turn=0.0 if lane < 0 else pi,
                parent=road,
                within=road,
                margin=0.5,
                attributes={"colour": draw.one_of(PAINT_COLOURS)},
            )


def _furnish_sidewalk(builder: Builder, draw: Draw, walk: Placed) -> None:
    """Lamps in a row; between them bins, benches, signs."""
    length, width, _ = walk.size
    curb = -width / 2 + _CURB_M
    lamps = max(1, round(length / 22))
    height = draw.between(5.0, 6.5)
    for index in range(lamps):
        u = -length / 2 + (index + 0.5) * length / lamps
        size = (1.2, 0.4, height)
        builder.place(
            "street_lamp",
            walk.frame,
            u,
            -width / 2 + 0.15,
            size,
            base=walk.top,
            turn=STREETWARD,
            parent=walk,
        )
    for name, chance in (
        ("bin", 0.3),
        ("bench", 0.3),
        ("sign", 0.25),
        ("planter", 0.2),
    ):
        if draw.chance(chance):
            size = (0.6, 1.4, 0.9) if name == "planter" else draw.size_of(name)
            u = draw.between(-0.45, 0.45) * length
            v = width / 2 - 0.6 if name == "bench" else curb + 0.1
            builder.place(
                name,
                walk.frame,
                u,
                v,
                size,
                base=walk.top,
                turn=STREETWARD,
                parent=walk,
                within=walk,
                margin=0.3,
            )


def _signal(builder: Builder, draw: Draw, site: Site, x: float, y: float) -> None:
    """Traffic lights on the sidewalk corners around a crossing."""
    height = draw.between(3.0, 3.8)
    for walk in site.sidewalks:
        if abs(sin(walk.frame.yaw)) > 0.5:
            continue  # One light a corner, on the sidewalk of the through road.
        u, v = walk.frame.local(x, y)
        if abs(v) > 12 or abs(u) > walk.size[0] / 2 + 9:
            continue
        end = walk.size[0] / 2 - 0.5
        at = max(-end, min(end, u))
        builder.place(
            "traffic_light",
            walk.frame,
            at,
            -walk.size[1] / 2 + 0.4,
            (0.35, 0.4, height),
            base=walk.top,
            turn=pi if u > at else 0.0,
            parent=walk,
        )
