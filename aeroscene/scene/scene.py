"""The scene document: objects, hierarchy, landing areas. Frozen and validated.

The fields are those of the paper's section "AeroScene Dataset Statistic and Labels". The world
frame is ENU in metres, quaternions are `wxyz`, body to world.

Every `Scene` that exists is valid, so that no other module has to check one. Construction raises
`SceneError` otherwise, with one line that names scene, object and field.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, get_args

from aeroscene.files.bounds import MOST_ID, MOST_OBJECTS, MOST_POINTS, MOST_SEED
from aeroscene.files.visible import is_visible
from aeroscene.scene.box import MAX_EXTENT_M, OrientedBox, Vector3
from aeroscene.scene.catalogue import CATALOGUE
from aeroscene.scene.errors import (
    SceneError,
    require,
    require_finite,
    require_one_of,
    require_within,
)
from aeroscene.scene.outline import require_outline
from aeroscene.scene.polygon import distance_inside, is_simple, signed_area
from aeroscene.scene.relief import Relief

AttributeValue = str | float | int | bool
ObjectDomain = Literal["indoor", "outdoor"]
SceneDomain = Literal["indoor", "outdoor", "mixed"]
DOMAINS: tuple[SceneDomain, ...] = get_args(SceneDomain)
DroneClass = Literal["small", "medium", "large"]
AreaKind = Literal["landing", "perching"]

INSCRIBED_TOLERANCE_M = 0.01
"""Length by which an area's radius may exceed the distance from its centroid to its border, m."""
FARTHEST_M = 10_000.0
"""Farthest that a coordinate lies from the origin, m; beyond, 32-bit floats lose millimetres."""
ALTITUDES_M = (-1000.0, 10_000.0)
"""Lowest and highest altitude of the origin, m: below the Dead Sea's shore, above every summit."""
MOST_YAW_RAD = 2.0 * math.pi + 1e-6  # a full turn and its rounding
_TOUCH_M = 1e-6
"""Rounding of the border of a relief, m."""
_MOST_NUMBER = 1e9
"""Largest number of an attribute, which may become a count of parts."""
_MOST_TEXT = 200
"""Most characters of a name."""


def _require_id(number: int) -> None:
    ok = 0 <= number <= MOST_ID
    require(ok=ok, field_name="id", value=number, valid=f"an integer from 0 to {MOST_ID}")


def _require_name(name: str, field_name: str, least: int = 0) -> None:
    """Require a short text without characters that a terminal obeys."""
    ok = least <= len(name) <= _MOST_TEXT and is_visible(name)
    valid = f"{least} to {_MOST_TEXT} characters, no control characters"
    require(ok=ok, field_name=field_name, value=name, valid=valid)


def _require_point(point: Vector3, field_name: str) -> None:
    require_finite(point, 3, field_name)
    require_within(point, FARTHEST_M, field_name)


def _require_numbers(values: Mapping[str, AttributeValue], title: str) -> None:
    for name, value in values.items():
        if isinstance(value, (int, float)):
            require_within((value,), _MOST_NUMBER, f"{title}.{name}")


@dataclass(frozen=True, slots=True, kw_only=True)
class SceneObject:
    """One node of the hierarchy; its parent carries or contains it."""

    id: int
    scene_id: str
    parent_id: int | None
    category_id: int
    bbox: OrientedBox
    domain: ObjectDomain
    attributes: Mapping[str, AttributeValue] = field(default_factory=dict, hash=False)
    """Properties beyond the box: colour, storeys, form, kind of room."""

    def __post_init__(self) -> None:
        try:
            self._validate()
        except SceneError as error:
            raise error.within(f"object {self.id}") from None

    def _validate(self) -> None:
        _require_id(self.id)
        require(
            ok=self.category_id in CATALOGUE,
            field_name="category_id",
            value=self.category_id,
            valid=f"1 to {len(CATALOGUE)}",
        )
        require_one_of(self.domain, ObjectDomain, "domain")
        _require_numbers(self.attributes, "attributes")
        require_outline(self.attributes, self.bbox)

    @property
    def category(self) -> str:
        """Name of the category."""
        return CATALOGUE[self.category_id].name

    @property
    def is_coarse(self) -> bool:
        """True if the category is one of the 23 coarse ones."""
        return CATALOGUE[self.category_id].level == "coarse"


