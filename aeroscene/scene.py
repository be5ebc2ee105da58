"""The scene document: objects, hierarchy, landing areas. Frozen and validated.

The fields are those of the paper's section "AeroScene Dataset Statistic and Labels". World frame
ENU in metres, quaternions `wxyz` body to world. A document that exists is valid: construction
raises `SceneError` otherwise, with one line that names scene, object and field.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Literal, get_args

from aeroscene.catalogue import CATALOGUE
from aeroscene.polygon import distance_inside, is_simple, signed_area

if TYPE_CHECKING:
    import numpy as np
    from jaxtyping import Float

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
AttributeValue = str | float | int | bool
ObjectDomain = Literal["indoor", "outdoor"]
SceneDomain = Literal["indoor", "outdoor", "mixed"]
DroneClass = Literal["small", "medium", "large"]
AreaKind = Literal["landing", "perching"]

UNIT_TOLERANCE = 1e-4
"""Allowed deviation of a quaternion's norm from one: layouts rounded to 4 decimals still pass."""
MIN_SIZE_M = 0.001
MAX_EXTENT_M = 1000.0
"""Longest side of a flight volume and of a box, and farthest that an object lies outside it."""
INSCRIBED_TOLERANCE_M = 0.01
"""By how much an area's radius may exceed the distance from its centroid to its border."""


class SceneError(ValueError):
    """A scene that breaks a rule of the schema; one line saying where, what and what is valid."""

    def within(self, where: str) -> SceneError:
        """The same error with the place that contains it in front."""
        return type(self)(f"{where}: {self}")


def _require(*, ok: bool, field_name: str, value: object, valid: str) -> None:
    if not ok:
        raise SceneError(f"{field_name} is {value!r}, valid: {valid}")


def _require_finite(values: Sequence[float], count: int, field_name: str) -> None:
    ok = len(values) == count and all(math.isfinite(v) for v in values)
    _require(ok=ok, field_name=field_name, value=values, valid=f"{count} finite numbers")


def _require_one_of(value: str, choices: object, field_name: str) -> None:
    valid = get_args(choices)
    _require(ok=value in valid, field_name=field_name, value=value, valid=", ".join(valid))


@dataclass(frozen=True, slots=True)
class OrientedBox:
    """A box by centre, attitude and full extents: the paper's (p, q, s)."""

    p: Vector3
    """Centre, ENU, m."""
    q: Quaternion
    """Unit quaternion wxyz, box to world."""
    s: Vector3
    """Full local extents, m, each positive."""

    def __post_init__(self) -> None:
        _require_finite(self.p, 3, "bbox.p")
        _require_finite(self.q, 4, "bbox.q")
        _require_finite(self.s, 3, "bbox.s")
        norm = math.hypot(*self.q)
        _require(
            ok=abs(norm - 1.0) <= UNIT_TOLERANCE,
            field_name="bbox.q",
            value=self.q,
            valid=f"a quaternion wxyz of norm 1 (this one has {norm:.6g})",
        )
        _require(
            ok=min(self.s) >= MIN_SIZE_M and max(self.s) <= MAX_EXTENT_M,
            field_name="bbox.s",
            value=self.s,
            valid=f"three extents from {MIN_SIZE_M} to {MAX_EXTENT_M:g} m",
        )

    @property
    def yaw_rad(self) -> float:
        """Heading of the box's x axis, counter-clockwise from east."""
        w, x, y, z = self.q
        return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))

    @property
    def is_upright(self) -> bool:
        """Whether the box turns about the vertical only."""
        return math.hypot(self.q[1], self.q[2]) < 1e-6

    def corners(self) -> Float[np.ndarray, "8 3"]:
        """The eight corners, ENU, m; bit 0, 1, 2 of the row is the sign along x, y, z."""
        from aeroscene.geometry import box_corners  # noqa: PLC0415 - keeps numpy optional here

        return box_corners(self.p, self.q, self.s)


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
    """What the box does not say: colour, storeys, form, kind of room."""

    def __post_init__(self) -> None:
        try:
            self._validate()
        except SceneError as error:
            raise error.within(f"object {self.id}") from None

    def _validate(self) -> None:
        _require(ok=self.id >= 0, field_name="id", value=self.id, valid="an integer from 0")
        _require(
            ok=self.category_id in CATALOGUE,
            field_name="category_id",
            value=self.category_id,
            valid=f"1 to {len(CATALOGUE)}",
        )
        _require_one_of(self.domain, ObjectDomain, "domain")
        for name, value in self.attributes.items():
            if isinstance(value, float):
                _require_finite((value,), 1, f"attributes.{name}")

    @property
    def category(self) -> str:
        """Name of the category."""
        return CATALOGUE[self.category_id].name

    @property
    def is_coarse(self) -> bool:
        """Whether the category is one of the 23 coarse ones."""
        return CATALOGUE[self.category_id].level == "coarse"


