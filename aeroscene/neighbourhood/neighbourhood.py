"""Neighbours of a scene: houses, trees and streets around its flight volume.

Houses and trees stand in a ring around the flight volume and never in it. They are no objects of
the scene: nothing is measured or counted of them, and no landing area lies on them. Streets are
paint: nothing collides with them, so that they may begin at a road's end within the volume.

The neighbours are a pure function of the scene, so that every process sees the same ones without
storing them.
"""

from __future__ import annotations

import functools
import math
import zlib
from collections.abc import Iterator

import numpy as np

from aeroscene.neighbourhood import shapes
from aeroscene.neighbourhood.plots import Place, Plot
from aeroscene.neighbourhood.streets import Street, streets_around
from aeroscene.neighbourhood.style import LEAVES, NEIGHBOURHOOD_STYLES, NeighbourhoodStyle
from aeroscene.scene import Scene, Vector3
from aeroscene.solids.shapes import Primitive
from aeroscene.solids.shapes.primitive import Part

RING_M = 60.0
"""Width of the ring."""
GAP_M = 4.0
"""Width of the strip around the flight volume in which nothing rises."""
_APART_M = 2.5
"""Distance between two neighbours, and between one and a street."""
_TRIES = 6
"""Number of places tried for each tree, or house without a street."""
_LEAST_TOP_M = 0.03
_LEVEL_M = 0.005
"""Height of the ground up to which it counts as level."""
_TREE_M = ((3.0, 6.0), (5.0, 10.0))
"""Width and height of trees."""
_KEPT = 8


@functools.lru_cache(maxsize=_KEPT)
def neighbours_of(scene: Scene) -> tuple[Primitive, ...]:
    """Solids of houses and trees around an outdoor scene, and paint of streets.

    Args:
        scene: Scene; its theme decides on the surroundings.

    Returns:
        Primitives outside of the flight volume; none for indoor scenes and unknown themes.
    """
    style = NEIGHBOURHOOD_STYLES.get(scene.theme)
    if style is None or scene.domain == "indoor":
        return ()
    return tuple(_Ring(scene, style).primitives())