@dataclass(frozen=True, slots=True, kw_only=True)
class InteractionArea:
    """Flat, clear polygon where a drone may land, and the largest circle about its centroid.

    Raises:
        SceneError: If the polygon is not simple or not counter-clockwise, the circle does not fit
            in it, or a number is out of range.
    """

    id: int
    kind: AreaKind = "landing"
    """Perching areas are too narrow to land on without care: ledges, wall tops, benches."""
    object_id: int | None
    """Object that carries the area; None is the bare ground."""
    polygon: tuple[Vector3, ...]
    """Border, ENU, m, counter-clockwise from above, not closed."""
    centroid: Vector3
    """Touchdown point, ENU, m."""
    radius: float
    """Radius in m of a circle about the centroid that lies within the polygon."""
    drone_class: DroneClass
    """The largest class of drone that fits."""
    slope_rad: float
    clearance_m: float
    """Free height above the surface, m; capped if nothing is above."""
    surface: str
    """Material under the landing gear: asphalt, grass, concrete, metal, wood, fabric..."""

    def __post_init__(self) -> None:
        try:
            self._validate()
        except SceneError as error:
            raise error.within(f"interaction area {self.id}") from None

    def _validate(self) -> None:
        require_one_of(self.drone_class, DroneClass, "drone_class")
        require_one_of(self.kind, AreaKind, "kind")
        _require_id(self.id)
        ok = 3 <= len(self.polygon) <= MOST_POINTS
        valid = f"3 to {MOST_POINTS} vertices"
        require(ok=ok, field_name="polygon", value=self.polygon, valid=valid)
        for index, vertex in enumerate(self.polygon):
            _require_point(vertex, f"polygon[{index}]")
        _require_point(self.centroid, "centroid")
        require_finite((self.radius, self.clearance_m), 2, "radius and clearance_m")
        require_within((self.clearance_m,), FARTHEST_M, "clearance_m")
        require(ok=self.radius > 0, field_name="radius", value=self.radius, valid="above 0 m")
        ok = 0 <= self.slope_rad < math.pi / 2
        require(ok=ok, field_name="slope_rad", value=self.slope_rad, valid="0 to below pi/2")
        ok = self.clearance_m > 0
        require(ok=ok, field_name="clearance_m", value=self.clearance_m, valid="above 0 m")
        self._validate_polygon()

    def _validate_polygon(self) -> None:
        outline = [(x, y) for x, y, _ in self.polygon]
        valid = "a simple polygon, counter-clockwise seen from above"
        ok = signed_area(outline) > 0 and is_simple(outline)
        require(ok=ok, field_name="polygon", value=self.polygon, valid=valid)
        inside_m = distance_inside(outline, self.centroid[0], self.centroid[1])
        require(
            ok=inside_m > 0,
            field_name="centroid",
            value=self.centroid,
            valid="a point inside the polygon",
        )
        require(
            ok=self.radius <= inside_m + INSCRIBED_TOLERANCE_M,
            field_name="radius",
            value=self.radius,
            valid=f"at most {inside_m:.3f} m, the distance from the centroid to the border",
        )


