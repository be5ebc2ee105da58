"""Landing areas derived from geometry: level, clear, and reachable from the start.

A candidate is a level upward face of an object whose category may carry a drone, less everything
that stands on it or hangs low over it. In what is left the largest circles are found one after
another; each becomes an area if a drone of some class can fly there from the start.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, pi, sin

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from aeroscene.catalogue import by_name
from aeroscene.footprints import Face, Footprints, upward_faces
from aeroscene.freespace import NoFreeSpaceError, VoxelField, build_distance_field, reachable
from aeroscene.scene import DroneClass, InteractionArea, Scene
from aeroscene.shapes import Primitive, scene_primitives


@dataclass(frozen=True, slots=True, kw_only=True)
class ClassNeeds:
    """What a drone of a class needs, m."""

    surface_radius_m: float
    """Level surface about the touchdown point: the feet and the scatter of a landing."""
    body_radius_m: float
    """Free of obstacles about the touchdown point."""
    flight_radius_m: float
    """Free ball all the way from the start."""


# A Hummingbird reaches 0.4 m from its centre and an Iris 0.45 m.
NEEDS: dict[DroneClass, ClassNeeds] = {
    "large": ClassNeeds(surface_radius_m=2.6, body_radius_m=2.6, flight_radius_m=1.0),
    "medium": ClassNeeds(surface_radius_m=1.2, body_radius_m=1.2, flight_radius_m=0.7),
    "small": ClassNeeds(surface_radius_m=0.4, body_radius_m=0.6, flight_radius_m=0.45),
}
"""Largest class first."""

CLEARANCE_M = 1.5
"""Least free height above an area."""
STEP_M = 0.03
"""What rises less than this above a face is no obstacle."""
MAX_RADIUS_M = 3.0
"""Circles are cut to this radius: an area is a spot, not a field."""
SPACING_M = 2.5
"""Between the circles of one face."""
BORDER_M = 1.5
"""From the border of the flight volume."""
MAX_SMALL = 3
"""Small areas of one face: one for each began 100 m2 of it, at most this many.

A face bears one area of the larger classes at most, and a fine object bears one area in all.
"""
_FACE_M2 = 100.0
_VERTICES = 12
_MIC_TOLERANCE_M = 0.04


class LandingFinder:
    """Finds the landing areas of one scene."""

    def __init__(self, scene: Scene, primitives: Sequence[Primitive], field: VoxelField) -> None:
        self._scene = scene
        self._field = field
        self._faces = [
            face
            for face in upward_faces(primitives)
            if by_name()[scene.object_by_id[face.object_id].category].is_landable
        ]
        self._footprints = Footprints(primitives)
        self._floods = {name: self._flood(needs) for name, needs in NEEDS.items()}
        low, high = scene.extent_min_enu_m, scene.extent_max_enu_m
        self._volume = shapely.box(
            low[0] + BORDER_M, low[1] + BORDER_M, high[0] - BORDER_M, high[1] - BORDER_M
        )

    def _flood(self, needs: ClassNeeds) -> np.ndarray | None:
        try:
            return reachable(self._field, self._scene.start_position_enu_m, needs.flight_radius_m)
        except NoFreeSpaceError:
            return None

    def find(self) -> tuple[InteractionArea, ...]:
        """All areas, numbered in the order of their objects."""
        areas = [area for face in self._faces for area in self._areas_of(face)]
        areas = _one_per_fine_object(areas, self._scene)
        return tuple(replace(area, id=number) for number, area in enumerate(areas))

    def _areas_of(self, face: Face) -> list[InteractionArea]:
        """Areas under open sky, or where the face has none, under a ceiling high enough."""
        return self._areas_below(face, np.inf) or self._areas_below(face, CLEARANCE_M)

    def _areas_below(self, face: Face, clearance_m: float) -> list[InteractionArea]:
        obstacles = self._footprints.between(
            face.outline.buffer(NEEDS["large"].body_radius_m),
            face.height_m + STEP_M,
            face.height_m + clearance_m,
        )
        free = shapely.intersection(face.outline.difference(obstacles), self._volume)
        least_m = NEEDS["small"].surface_radius_m
        left = _quota(face)
        areas: list[InteractionArea] = []
        while free.area > pi * least_m**2 and any(left.values()):
            spot = _widest_spot(free)
            if spot.radius_m < least_m:
                break
            free = free.difference(spot.centre.buffer(spot.radius_m + SPACING_M))
            drone_class = self._largest_class(face, spot, obstacles)
            if drone_class and left[drone_class] > 0:
                left[drone_class] -= 1
                if drone_class == "large":
                    left["medium"] = 0
                areas.append(self._area(face, spot, drone_class))
        return areas

    def _largest_class(self, face: Face, spot: _Spot, obstacles: BaseGeometry) -> DroneClass | None:
        room_m = spot.centre.distance(obstacles) if not obstacles.is_empty else np.inf
        for name, needs in NEEDS.items():
            is_wide = spot.radius_m >= needs.surface_radius_m and room_m >= needs.body_radius_m
            if is_wide and self._is_reached(name, face, spot):
                return name
        return None

    def _is_reached(self, name: DroneClass, face: Face, spot: _Spot) -> bool:
        """Whether the flood enters the clear column above the spot."""
        flood = self._floods[name]
        x, y = spot.centre.x, spot.centre.y
        low = self._field.cell((x, y, face.height_m))
        if flood is None or low is None:
            return False
        needs = NEEDS[name]
        # The lowest ball above the face, half a cell of rounding included.
        rise_m = max(CLEARANCE_M, needs.flight_radius_m + 2 * self._field.resolution_m)
        steps = int(rise_m / self._field.resolution_m)
        return bool(flood[low[0], low[1], low[2] : low[2] + steps + 1].any())

    def _area(self, face: Face, spot: _Spot, drone_class: DroneClass) -> InteractionArea:
        z = round(face.height_m, 4)
        disc = spot.centre.buffer(max(spot.radius_m, NEEDS[drone_class].body_radius_m))
        ceiling = self._footprints.lowest_above(disc, z + STEP_M)
        clearance_m = min(ceiling, self._scene.extent_max_enu_m[2]) - z
        return InteractionArea(
            id=0,
            object_id=face.object_id,
            polygon=tuple((round(x, 4), round(y, 4), z) for x, y in spot.outline),
            centroid=(round(spot.centre.x, 4), round(spot.centre.y, 4), z),
            radius=round(spot.radius_m - 5e-4, 3),
            drone_class=drone_class,
            slope_rad=0.0,
            clearance_m=round(clearance_m, 3),
            surface=self._surface(face.object_id),
        )

    def _surface(self, object_id: int) -> str:
        obj = self._scene.object_by_id[object_id]
        finish = obj.attributes.get("finish")
        return finish if isinstance(finish, str) else by_name()[obj.category].surface


@dataclass(frozen=True, slots=True)
class _Spot:
    """A circle to land in and the polygon around it."""

    centre: shapely.Point
    radius_m: float
    outline: tuple[tuple[float, float], ...]


def _quota(face: Face) -> dict[DroneClass, int]:
    small = min(MAX_SMALL, 1 + int(face.outline.area // _FACE_M2))
    return {"large": 1, "medium": 1, "small": small}


def _one_per_fine_object(areas: list[InteractionArea], scene: Scene) -> list[InteractionArea]:
    """Of the areas on one fine object, a car's bonnet and roof say, the highest alone."""
    highest: dict[int | None, float] = {}
    for area in areas:
        z = area.centroid[2]
        highest[area.object_id] = max(z, highest.get(area.object_id, z))
    return [
        area
        for area in areas
        if area.object_id is None
        or scene.object_by_id[area.object_id].is_coarse
        or area.centroid[2] == highest[area.object_id]
    ]


