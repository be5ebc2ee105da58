"""Claims of each area, checked against the solids.

Nothing here shares code with the search for areas, so that a fault there shows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from jaxtyping import Float

from aeroscene.areas.needs import LEGS_M, MAX_SLOPE_RAD, STEP_M, AreaNeeds, area_needs
from aeroscene.scene import InteractionArea, Scene
from aeroscene.scene.geometry import layer
from aeroscene.scene.relief import ground_m
from aeroscene.solids.outlines import outline_of
from aeroscene.solids.solids import Solids
from aeroscene.validation.columns import spans
from aeroscene.validation.findings import Finding

HEIGHT_TOLERANCE_M = 0.006
"""Greatest gap between the claimed plane and its polygon, and the surface below it."""
STEP_TOLERANCE_M = 0.004
"""Height beyond `STEP_M` and `LEGS_M` from which an object is in the way."""
EDGE_M = 0.01
"""Distance into a circle up to which an object only touches it."""
SLOPE_TOLERANCE_RAD = math.radians(0.2)
# Rings and turns at which a disc is probed; the outermost stays inside the border.
_RINGS = (0.35, 0.7, 0.98)
_TURNS = 16
_LEVEL = 1e-4
"""Gradient up to which a plane is level."""


@dataclass(frozen=True, slots=True)
class _Plane:
    """The plane of an area: height over its centroid and gradient."""

    centre: Float[np.ndarray, " 3"]
    gradient: Float[np.ndarray, " 2"]

    @property
    def slope_rad(self) -> float:
        return math.atan(float(np.hypot(*self.gradient)))

    @property
    def is_level(self) -> bool:
        return bool(np.hypot(*self.gradient) < _LEVEL)

    def height_m(self, points: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, " n"]:
        return self.centre[2] + (points - self.centre[:2]) @ self.gradient


@dataclass(frozen=True, slots=True)
class _Obstacle:
    """A solid near an area."""

    index: int
    rise_m: float
    """Height of its underside above the area's plane."""
    distance_m: float
    """Distance from the centroid, seen from above."""


def unlandable(scene: Scene, solids: Solids) -> Iterator[Finding]:
    """Find areas whose own claim does not hold."""
    for area in scene.interaction_areas:
        for detail in _Claim(scene, solids, area).objections():
            yield Finding(
                kind="unlandable",
                scene_id=scene.scene_id,
                object_id=area.object_id,
                area_id=area.id,
                detail=f"{area.kind} area {area.id} for {area.drone_class} drones: {detail}",
            )


