"""Landing and perching areas derived from geometry: even, clear, and reachable from the start.

A candidate is an upward face with a slope of at most 10 degrees, of an object or of the ground of a
relief. Objects that stand on it or hang low over it are subtracted. In the rest the largest circles
are found one after another. Each becomes an area if a drone of some class can fly there from the
start. Faces of categories that may carry a drone bear landing areas. Faces that are too narrow for
that, and ledges, benches and wall tops, bear perching areas. Areas come from geometry and not from
labels, so that the same rule holds for every scene, whoever made it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import replace

from aeroscene.areas.bare_ground import above_ground, ground_faces
from aeroscene.areas.faces import Face, upward_faces
from aeroscene.areas.finder import AreaFinder, Candidate, is_wide
from aeroscene.areas.needs import AreaLimits
from aeroscene.areas.obstacles import Obstacles
from aeroscene.areas.reachability import access_field
from aeroscene.areas.spread import spread
from aeroscene.scene import DroneClass, InteractionArea, Scene, SceneObject
from aeroscene.scene.catalogue import LANDABLE, NO_PERCH, PADS
from aeroscene.solids.freespace import VoxelField
from aeroscene.solids.shapes import Primitive, scene_primitives
from aeroscene.solids.solids import colliding

__all__ = ["AreaLimits", "derive_interaction_areas"]

PERCH_HEIGHT_M = 0.3
"""Least height of a perch above the foot of its bearer."""
_CLASSES: tuple[DroneClass, ...] = ("small", "medium", "large")


def derive_interaction_areas(
    scene: Scene,
    primitives: Sequence[Primitive] | None = None,
    field: VoxelField | None = None,
    limits: AreaLimits | None = None,
) -> tuple[InteractionArea, ...]:
    """Derive the landing and perching areas of a scene from its geometry alone.

    Args:
        scene: The scene; areas that it has already are ignored.
        primitives: Its primitives, if the caller has them already.
        field: Its distance field, likewise.
        limits: Greatest number of areas of each kind and class; None sets no limit.

    Returns:
        Landing areas, then perching areas, each in the order of their bearers.
    """
    primitives = scene_primitives(scene) if primitives is None else primitives
    if field is None:
        field = access_field(scene, primitives)
    solids = colliding(primitives)
    finder = AreaFinder(scene, Obstacles(solids), field)
    faces = upward_faces(solids, lambda object_id: _may_bear(scene, object_id))
    # Outlines that the ground buries wholly are empty.
    faces = [shown for face in faces if not (shown := _unburied(scene, face)).outline.is_empty]
    bearers = [face for face in faces if is_wide(face) and _is_landable(scene, face)]
    bearers += ground_faces(scene)
    landing = _landing(scene, finder, bearers, limits)
    # After the landing areas, because a place to land is no perch.
    perches = _perch_faces(scene, faces, {candidate.face for candidate in landing})
    chosen = [*_limited(scene, landing, limits), *_perching(scene, finder, perches, limits)]
    return tuple(finder.area(candidate, number) for number, candidate in enumerate(chosen))


def _may_bear(scene: Scene, object_id: int) -> bool:
    obj = scene.object_by_id[object_id]
    return obj.category in LANDABLE or obj.category not in NO_PERCH


def _is_landable(scene: Scene, face: Face) -> bool:
    return _bearer(scene, face).category in LANDABLE


def _unburied(scene: Scene, face: Face) -> Face:
    """Return a level face without the parts that the ground of a relief covers."""
    if scene.relief is None or not face.is_level:
        return face
    outline = above_ground(scene, face.outline, face.height_at_origin_m)
    return face if outline is face.outline else replace(face, outline=outline)


def _bearer(scene: Scene, face: Face) -> SceneObject:
    """Return the object that has a face."""
    assert face.object_id is not None
    return scene.object_by_id[face.object_id]


def _landing(
    scene: Scene, finder: AreaFinder, faces: Sequence[Face], limits: AreaLimits | None
) -> list[Candidate]:
    """Return the best place of each face, then the next best of each, until there are enough."""
    growing = [(number, finder.landing(face)) for number, face in enumerate(faces)]
    found: list[tuple[int, Candidate]] = []
    candidates: list[Candidate] = []
    # Round by round, so that limits do not leave the last faces without any place.
    while growing and not _is_enough(candidates, limits):
        step = [(number, places, next(places, None)) for number, places in growing]
        growing = [(number, places) for number, places, place in step if place is not None]
        found += [(number, place) for number, _, place in step if place is not None]
        found.sort(key=lambda entry: entry[0])
        candidates = _one_per_fine_object(scene, [place for _, place in found])
    return candidates


def _is_enough(candidates: Sequence[Candidate], limits: AreaLimits | None) -> bool:
    if limits is None:
        return False
    counts = Counter(candidate.drone_class for candidate in candidates)
    return all(counts[name] >= getattr(limits, name) for name in _CLASSES)


def _one_per_fine_object(scene: Scene, candidates: Sequence[Candidate]) -> list[Candidate]:
    """Keep only the highest of the places on one fine object, such as a car's roof."""
    highest: dict[int | None, Candidate] = {}
    for candidate in candidates:
        best = highest.setdefault(candidate.face.object_id, candidate)
        if candidate.place_enu_m[2] > best.place_enu_m[2]:
            highest[candidate.face.object_id] = candidate
    return [
        candidate
        for candidate in candidates
        if candidate.face.object_id is None
        or _bearer(scene, candidate.face).is_coarse
        or candidate is highest[candidate.face.object_id]
    ]