@dataclass(frozen=True, kw_only=True)
class Scene:
    """A place to fly in: its objects, the start of the flight, and the areas where it may end.

    Raises:
        SceneError: If a field breaks a rule; one line names scene, object and field.
    """

    scene_id: str
    domain: SceneDomain
    seed: int
    extent_min_enu_m: Vector3
    """Lower corner of the flight volume."""
    extent_max_enu_m: Vector3
    """Upper corner of the flight volume."""
    start_position_enu_m: Vector3
    """Start of the landing gear: a point ON a surface, not the centre of mass."""
    start_yaw_rad: float
    latitude_deg: float
    """Geodetic place of the ENU origin, WGS 84."""
    longitude_deg: float
    altitude_m: float
    """Height of the ENU origin above mean sea level."""
    objects: tuple[SceneObject, ...]
    """Parents come before their children."""
    interaction_areas: tuple[InteractionArea, ...] = ()
    theme: str = ""
    """Kind of place, such as `park` or `office`; empty if nobody stated it."""
    wishes: Mapping[str, AttributeValue] = field(default_factory=dict, hash=False)
    """Options of the command that made the scene, by name; empty without any."""
    measured: Mapping[str, AttributeValue] = field(default_factory=dict, hash=False)
    """Figures that the generator measured to meet the wishes: grade of difficulty, passage widths.
    """
    relief: Relief | None = None
    """Height of the ground; without it the ground is the plane z = 0."""

    def __post_init__(self) -> None:
        try:
            self._validate_frame()
            self._validate_hierarchy()
            self._validate_areas()
        except SceneError as error:
            raise error.within(f"scene {self.scene_id!r}") from None

    def _validate_frame(self) -> None:
        _require_name(self.scene_id, "scene_id", least=1)
        _require_name(self.theme, "theme")
        require_one_of(self.domain, SceneDomain, "domain")
        ok = 0 <= self.seed <= MOST_SEED
        valid = f"an integer from 0 to {MOST_SEED}"
        require(ok=ok, field_name="seed", value=self.seed, valid=valid)
        _require_point(self.extent_min_enu_m, "extent.min")
        _require_point(self.extent_max_enu_m, "extent.max")
        low, high = self.extent_min_enu_m, self.extent_max_enu_m
        ok = all(a < b <= a + MAX_EXTENT_M for a, b in zip(low, high, strict=True))
        valid = f"min below max and at most {MAX_EXTENT_M:g} m apart on each axis"
        require(ok=ok, field_name="extent", value=(low, high), valid=valid)
        self._validate_start()
        self._validate_relief()
        _require_numbers(self.wishes, "wishes")
        _require_numbers(self.measured, "measured")

    def _validate_start(self) -> None:
        low, high = self.extent_min_enu_m, self.extent_max_enu_m
        require_finite(self.start_position_enu_m, 3, "start.position")
        start = self.start_position_enu_m
        ok = all(a <= x <= b for a, x, b in zip(low, start, high, strict=True))
        valid = f"a point inside the extent, {low} to {high}"
        require(ok=ok, field_name="start.position", value=start, valid=valid)
        require_within((self.start_yaw_rad,), MOST_YAW_RAD, "start.yaw")
        ok = -90 <= self.latitude_deg <= 90
        require(ok=ok, field_name="latitude_deg", value=self.latitude_deg, valid="-90 to 90")
        ok = -180 <= self.longitude_deg <= 180
        require(ok=ok, field_name="longitude_deg", value=self.longitude_deg, valid="-180 to 180")
        lowest, highest = ALTITUDES_M
        ok = lowest <= self.altitude_m <= highest
        valid = f"{lowest:g} to {highest:g} m"
        require(ok=ok, field_name="altitude_m", value=self.altitude_m, valid=valid)

    def _validate_relief(self) -> None:
        """Require a relief over all of the flight volume, which reaches above and below it."""
        if self.relief is None:
            return
        for axis, name in enumerate(("x", "y")):
            low_m, high_m = self.extent_min_enu_m[axis], self.extent_max_enu_m[axis]
            first_m, last_m = self.relief.span_m(axis)
            ok = first_m <= low_m + _TOUCH_M and high_m <= last_m + _TOUCH_M
            valid = f"within {first_m:g} to {last_m:g}, as the relief reaches"
            require(ok=ok, field_name=f"extent.{name}", value=(low_m, high_m), valid=valid)
        low_m, high_m = self.extent_min_enu_m[2], self.extent_max_enu_m[2]
        lowest_m, highest_m = self.relief.min_m, self.relief.max_m
        ok = low_m <= lowest_m and highest_m < high_m
        valid = f"min at most {lowest_m:g} and max above {highest_m:g}, as the relief reaches"
        require(ok=ok, field_name="extent.z", value=(low_m, high_m), valid=valid)

    def _validate_hierarchy(self) -> None:
        # The limit bounds memory and the quadratic checks of pairs, for files from anywhere.
        if (count := len(self.objects)) > MOST_OBJECTS:
            raise SceneError(f"objects are {count}; valid: at most {MOST_OBJECTS}")
        seen: set[int] = set()
        for obj in self.objects:
            if obj.id in seen:
                raise SceneError(f"object {obj.id}: id is used twice; valid: an id of its own")
            # Parents before children: one pass finds missing parents and rules out cycles.
            if obj.parent_id is not None and obj.parent_id not in seen:
                raise SceneError(
                    f"object {obj.id}: parent_id is {obj.parent_id}; valid: null or the id of an "
                    "object that comes before it"
                )
            if obj.scene_id != self.scene_id:
                raise SceneError(
                    f"object {obj.id}: scene_id is {obj.scene_id!r}; valid: {self.scene_id!r}"
                )
            if not self._is_near(obj.bbox.p):
                raise SceneError(
                    f"object {obj.id}: bbox.p is {obj.bbox.p}; valid: at most {MAX_EXTENT_M:g} m "
                    "outside the extent"
                )
            seen.add(obj.id)

    def _is_near(self, p: Vector3) -> bool:
        bounds = zip(self.extent_min_enu_m, p, self.extent_max_enu_m, strict=True)
        return all(a - MAX_EXTENT_M <= x <= b + MAX_EXTENT_M for a, x, b in bounds)

    def _validate_areas(self) -> None:
        ids = {obj.id for obj in self.objects}
        seen: set[int] = set()
        for area in self.interaction_areas:
            where = f"interaction area {area.id}"
            if area.id in seen:
                raise SceneError(f"{where}: id is used twice; valid: an id of its own")
            if area.object_id is not None and area.object_id not in ids:
                raise SceneError(
                    f"{where}: object_id is {area.object_id}; valid: null or the id of an object"
                )
            seen.add(area.id)

    @cached_property
    def landing_areas(self) -> tuple[InteractionArea, ...]:
        """Areas that are wide enough to land on."""
        return tuple(area for area in self.interaction_areas if area.kind == "landing")

    @cached_property
    def perching_areas(self) -> tuple[InteractionArea, ...]:
        """Narrow areas, such as ledges, that carry a small drone."""
        return tuple(area for area in self.interaction_areas if area.kind == "perching")

    @cached_property
    def object_by_id(self) -> Mapping[int, SceneObject]:
        """Objects under their ids."""
        return {obj.id: obj for obj in self.objects}

    @cached_property
    def children_by_id(self) -> Mapping[int | None, tuple[SceneObject, ...]]:
        """Children of each object under its id, in file order; roots under None."""
        children: dict[int | None, list[SceneObject]] = {}
        for obj in self.objects:
            children.setdefault(obj.parent_id, []).append(obj)
        return {parent: tuple(group) for parent, group in children.items()}

    def ancestors(self, object_id: int) -> tuple[int, ...]:
        """Ids from the parent of an object up to its root, nearest first.

        Raises:
            KeyError: If there is no object of this id.
        """
        chain: list[int] = []
        parent = self.object_by_id[object_id].parent_id
        while parent is not None:
            chain.append(parent)
            parent = self.object_by_id[parent].parent_id
        return tuple(chain)
