"""Streets around a site: its roads continue beyond its edge, and others cross them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import shapely

from aeroscene.scene import Scene, SceneObject
from aeroscene.scene.catalogue import GROUND, ROADS, SHELLS

CROSSING_M = 30.0
"""Distance of a crossing street from the site."""
_LEAST_WIDTH_M = 5.0
_BESIDE_M = 1.0
"""Distance from a road's end up to which other ground is beside the road, not ahead of it."""


@dataclass(frozen=True, slots=True)
class Street:
    """A straight street."""

    begin: tuple[float, float]
    """East and north, m."""
    along: tuple[float, float]
    """Unit vector from begin to end."""
    length_m: float
    width_m: float
    top_m: float
    """Height of the asphalt above the ground."""

    @property
    def yaw_rad(self) -> float:
        """Heading, counter-clockwise from east, rad."""
        return math.atan2(self.along[1], self.along[0])

    @property
    def middle(self) -> tuple[float, float]:
        """Point half way along, m."""
        half = self.length_m / 2
        return (self.begin[0] + half * self.along[0], self.begin[1] + half * self.along[1])


@dataclass(frozen=True, slots=True)
class _Exit:
    """Place where a road leaves the site."""

    street: Street
    axis: int
    """Axis across the side: 0 east, 1 north."""
    sign: float
    """Side on that axis, -1 or 1."""


def streets_around(scene: Scene, ring_m: float) -> tuple[Street, ...]:
    """Continuations of the roads that end at the edge of a site, and one crossing street a side.

    A continuation begins at the end of its road. A turned site leaves bare ground between its edge
    and that of the flight volume, which the street then crosses.

    Args:
        scene: Scene.
        ring_m: Distance from the flight volume at which the continuations end.
    """
    ahead = [obj for obj in scene.objects if obj.category in GROUND | SHELLS]
    if not ahead:
        return ()
    corners = [obj.bbox.corners()[:, :2] for obj in ahead]
    hulls = np.asarray(shapely.convex_hull(shapely.multipoints(corners)))
    exits = [found for road in _roads(scene) for found in _exits(scene, road, hulls, ring_m)]
    crossings = [
        _crossing(scene, same_side[0], ring_m)
        for axis in (0, 1)
        for sign in (-1.0, 1.0)
        if (same_side := [e for e in exits if (e.axis, e.sign) == (axis, sign)])
    ]
    return (*(found.street for found in exits), *crossings)


def _roads(scene: Scene) -> Iterable[SceneObject]:
    return (obj for obj in scene.objects if obj.category in ROADS and obj.domain == "outdoor")


def _exits(scene: Scene, road: SceneObject, ground: np.ndarray, ring_m: float) -> Iterable[_Exit]:
    """Ends of a road beyond which there is nothing of the site."""
    yaw, middle = road.bbox.yaw_rad, np.array(road.bbox.p[:2])
    length_m, width_m, _ = road.bbox.s
    # Narrow ones are lanes, and short ones are ends of streets.
    if width_m < _LEAST_WIDTH_M or length_m < width_m:
        return
    for way in (-1.0, 1.0):
        outward = way * np.array([math.cos(yaw), math.sin(yaw)])
        end = middle + outward * length_m / 2
        axis, sign, out_m = _way_out(scene, end, outward)
        # Begins beyond the road's end, and ends two metres beyond the flight volume.
        sight = shapely.LineString([end + _BESIDE_M * outward, end + (out_m + 2.0) * outward])
        if shapely.intersects(ground, sight).any():
            continue
        x, y = end.tolist()
        top_m = road.bbox.p[2] + road.bbox.s[2] / 2
        direction = (float(outward[0]), float(outward[1]))
        # Its outer corner reaches the end of the ring, whatever the angle.
        reach_m = out_m + ring_m / max(abs(outward[axis]), 0.5)
        yield _Exit(Street((x, y), direction, reach_m, width_m, top_m), axis, sign)


def _way_out(scene: Scene, point: np.ndarray, outward: np.ndarray) -> tuple[int, float, float]:
    """Side through which a direction leaves the flight volume, and the distance to it, m."""
    found: list[tuple[float, int, float]] = []
    for axis in (0, 1):
        if abs(outward[axis]) > 1e-9:
            sign = 1.0 if outward[axis] > 0.0 else -1.0
            side = (scene.extent_max_enu_m if sign > 0.0 else scene.extent_min_enu_m)[axis]
            found.append((max((side - point[axis]) / outward[axis], 0.0), axis, sign))
    out_m, axis, sign = min(found)
    return axis, sign, float(out_m)


def _crossing(scene: Scene, first: _Exit, ring_m: float) -> Street:
    """A street along a side of the site, across the roads that leave it there."""
    low, high = scene.extent_min_enu_m, scene.extent_max_enu_m
    axis, across = first.axis, 1 - first.axis
    side_m = high[axis] if first.sign > 0.0 else low[axis]
    begin = [0.0, 0.0]
    begin[axis] = side_m + first.sign * CROSSING_M
    begin[across] = low[across] - ring_m
    along = (0.0, 1.0) if axis == 0 else (1.0, 0.0)
    length_m = high[across] - low[across] + 2.0 * ring_m
    # A touch lower, so that the two surfaces do not flicker where they cross.
    top_m = first.street.top_m - 0.01
    return Street((begin[0], begin[1]), along, length_m, first.street.width_m, top_m)