@dataclass(frozen=True, slots=True, kw_only=True)
class InteractionArea:
    """Where a drone may land: a flat, clear polygon and the largest circle about its centroid."""

    id: int
    kind: AreaKind = "landing"
    """Perching areas are too narrow to land on without care: ledges, wall tops, benches."""
    object_id: int | None
    """The object that bears the area; None is the bare ground."""
    polygon: tuple[Vector3, ...]
    """Border, ENU, m, counter-clockwise from above, not closed."""
    centroid: Vector3
    """Touchdown point, ENU, m."""
    radius: float
    """Radius of the circle about the centroid that lies within the polygon, m."""
    drone_class: DroneClass
    """The largest class of drone that fits."""
    slope_rad: float
    clearance_m: float
    """Free height above the surface, m; capped where nothing is above."""
    surface: str
    """What the landing gear meets: asphalt, grass, concrete, metal, wood, fabric..."""

    def __post_init__(self) -> None:
        try:
            self._validate()
        except SceneError as error:
            raise error.within(f"interaction area {self.id}") from None

    def _validate(self) -> None:
        _require_one_of(self.drone_class, DroneClass, "drone_class")
        _require_one_of(self.kind, AreaKind, "kind")
        ok = len(self.polygon) >= 3
        _require(ok=ok, field_name="polygon", value=self.polygon, valid="at least 3 vertices")
        for index, vertex in enumerate(self.polygon):
            _require_finite(vertex, 3, f"polygon[{index}]")
        _require_finite(self.centroid, 3, "centroid")
        _require_finite((self.radius, self.clearance_m), 2, "radius and clearance_m")
        _require(ok=self.radius > 0, field_name="radius", value=self.radius, valid="above 0 m")
        ok = 0 <= self.slope_rad < math.pi / 2
        _require(ok=ok, field_name="slope_rad", value=self.slope_rad, valid="0 to below pi/2")
        ok = self.clearance_m > 0
        _require(ok=ok, field_name="clearance_m", value=self.clearance_m, valid="above 0 m")
        self._validate_polygon()

    def _validate_polygon(self) -> None:
        outline = [(x, y) for x, y, _ in self.polygon]
        valid = "a simple polygon, counter-clockwise seen from above"
        ok = signed_area(outline) > 0 and is_simple(outline)
        _require(ok=ok, field_name="polygon", value=self.polygon, valid=valid)
        inside_m = distance_inside(outline, self.centroid[0], self.centroid[1])
        _require(
            ok=inside_m > 0,
            field_name="centroid",
            value=self.centroid,
            valid="a point inside the polygon",
        )
        _require(
            ok=self.radius <= inside_m + INSCRIBED_TOLERANCE_M,
            field_name="radius",
            value=self.radius,
            valid=f"at most {inside_m:.3f} m, the distance from the centroid to the border",
        )