class _Claim:
    """One area and the solids around it."""

    def __init__(self, scene: Scene, solids: Solids, area: InteractionArea) -> None:
        self._scene = scene
        self._solids = solids
        self._area = area
        self._needs: AreaNeeds = area_needs(area)
        self._polygon = np.array(area.polygon)
        self._plane = _fitted(self._polygon, np.array(area.centroid))

    def objections(self) -> Iterator[str]:
        yield from self._figures()
        yield from self._surface()
        yield from self._ground()
        yield from self._room()

    def _figures(self) -> Iterator[str]:
        """Compare slope, plane and radius with the polygon and the class."""
        area, plane = self._area, self._plane
        off_m = np.abs(plane.height_m(self._polygon[:, :2]) - self._polygon[:, 2]).max()
        if off_m > HEIGHT_TOLERANCE_M:
            yield (
                f"its polygon lies {off_m:.3f} m off a plane through the centroid; "
                f"valid: {HEIGHT_TOLERANCE_M} m"
            )
        if abs(plane.slope_rad - area.slope_rad) > SLOPE_TOLERANCE_RAD:
            yield (
                f"slope_rad is {area.slope_rad:.4f}, its polygon leans by {plane.slope_rad:.4f} rad"
            )
        if area.slope_rad > MAX_SLOPE_RAD + SLOPE_TOLERANCE_RAD:
            yield f"slope_rad is {area.slope_rad:.4f}; valid: at most {MAX_SLOPE_RAD:.4f}"
        if area.radius < self._needs.surface_radius_m - 1e-6:
            yield f"radius is {area.radius} m; valid: from {self._needs.surface_radius_m} m"
        if area.clearance_m < self._needs.clearance_m:
            yield f"clearance_m is {area.clearance_m}; valid: from {self._needs.clearance_m}"

    def _surface(self) -> Iterator[str]:
        """Check that the bearer has a face in the area's plane all over circle and polygon."""
        area, solids = self._area, self._solids
        points = np.vstack([self._disc(), self._inner_corners()])
        wanted_m = self._plane.height_m(points)
        nearest_m = np.full(len(points), np.inf)
        if area.object_id is None:
            nearest_m = np.abs(ground_m(self._scene.relief, *points.T) - wanted_m)
        low, high = points.min(axis=0), points.max(axis=0)
        near = solids.near(
            np.array([*low, wanted_m.min() - 0.1]), np.array([*high, wanted_m.max() + 0.1])
        )
        for i in near[solids.object_id[near] == area.object_id]:
            off_m = np.abs(spans(solids, i, points)[:, 1] - wanted_m)
            # A solid that misses a point has a NaN there, which `fmin` ignores.
            nearest_m = np.fmin(nearest_m, off_m)
        missing = int((nearest_m > HEIGHT_TOLERANCE_M).sum())
        if missing:
            bearer = "the ground" if area.object_id is None else self._name(area.object_id)
            yield f"{bearer} has no face there at {missing} of {len(points)} points"

    def _ground(self) -> Iterator[str]:
        """Check that the ground does not rise above the area, or above the legs beside it."""
        reach_m = max(self._area.radius, self._needs.body_radius_m)
        for radius_m, step_m, where in (
            (self._area.radius, STEP_M, "on"),
            (reach_m, LEGS_M, "beside"),
        ):
            points = self._disc(radius_m)
            rise_m = ground_m(self._scene.relief, *points.T) - self._plane.height_m(points)
            if rise_m.max() > step_m + STEP_TOLERANCE_M:
                yield (
                    f"the ground rises {rise_m.max():.2f} m above its plane {where} it; "
                    f"valid: at most {step_m} m"
                )

    def _disc(self, radius_m: float | None = None) -> Float[np.ndarray, "n 2"]:
        radius_m = self._area.radius if radius_m is None else radius_m
        turns = 2 * np.pi * np.arange(_TURNS) / _TURNS
        circle = np.stack([np.cos(turns), np.sin(turns)], axis=1)
        rings = [fraction * radius_m * circle for fraction in _RINGS]
        return self._plane.centre[:2] + np.vstack([np.zeros((1, 2)), *rings])

    def _inner_corners(self) -> Float[np.ndarray, "n 2"]:
        centre = self._plane.centre[:2]
        # A little inside the corners, where the surface is well defined.
        return centre + 0.98 * (self._polygon[:, :2] - centre)

    def _room(self) -> Iterator[str]:
        """Find objects that stand on the circle or beside it, or hang lower than claimed."""
        area, needs = self._area, self._needs
        reach_m = max(area.radius, needs.body_radius_m)
        low_m = STEP_M + STEP_TOLERANCE_M
        near = self._near(reach_m, max(area.clearance_m, needs.clearance_m))
        for found in self._obstacles(near, low_m, area.radius, needs.clearance_m):
            name = self._name(int(self._solids.object_id[found.index]))
            yield f"{name} stands on it {found.distance_m:.2f} m from the middle"
        for found in self._obstacles(near, LEGS_M + STEP_TOLERANCE_M, reach_m, needs.clearance_m):
            # What stands within the radius has been reported above.
            if found.distance_m > area.radius - EDGE_M:
                name = self._name(int(self._solids.object_id[found.index]))
                yield (
                    f"{name} stands {found.distance_m:.2f} m from the middle; "
                    f"valid: from {reach_m:.2f} m"
                )
        above = self._obstacles(near, low_m, area.radius, area.clearance_m)
        # Lower ones stand on the area, and have been reported above.
        hanging = [o for o in above if needs.clearance_m < o.rise_m < area.clearance_m - EDGE_M]
        if hanging:
            lowest = min(hanging, key=lambda o: o.rise_m)
            name = self._name(int(self._solids.object_id[lowest.index]))
            yield (
                f"clearance_m is {area.clearance_m}, {name} hangs {lowest.rise_m:.2f} m above it"
            )

    def _near(self, radius_m: float, high_m: float) -> list[int]:
        """Solids that may extend into the room of the area."""
        centre = self._plane.centre
        # On a slope the plane rises and falls by this much within the radius.
        lift_m = radius_m * float(np.hypot(*self._plane.gradient))
        return self._solids.near(
            centre + np.array((-radius_m, -radius_m, STEP_M - lift_m)),
            centre + np.array((radius_m, radius_m, high_m + lift_m)),
        ).tolist()

    def _obstacles(
        self, near: Sequence[int], low_m: float, radius_m: float, high_m: float
    ) -> list[_Obstacle]:
        """Solids that extend between two heights above the plane within a radius."""
        found = (self._obstacle(i, low_m, high_m) for i in near)
        return [o for o in found if o is not None and o.distance_m < radius_m - EDGE_M]

    def _obstacle(self, index: int, low_m: float, high_m: float) -> _Obstacle | None:
        """Nearest point of a solid between two heights above the plane; None if there is none."""
        solids, plane = self._solids, self._plane
        # Upright solids above level planes are most, and need no polygons.
        if plane.is_level and solids.is_upright[index] and not solids.is_mesh[index]:
            rise_m = float(solids.low_m[index, 2] - plane.centre[2])
            top_m = float(solids.high_m[index, 2] - plane.centre[2])
            if rise_m >= high_m or top_m <= low_m:
                return None
            if solids.is_box[index] or solids.is_cylinder[index]:
                return _Obstacle(index, rise_m, self._distance_upright(index))
        # Of height 1, not of length 1: products with it are vertical heights above the plane.
        normal = np.array([*-plane.gradient, 1.0])
        base = float(normal @ plane.centre)
        points = solids.points(index)
        rise_m = float((points @ normal).min()) - base
        points = layer(points, normal, base + low_m, base + high_m)
        if not len(points):
            return None
        distance_m = outline_of(points).distance(shapely.Point(plane.centre[:2]))
        return _Obstacle(index, rise_m, distance_m)

    def _distance_upright(self, index: int) -> float:
        solids = self._solids
        offset = self._plane.centre[:2] - solids.centre_m[index, :2]
        if solids.is_cylinder[index]:
            return max(0.0, float(np.hypot(*offset)) - float(solids.half_m[index, 0]))
        beyond = np.abs(offset @ solids.rotation[index, :2, :2]) - solids.half_m[index, :2]
        return float(np.hypot(*np.maximum(beyond, 0.0)))

    def _name(self, object_id: int) -> str:
        obj = self._scene.object_by_id.get(object_id)
        return f"object {object_id}" if obj is None else f"{obj.category} {object_id}"


def _fitted(polygon: Float[np.ndarray, "n 3"], centroid: Float[np.ndarray, " 3"]) -> _Plane:
    """The plane through the centroid that fits the polygon best, by least squares."""
    offset = polygon - centroid
    gradient, *_ = np.linalg.lstsq(offset[:, :2], offset[:, 2], rcond=None)
    return _Plane(centroid, gradient)
