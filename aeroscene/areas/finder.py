"""Search for places on single faces: clear, wide enough, reached from the start."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi

import shapely
from shapely.geometry.base import BaseGeometry

from aeroscene.areas.bare_ground import ground_rise_m
from aeroscene.areas.faces import Face
from aeroscene.areas.needs import LEGS_M, NEEDS, PERCH_NEEDS, STEP_M, AreaNeeds, needs_of
from aeroscene.areas.obstacles import Obstacles, Obstructions
from aeroscene.areas.reachability import is_reached
from aeroscene.areas.spots import FreeOutline, Spot
from aeroscene.scene import AreaKind, DroneClass, InteractionArea, Scene, Vector3
from aeroscene.scene.catalogue import by_name
from aeroscene.solids.freespace import VoxelField

SPACING_M = 2.5
"""Gap between the circles of one face."""
BORDER_M = 1.5
"""Least distance from the border of the flight volume."""
SHARE_M2: dict[DroneClass, float] = {"large": 300.0, "medium": 100.0, "small": 30.0}
"""A face has one area of a class for each such area, also for a part of one."""
# Greatest number of areas of each class on one face.
MAX_OF_A_FACE: dict[DroneClass, int] = {"large": 2, "medium": 3, "small": 5}
CUT_M: dict[DroneClass, float] = {"large": 3.0, "medium": 2.0, "small": 1.0}
"""Radius of an area of a class, on a face that has all its areas of larger classes already."""
PERCH_CUT_M = 0.5
"""Greatest radius of a perching area."""
LEDGE_M = 0.7
"""A face of a coarse object is a perch if its widest circle is smaller than this."""
LEDGE_GAP_M = 0.35
"""Gap between a perch on a coarse object and its walls, beside which a drone comes down."""
GROUND_SURFACE = "grass"
"""Surface that landing gear meets on bare ground."""
_INNER_M = 5e-4
"""Taken off a radius, so that rounding never takes it beyond its face."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """A place that would make an area."""

    face: Face
    spot: Spot
    kind: AreaKind
    drone_class: DroneClass

    @property
    def place_enu_m(self) -> Vector3:
        """Middle of the place, on the face."""
        return _place(self.face, self.spot)


class AreaFinder:
    """Finds places on one face at a time.

    Args:
        scene: The scene.
        obstacles: Outlines of its solids.
        field: Distance field of its free space.
    """

    def __init__(self, scene: Scene, obstacles: Obstacles, field: VoxelField) -> None:
        self._scene = scene
        self._obstacles = obstacles
        self._field = field
        low, high = scene.extent_min_enu_m, scene.extent_max_enu_m
        # Indoors the border consists of the outer walls, which are obstacles already.
        border_m = 0.0 if scene.domain == "indoor" else BORDER_M
        self._bounds = (
            low[0] + border_m,
            low[1] + border_m,
            high[0] - border_m,
            high[1] - border_m,
        )

    def landing(self, face: Face) -> Iterator[Candidate]:
        """Yield places to land on a face, the widest first.

        They are under open sky, or, if the face has none there, under a ceiling that is high
        enough. The search is lazy: a place is not looked for before the caller asks for it.
        """
        outline = self._within_volume(face.outline)
        if outline.is_empty:
            return
        near = self._near(face, outline, NEEDS["large"])
        # Obstacles that begin higher than a drone needs are ceilings.
        lower = near.below(NEEDS["small"].clearance_m)
        is_bare = True
        for candidate in self._landing(face, outline, near):
            is_bare = False
            yield candidate
        if is_bare and len(lower.outlines) < len(near.outlines):
            yield from self._landing(face, outline, lower)

    def perching(self, face: Face) -> Candidate | None:
        """Return the best place to perch on a face, or None."""
        needs = PERCH_NEEDS
        outline = self._within_volume(face.outline)
        if outline.is_empty:
            return None
        near = self._near(face, outline, needs).below(needs.clearance_m)
        is_coarse = self._is_coarse(face)
        free = (
            near.cleared_from(outline, LEGS_M, LEDGE_GAP_M)
            if is_coarse
            else near.subtracted_from(outline)
        )
        spot = FreeOutline(free, needs.surface_radius_m + _INNER_M).widest()
        if spot is None or (is_coarse and spot.radius_m > LEDGE_M):
            return None
        spot = spot.cut(PERCH_CUT_M)
        if near.distance_m(spot.centre, LEGS_M) < needs.body_radius_m:
            return None
        if self._is_buried(face, spot.centre, spot.radius_m, needs):
            return None
        if not self._is_reached(_place(face, spot), needs):
            return None
        return Candidate(face, spot, "perching", "small")

    def area(self, candidate: Candidate, number: int) -> InteractionArea:
        """Build the area of a candidate.

        Args:
            candidate: The place.
            number: Id of the area.
        """
        face, spot = candidate.face, candidate.spot
        needs = needs_of(candidate.kind, candidate.drone_class)
        disc = spot.centre.buffer(max(spot.radius_m, needs.body_radius_m))
        x, y, z = candidate.place_enu_m
        ceiling_m = self._obstacles.lowest_above(face, disc, LEGS_M)
        # Under open sky the flight volume is the ceiling.
        clearance_m = min(ceiling_m, self._scene.extent_max_enu_m[2] - z)
        return InteractionArea(
            id=number,
            kind=candidate.kind,
            object_id=face.object_id,
            polygon=tuple(
                (round(u, 4), round(v, 4), round(face.height_m(u, v), 4)) for u, v in spot.outline
            ),
            centroid=(round(x, 4), round(y, 4), round(z, 4)),
            radius=round(spot.radius_m - _INNER_M, 3),
            drone_class=candidate.drone_class,
            slope_rad=round(face.slope_rad, 5),
            clearance_m=round(clearance_m, 3),
            surface=self._surface(face.object_id),
        )

    def _landing(
        self, face: Face, outline: BaseGeometry, near: Obstructions
    ) -> Iterator[Candidate]:
        least_m = NEEDS["small"].surface_radius_m + _INNER_M
        free = FreeOutline(near.subtracted_from(outline), least_m)
        left: dict[DroneClass, int] = {
            name: min(MAX_OF_A_FACE[name], 1 + int(face.outline.area // share_m2))
            for name, share_m2 in SHARE_M2.items()
        }
        while any(left.values()) and (widest := free.widest()) is not None:
            spot = widest
            fitting = self._classes(face, widest, near)
            allowed: list[DroneClass] = [name for name in fitting if left[name] > 0]
            if allowed:
                drone_class = allowed[0]
                if drone_class != fitting[0]:
                    # A place that is wider than its class leaves the rest to other areas.
                    spot = widest.cut(CUT_M[drone_class])
                left[drone_class] -= 1
                yield Candidate(face, spot, "landing", drone_class)
            if any(left.values()):
                free.take(spot, SPACING_M)

    def _near(self, face: Face, outline: BaseGeometry, needs: AreaNeeds) -> Obstructions:
        x0, y0, x1, y1 = outline.bounds
        margin_m = needs.body_radius_m
        bounds = (x0 - margin_m, y0 - margin_m, x1 + margin_m, y1 + margin_m)
        return self._obstacles.above(face, bounds, STEP_M)

    def _within_volume(self, outline: BaseGeometry) -> BaseGeometry:
        x0, y0, x1, y1 = outline.bounds
        low_x, low_y, high_x, high_y = self._bounds
        if low_x <= x0 and low_y <= y0 and x1 <= high_x and y1 <= high_y:
            return outline
        return shapely.intersection(outline, shapely.box(low_x, low_y, high_x, high_y))

    def _classes(self, face: Face, spot: Spot, near: Obstructions) -> list[DroneClass]:
        """Return the classes for which a spot is wide enough and reached, largest first."""
        room_m = near.distance_m(spot.centre, LEGS_M)
        place = _place(face, spot)
        return [
            name
            for name, needs in NEEDS.items()
            if spot.radius_m >= needs.surface_radius_m + _INNER_M
            and room_m >= needs.body_radius_m
            and not self._is_buried(face, spot.centre, spot.radius_m, needs)
            and self._is_reached(place, needs)
        ]

    def _is_reached(self, place_enu_m: Vector3, needs: AreaNeeds) -> bool:
        return is_reached(self._field, self._scene.start_position_enu_m, place_enu_m, needs)

    def _is_buried(
        self, face: Face, centre: shapely.Point, radius_m: float, needs: AreaNeeds
    ) -> bool:
        """True if the ground rises above a place, or above the legs beside it."""
        if self._scene.relief is None:
            return False
        reach_m = max(radius_m, needs.body_radius_m)
        return (
            ground_rise_m(self._scene, face, centre, radius_m) > STEP_M
            or ground_rise_m(self._scene, face, centre, reach_m) > LEGS_M
        )

    def _surface(self, object_id: int | None) -> str:
        if object_id is None:
            return GROUND_SURFACE
        obj = self._scene.object_by_id[object_id]
        finish = obj.attributes.get("finish")
        return finish if isinstance(finish, str) else by_name()[obj.category].surface

    def _is_coarse(self, face: Face) -> bool:
        return face.object_id is None or self._scene.object_by_id[face.object_id].is_coarse


def _place(face: Face, spot: Spot) -> Vector3:
    x, y = spot.centre.x, spot.centre.y
    return (x, y, face.height_m(x, y))


def is_wide(face: Face) -> bool:
    """True if a face may bear more than a perch."""
    return face.outline.area > pi * NEEDS["small"].surface_radius_m ** 2