@dataclass(frozen=True, kw_only=True)
class Scene:
    """A place to fly in: what stands where, where the flight starts, where it may end."""

    scene_id: str
    domain: SceneDomain
    seed: int
    extent_min_enu_m: Vector3
    """Lower corner of the flight volume."""
    extent_max_enu_m: Vector3
    """Upper corner of the flight volume."""
    start_position_enu_m: Vector3
    """Where the landing gear stands at the start: a point ON a surface."""
    start_yaw_rad: float
    latitude_deg: float
    """Geodetic place of the ENU origin, WGS 84."""
    longitude_deg: float
    altitude_m: float
    """Height of the ENU origin above mean sea level."""
    objects: tuple[SceneObject, ...]
    """Parents come before their children."""
    interaction_areas: tuple[InteractionArea, ...] = ()

    def __post_init__(self) -> None:
        try:
            self._validate_frame()
            self._validate_hierarchy()
            self._validate_areas()
        except SceneError as error:
            raise error.within(f"scene {self.scene_id!r}") from None

    def _validate_frame(self) -> None:
        ok = bool(self.scene_id)
        _require(ok=ok, field_name="scene_id", value=self.scene_id, valid="a non-empty name")
        _require_one_of(self.domain, SceneDomain, "domain")
        _require(ok=self.seed >= 0, field_name="seed", value=self.seed, valid="an integer from 0")
        _require_finite(self.extent_min_enu_m, 3, "extent.min")
        _require_finite(self.extent_max_enu_m, 3, "extent.max")
        low, high = self.extent_min_enu_m, self.extent_max_enu_m
        ok = all(a < b <= a + MAX_EXTENT_M for a, b in zip(low, high, strict=True))
        valid = f"min below max and at most {MAX_EXTENT_M:g} m apart on each axis"
        _require(ok=ok, field_name="extent", value=(low, high), valid=valid)
        _require_finite(self.start_position_enu_m, 3, "start.position")
        start = self.start_position_enu_m
        ok = all(a <= x <= b for a, x, b in zip(low, start, high, strict=True))
        valid = f"a point inside the extent, {low} to {high}"
        _require(ok=ok, field_name="start.position", value=start, valid=valid)
        _require_finite((self.start_yaw_rad,), 1, "start.yaw")
        ok = -90 <= self.latitude_deg <= 90
        _require(ok=ok, field_name="latitude_deg", value=self.latitude_deg, valid="-90 to 90")
        ok = -180 <= self.longitude_deg <= 180
        _require(ok=ok, field_name="longitude_deg", value=self.longitude_deg, valid="-180 to 180")
        _require_finite((self.altitude_m,), 1, "altitude_m")

    def _validate_hierarchy(self) -> None:
        seen: set[int] = set()
        for obj in self.objects:
            if obj.id in seen:
                raise SceneError(f"object {obj.id}: id is used twice, valid: an id of its own")
            if obj.parent_id is not None and obj.parent_id not in seen:
                raise SceneError(
                    f"object {obj.id}: parent_id is {obj.parent_id}, valid: null or the id of an "
                    "object that comes before it"
                )
            if obj.scene_id != self.scene_id:
                raise SceneError(
                    f"object {obj.id}: scene_id is {obj.scene_id!r}, valid: {self.scene_id!r}"
                )
            if not self._is_near(obj.bbox.p):
                raise SceneError(
                    f"object {obj.id}: bbox.p is {obj.bbox.p}, valid: at most {MAX_EXTENT_M:g} m "
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
                raise SceneError(f"{where}: id is used twice, valid: an id of its own")
            if area.object_id is not None and area.object_id not in ids:
                raise SceneError(
                    f"{where}: object_id is {area.object_id}, valid: null or the id of an object"
                )
            seen.add(area.id)

    @cached_property
    def landing_areas(self) -> tuple[InteractionArea, ...]:
        """Areas wide enough to land on."""
        return tuple(area for area in self.interaction_areas if area.kind == "landing")

    @cached_property
    def perching_areas(self) -> tuple[InteractionArea, ...]:
        """Narrow areas that bear a small drone."""
        return tuple(area for area in self.interaction_areas if area.kind == "perching")

    @cached_property
    def object_by_id(self) -> Mapping[int, SceneObject]:
        """Objects under their ids."""
        return {obj.id: obj for obj in self.objects}

    @cached_property
    def children_by_id(self) -> Mapping[int | None, tuple[SceneObject, ...]]:
        """Children under their parent's id; roots under None."""
        children: dict[int | None, list[SceneObject]] = {}
        for obj in self.objects:
            children.setdefault(obj.parent_id, []).append(obj)
        return {parent: tuple(group) for parent, group in children.items()}

    def ancestors(self, object_id: int) -> tuple[int, ...]:
        """Ids from the parent of an object up to its root."""
        chain: list[int] = []
        parent = self.object_by_id[object_id].parent_id
        while parent is not None:
            chain.append(parent)
            parent = self.object_by_id[parent].parent_id
        return tuple(chain)
