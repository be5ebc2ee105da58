"""New objects in a region of a scene that stays as it is: they find room, or they go.

`aeroscene generate --redo SCENE --region ...` must not touch anything outside of the region.
Everything given is therefore pinned, and a new object that conflicts with it is moved or dropped.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import hypot

import shapely
from shapely.errors import ShapelyError

from aeroscene.areas.landing import derive_interaction_areas
from aeroscene.areas.reachability import FIELD_CAP_M
from aeroscene.areas.spread import spread
from aeroscene.areas.start import AWAY_M
from aeroscene.feasibility.layout import Layout, layout_of
from aeroscene.feasibility.projection import Feasible
from aeroscene.feasibility.region import Region
from aeroscene.feasibility.report import report_of
from aeroscene.feasibility.stages import project_beside
from aeroscene.scene import AreaKind, DroneClass, InteractionArea, Scene, SceneError
from aeroscene.scene.catalogue import PADS
from aeroscene.solids.freespace import VoxelField, build_distance_field
from aeroscene.solids.shapes import Primitive, scene_primitives
from aeroscene.solids.solids import colliding
from aeroscene.validation import Finding, validate
from aeroscene.validation.access import unreachable
from aeroscene.validation.boxes import outside, overlaps
from aeroscene.validation.support import floating

_Class = tuple[AreaKind, DroneClass]
_TALL_M = 1.0
"""Distance below a region at which a surface may lie that carries objects in it."""


def insert(scene: Scene, given: Scene, region: Region) -> Feasible:
    """Project the new objects of a scene, and derive the areas of a region anew.

    Args:
        scene: Remaining part of a given scene, with new objects behind it.
        given: The scene as it was, with its areas. Its remaining objects are neither moved nor
            changed.
        region: Box that holds the middles of new objects. Areas that do not extend into it stay as
            long as their claims hold.

    Returns:
        The scene. It is rejected if no new object has a place in the region, or if no landing area
        can be reached from the start any more.
    """
    layout = layout_of(scene, given.object_by_id)
    try:
        project_beside(layout)
        _drop_unsound(layout, region)
        found, rejection = _with_areas(_assembled(layout), given, region)
        # No unpinned object is left: nothing was inserted.
        if layout.is_pinned[layout.is_present].all():
            rejection = f"nothing new has a place in the region {region}; valid: a larger region"
    except (SceneError, ShapelyError) as error:
        found, rejection = scene, str(error)
    return Feasible(found, report_of(layout, rejection))


def _assembled(layout: Layout) -> Scene:
    """The scene in its present state, with the flight volume and the start that it had."""
    return replace(layout.scene, objects=layout.remaining(), interaction_areas=())


def _drop_unsound(layout: Layout, region: Region) -> None:
    """Drop new objects that are not in the region, or overlap, float or extend outside."""
    rows = {obj.id: row for row, obj in enumerate(layout.objects)}
    lost = [row for row in rows.values() if not region.holds(layout.box(row).p)]
    # Dropping one object may leave others without support, hence again until nothing is found.
    while True:
        lost = [row for row in lost if layout.is_present[row] and not layout.is_pinned[row]]
        for row in lost:
            layout.drop(row)
        found = [rows[each] for each in sorted(unsound(_assembled(layout)))]
        lost = [row for row in found if not layout.is_pinned[row]]
        if not lost:
            return


def unsound(scene: Scene) -> set[int]:
    """Ids of objects that overlap earlier ones, float, or extend outside.

    Args:
        scene: Scene; its areas do not matter.
    """
    solids = colliding(scene_primitives(scene))
    findings = [*overlaps(scene), *outside(scene), *floating(scene, solids)]
    return {finding.object_id for finding in findings if finding.object_id is not None}


def _with_areas(scene: Scene, given: Scene, region: Region) -> tuple[Scene, str | None]:
    """The scene with areas, and the reason why it cannot be used, if any."""
    primitives = scene_primitives(scene)
    field = build_distance_field(scene, primitives=primitives, cap_m=FIELD_CAP_M)
    outer = [area for area in given.interaction_areas if not _reaches_into(region, area)]
    # New areas replace those that the region had, class by class, so that limits still hold.
    n_free = Counter(map(_class_of, given.interaction_areas)) - Counter(map(_class_of, outer))
    there = {obj.id for obj in scene.objects} | {None}
    kept = [area for area in outer if area.object_id in there]
    # Numbers of areas that are gone are not used again.
    first_id = max((area.id for area in given.interaction_areas), default=-1) + 1
    inner = _inner_areas(scene, primitives, field, region, n_free)
    areas = (*kept, *(replace(area, id=first_id + n) for n, area in enumerate(inner)))
    scene = replace(scene, interaction_areas=areas)
    findings = validate(scene, primitives, field)
    wrong = {finding.area_id for finding in findings if finding.area_id is not None}
    sound = tuple(area for area in areas if area.id not in wrong)
    scene = replace(scene, interaction_areas=sound)
    return scene, _rejection(scene, given, findings)


def _inner_areas(
    scene: Scene,
    primitives: Sequence[Primitive],
    field: VoxelField,
    region: Region,
    limits: Mapping[_Class, int],
) -> list[InteractionArea]:
    """Areas that lie in the region, well spread, at most so many of each class."""
    outline, objects = region.outline, scene.object_by_id
    inside = [
        area
        for area in derive_interaction_areas(scene, primitives, field)
        if _reaches_into(region, area) and outline.covers(_polygon(area))
    ]
    found: list[InteractionArea] = []
    for name, limit in limits.items():
        members = [area for area in inside if _class_of(area) == name]
        bearers = (objects.get(-1 if a.object_id is None else a.object_id) for a in members)
        pads = [k for k, obj in enumerate(bearers) if obj and obj.category in PADS]
        places = [area.centroid for area in members]
        origin = scene.start_position_enu_m
        found += spread(places, origin, limit, members.__getitem__, pads)
    return found


def _reaches_into(region: Region, area: InteractionArea) -> bool:
    """Return true if an area, or the air above it, shares any space with a region."""
    low_m, z, high_m = region.low_enu_m[2], area.centroid[2], region.high_enu_m[2]
    is_level = low_m - _TALL_M <= z <= high_m
    return is_level and bool(shapely.area(region.outline.intersection(_polygon(area))) > 0)


def _polygon(area: InteractionArea) -> shapely.Polygon:
    return shapely.Polygon([(x, y) for x, y, _ in area.polygon])


def _class_of(area: InteractionArea) -> _Class:
    return area.kind, area.drone_class


def _rejection(scene: Scene, given: Scene, findings: Sequence[Finding]) -> str | None:
    """Reason why a scene can no longer be flown in; None if it can."""
    x, y, _ = scene.start_position_enu_m
    places = [area.centroid for area in scene.landing_areas]
    if not any(hypot(place[0] - x, place[1] - y) >= AWAY_M for place in places):
        return "no landing area away from the start is left; valid: one"
    stuck = [f for f in findings if f.kind == "unreachable" and f.area_id is None]
    # An unreachable start counts only if the given scene did not have it already.
    if stuck and not any(f.area_id is None for f in unreachable(given, scene_primitives(given))):
        return stuck[0].detail
    return None