class _Ring:
    """The land around one scene while it is built up."""

    def __init__(self, scene: Scene, style: NeighbourhoodStyle) -> None:
        self._scene, self._style = scene, style
        # Python's own hash of texts differs between processes, hence the checksum.
        name = zlib.crc32(scene.scene_id.encode())
        self._rng = np.random.default_rng([scene.seed, name, 0x4E1])
        (x0, y0, _), (x1, y1, _) = scene.extent_min_enu_m, scene.extent_max_enu_m
        self._inner = (x0 - GAP_M, y0 - GAP_M, x1 + GAP_M, y1 + GAP_M)
        self._outer = (x0 - RING_M, y0 - RING_M, x1 + RING_M, y1 + RING_M)
        self._taken: list[Plot] = []

    def primitives(self) -> Iterator[Primitive]:
        """Streets first, then houses, then trees; later ones take the places that are left."""
        streets = tuple(
            street for street in streets_around(self._scene, RING_M) if self._is_level(street)
        )
        for street in streets:
            size_m = (street.length_m, street.width_m, max(street.top_m, _LEAST_TOP_M))
            self._taken.append(Plot.at((*street.middle, street.yaw_rad), size_m))
            yield from shapes.placed(shapes.street(*size_m), (*street.middle, 0.0), street.yaw_rad)
        yield from self._houses(streets)
        yield from self._trees()

    def _is_level(self, street: Street) -> bool:
        """Return true if a street lies on level ground: paint does not follow a relief."""
        if self._scene.relief is None:
            return True
        along_m = np.linspace(0.0, street.length_m, 1 + math.ceil(street.length_m))[:, None]
        aside_m = np.linspace(-0.5, 0.5, 9) * street.width_m
        (x, y), (u, v) = street.begin, street.along
        ground_m = self._scene.relief.height_m(
            x + along_m * u - aside_m * v, y + along_m * v + aside_m * u
        )
        return bool(np.abs(ground_m).max() <= _LEVEL_M)

    def _houses(self, streets: tuple[Street, ...]) -> Iterator[Primitive]:
        style, n_left = self._style, self._style.n_houses
        # Fronts along streets before places without a street.
        places = (*self._fronts(streets), *self._anywhere(style.n_houses))
        # All are drawn beforehand, so that a place that is taken does not change the later ones.
        sizes = self._drawn(len(places), style.length_m, style.width_m, style.height_m)
        walls, roofs = (
            self._rng.integers(len(kinds), size=len(places)).tolist()
            for kinds in (style.walls, style.roofs)
        )
        for place, size_m, wall, roof in zip(places, sizes, walls, roofs, strict=True):
            plot = self._take(place, size_m) if n_left else None
            if plot is not None:
                n_left -= 1
                kinds = style.walls[wall], style.roofs[roof]
                parts = shapes.house(size_m, *kinds, style.pitch)
                yield from self._standing(parts, plot, place)

    def _trees(self) -> Iterator[Primitive]:
        n_left = self._style.n_trees
        places = self._anywhere(_TRIES * n_left)
        sizes = self._drawn(len(places), _TREE_M[0], _TREE_M[0], _TREE_M[1])
        # Kinds of leaves in turn.
        for number, (place, (wide_m, _, rise_m)) in enumerate(zip(places, sizes, strict=True)):
            plot = self._take(place, (wide_m, wide_m, rise_m)) if n_left else None
            if plot is not None:
                n_left -= 1
                parts = shapes.tree((wide_m, wide_m, rise_m), LEAVES[number % len(LEAVES)])
                yield from self._standing(parts, plot, place)

    def _fronts(self, streets: tuple[Street, ...]) -> Iterator[Place]:
        """Places of houses that face a street, on both sides of each."""
        style = self._style
        deep_m = sum(style.length_m) / 2
        for street in streets:
            (x, y), (u, v) = street.begin, street.along
            for side in (-1.0, 1.0):
                aside_m = side * (street.width_m / 2 + style.setback_m + deep_m / 2)
                first_m = self._rng.uniform(0.3, 0.7) * style.spacing_m
                for at_m in np.arange(first_m, street.length_m, style.spacing_m).tolist():
                    # The front is +x and looks at the street.
                    yaw_rad = street.yaw_rad - side * math.pi / 2
                    yield (x + at_m * u - aside_m * v, y + at_m * v + aside_m * u, yaw_rad)

    def _anywhere(self, n: int) -> list[Place]:
        """Random places, with headings close to the axes."""
        x0, y0, x1, y1 = self._outer
        drawn = self._rng.uniform((x0, y0, -0.15), (x1, y1, 0.15), (n, 3))
        drawn[:, 2] += self._rng.integers(4, size=n) * (math.pi / 2)
        return [(x, y, yaw) for x, y, yaw in drawn.tolist()]

    def _drawn(self, n: int, *spans: tuple[float, float]) -> list[Vector3]:
        """Sizes within spans, m."""
        low, high = zip(*spans, strict=True)
        return [(x, y, z) for x, y, z in self._rng.uniform(low, high, (n, 3)).round(2).tolist()]

    def _take(self, place: Place, size_m: Vector3) -> Plot | None:
        """Take the plot at a place if it is free; None otherwise."""
        plot = Plot.at(place, size_m)
        (u, v), (x0, y0, x1, y1) = plot.reach_m, self._outer
        if not (x0 + u <= plot.x <= x1 - u and y0 + v <= plot.y <= y1 - v):
            return None
        # Nothing may extend into the strip around the flight volume.
        x0, y0, x1, y1 = self._inner
        if x0 - u < plot.x < x1 + u and y0 - v < plot.y < y1 + v:
            return None
        if not all(plot.is_apart(other, _APART_M) for other in self._taken):
            return None
        self._taken.append(plot)
        return plot

    def _standing(self, parts: list[Part], plot: Plot, place: Place) -> list[Primitive]:
        """Parts on the lowest ground below a plot."""
        foot_m = 0.0
        if self._scene.relief is not None:
            foot_m = float(self._scene.relief.height_m(*np.array(plot.corners()).T).min())
        return shapes.placed(parts, (plot.x, plot.y, foot_m), place[2])