def _widest_spot(free: BaseGeometry) -> _Spot:
    """The whole of a small rectangle, else the largest circle."""
    parts = shapely.get_parts(free)
    largest = parts[int(np.argmax(shapely.area(parts)))]
    whole = _whole_rectangle(largest)
    if len(parts) == 1 and whole:
        return whole
    circles = [
        shapely.maximum_inscribed_circle(part, _MIC_TOLERANCE_M)
        for part in parts
        if part.area > 0.8 * NEEDS["small"].surface_radius_m ** 2
    ]
    if not circles:
        return _Spot(largest.centroid, 0.0, ())
    widest = max(circles, key=lambda circle: circle.length)
    centre = shapely.Point(widest.coords[0])
    # A border of the polygon passes through the circle's middle height: apothem against radius.
    outer_m = min(widest.length, MAX_RADIUS_M)
    outline = tuple(
        (
            centre.x + outer_m * cos(2 * pi * (i + 0.5) / _VERTICES),
            centre.y + outer_m * sin(2 * pi * (i + 0.5) / _VERTICES),
        )
        for i in range(_VERTICES)
    )
    return _Spot(centre, outer_m * cos(pi / _VERTICES), outline)


def _whole_rectangle(part: BaseGeometry) -> _Spot | None:
    """A rectangle of no more than twice the largest circle, with its own centre and half width."""
    if shapely.get_num_coordinates(part) != 5:
        return None
    corners = shapely.get_coordinates(shapely.normalize(part))[:4]
    sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    is_rectangle = abs(part.area - sides[0] * sides[1]) < 1e-3 * part.area
    if not is_rectangle or max(sides) > 2 * MAX_RADIUS_M or max(sides) > 3.2 * min(sides):
        return None
    ring = shapely.get_coordinates(shapely.orient_polygons(part))[:-1]
    outline = tuple((float(x), float(y)) for x, y in ring.tolist())
    return _Spot(part.centroid, float(min(sides)) / 2, outline)


def derive_landing_areas(
    scene: Scene,
    primitives: Sequence[Primitive] | None = None,
    field: VoxelField | None = None,
) -> tuple[InteractionArea, ...]:
    """Landing areas of a scene, from its geometry alone.

    Args:
        scene: The scene; areas that it has already are ignored.
        primitives: Its primitives, where the caller has them already.
        field: Its distance field, likewise.
    """
    primitives = scene_primitives(scene) if primitives is None else primitives
    if field is None:
        field = build_distance_field(scene, primitives=primitives)
    return LandingFinder(scene, primitives, field).find()