def _limited(
    scene: Scene, candidates: Sequence[Candidate], limits: AreaLimits | None
) -> list[Candidate]:
    """Return the places that the limits leave, pads among them, in their own order."""
    if limits is None:
        return list(candidates)
    kept: list[int] = []
    for name in _CLASSES:
        members = [i for i, candidate in enumerate(candidates) if candidate.drone_class == name]
        places = [candidates[i].place_enu_m for i in members]
        limit = getattr(limits, name)
        pads = [k for k, i in enumerate(members) if _is_pad(scene, candidates[i])]
        kept += spread(places, scene.start_position_enu_m, limit, members.__getitem__, pads)
    return [candidates[i] for i in sorted(kept)]


def _is_pad(scene: Scene, candidate: Candidate) -> bool:
    """True if a place was made for landing."""
    face = candidate.face
    return face.object_id is not None and _bearer(scene, face).category in PADS


def _perch_faces(scene: Scene, faces: Sequence[Face], landed: AbstractSet[Face]) -> list[Face]:
    """Return faces that are high enough and bear no landing area.

    These are all such faces of a coarse object, and the highest of a fine one. A fine object with a
    landing area bears no perch beside it.
    """
    landed_ids = {face.object_id for face in landed}
    ledges: list[Face] = []
    highest: dict[int, Face] = {}
    for face in faces:
        obj = _bearer(scene, face)
        is_taken = face in landed or (not obj.is_coarse and obj.id in landed_ids)
        if obj.category in NO_PERCH or is_taken:
            continue
        z = _middle(face)[2]
        foot_m = obj.bbox.p[2] - obj.bbox.s[2] / 2
        if z - foot_m < PERCH_HEIGHT_M:
            continue
        if obj.is_coarse:
            ledges.append(face)
        elif obj.id not in highest or z > _middle(highest[obj.id])[2]:
            highest[obj.id] = face
    return [*ledges, *highest.values()]


def _middle(face: Face) -> tuple[float, float, float]:
    middle = face.outline.centroid
    return (middle.x, middle.y, face.height_m(middle.x, middle.y))


def _perching(
    scene: Scene, finder: AreaFinder, faces: Sequence[Face], limits: AreaLimits | None
) -> list[Candidate]:
    order = {face: number for number, face in enumerate(faces)}
    found = spread(
        [_middle(face) for face in faces],
        scene.start_position_enu_m,
        None if limits is None else limits.perching,
        lambda index: finder.perching(faces[index]),
    )
    return sorted(found, key=lambda candidate: order[candidate.face])
