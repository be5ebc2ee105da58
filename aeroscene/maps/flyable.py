"""Places of a map as scenes to fly in: ground, buildings, streets, trees, a start, landing areas.

Maps are flat drawings, so this module adds heights that the map lacks, kerbs, the trees of woods, a
start on open ground and the landing areas. Features that cannot be built are left out and counted,
so that a user sees how much of the map is missing.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from pathlib import Path

import shapely

from aeroscene.areas.needs import AreaLimits
from aeroscene.areas.reachability import FIELD_CAP_M
from aeroscene.areas.start import NO_START, Ground, with_start
from aeroscene.files.names import file_name
from aeroscene.files.visible import visible
from aeroscene.layouts.assembly import Assembly
from aeroscene.maps import building_facts, street_facts
from aeroscene.maps.barriers import is_barrier, raise_barriers
from aeroscene.maps.bounds import ALTITUDE_M, Bounds
from aeroscene.maps.buildings import raise_buildings
from aeroscene.maps.document import Feature, MapError, Tags
from aeroscene.maps.furniture import place_furniture
from aeroscene.maps.place import Place, locate
from aeroscene.maps.reader import read_map
from aeroscene.maps.site import Site
from aeroscene.maps.streets import lay_pavements, lay_streets
from aeroscene.maps.surfaces import is_ground, is_strip, lay_base, lay_surfaces
from aeroscene.maps.trees import is_tree, is_wood, plant_trees
from aeroscene.scene import Scene, SceneObject
from aeroscene.solids.freespace import build_distance_field
from aeroscene.solids.shapes import scene_primitives
from aeroscene.solids.solids import colliding
from aeroscene.validation.boxes import overlaps
from aeroscene.validation.support import floating

MOST_OBJECTS = 1_000
SKY_M = 8.0
"""Free height above the tallest object."""
LEAST_TOP_M = 25.0
MOST_TOP_M = 120.0
"""Top of the flight volume; taller buildings are cut there."""
_TOWN_SHARE, _HOUSES_SHARE = 0.35, 0.4
"""Built share of a town's ground, and share of houses from which its yards are gardens."""
_PHYSICAL = (
    "natural",
    "waterway",
    "leisure",
    "man_made",
    "barrier",
    "highway",
    "railway",
    "power",
    "landuse",
    "amenity",
)
"""Keys of visible features; an area's first one names its kind."""
_MOST_NAMED = 6
_LIMITS = AreaLimits(small=60, medium=60, large=60, perching=40)
_CELL_M = 0.25
_MOST_CELLS = 100_000_000
"""Number of cells that takes half a gigabyte. A larger place has larger cells, which err on the
safe side.
"""
_NOTHING = "no building, street, ground, fence or tree"
_HIDDEN = "below the ground or inside a building"
_OVERLAPS = "overlapping something else"
_FLOATS = "with nothing to stand on"


@dataclass(frozen=True, slots=True, kw_only=True)
class MapReport:
    """Report on the features of a map that became a scene."""

    n_features: int
    """Number of features within the bounds."""
    n_objects: int
    dropped: Mapping[str, int]
    """Number of features or pieces that are not in the scene, under the reason."""
    notes: Mapping[str, int]
    """Number of facts that the map lacks and that were assumed, under a sentence."""

    @property
    def lines(self) -> list[str]:
        """One line for each reason and assumption."""
        return [
            *(f"{count} left out: {reason}" for reason, count in sorted(self.dropped.items())),
            *(f"{count} {note}" for note, count in sorted(self.notes.items())),
        ]


def open_map(path: str | Path, bounds_text: str | None = None) -> tuple[Scene, MapReport]:
    """Open a part of a map file as a scene to fly in.

    Args:
        path: OSM XML, PBF or GeoJSON.
        bounds_text: West, south, east, north in degrees; None takes the bounds of the file.

    Raises:
        SceneError: If bounds or file are not valid, or nothing of the map can be used.
    """
    path = Path(path)
    raw, bounds = read_map(path, bounds_text)
    try:
        return make_place(locate(raw, bounds), scene_name(path, bounds))
    except MapError as error:
        raise error.within(f"map file {str(path)!r}") from None


def scene_name(path: Path, bounds: Bounds) -> str:
    """Name of a scene from a map: that of the file and the bounds."""
    return f"{file_name(path.name.partition('.')[0], 'map')}@{bounds}"


def make_place(place: Place, scene_id: str) -> tuple[Scene, MapReport]:
    """Build the scene of a place.

    Args:
        place: Features in metres.
        scene_id: Name of the scene.

    Returns:
        The scene, and a report on the features that were left out.

    Raises:
        MapError: If nothing of it could be used, it has too many objects, or no place to start.
    """
    site = Site(place, Assembly(scene_id))
    # What was lost while the file was read counts too.
    site.dropped.update(place.dropped)
    _build(site)
    if len(site.assembly.objects) > MOST_OBJECTS:
        raise MapError(
            f"{place.bounds} holds {len(site.assembly.objects)} objects; valid: at most "
            f"{MOST_OBJECTS}, name smaller bounds"
        )
    draft = _sound(site, _draft(site, scene_id))
    primitives = scene_primitives(draft)
    voxels = build_distance_field(draft, _cell_m(draft), primitives, FIELD_CAP_M)
    scene = with_start(draft, _grounds(site, draft), _LIMITS, primitives, voxels)
    if scene is None:
        raise MapError(f"{place.bounds} has {NO_START}")
    report = MapReport(
        n_features=len(place.features),
        n_objects=len(scene.objects),
        dropped=dict(site.dropped),
        notes=dict(site.notes),
    )
    return scene, report


def _cell_m(scene: Scene) -> float:
    """Edge of the cells in which free space is searched: twice as long in a large place."""
    low, high = scene.extent_min_enu_m, scene.extent_max_enu_m
    volume_m3 = math.prod(b - a for a, b in zip(low, high, strict=True))
    return _CELL_M if volume_m3 <= _MOST_CELLS * _CELL_M**3 else 2 * _CELL_M


def _build(site: Site) -> None:
    """Fill a site; earlier modules keep their ground."""
    areas, lines, points = (_of_dimension(site.place.features, k) for k in (2, 1, 0))
    buildings = _with(areas, building_facts.is_building)
    streets, paths = _with(lines, street_facts.is_street), _with(lines, street_facts.is_path)
    others = [f for f in areas if not building_facts.is_building(f.tags)]
    barriers, trees = _with([*lines, *areas], is_barrier), _with([*lines, *points], is_tree)
    ground = _with(others, is_ground)
    if not (buildings or streets or paths or trees or barriers or ground):
        raise MapError(f"{site.place.bounds} has {_NOTHING}; valid: a map with one of them there")
    hidden = _with(lines, street_facts.is_hidden_way)
    site.dropped[_HIDDEN] += len(hidden)
    used = (*buildings, *streets, *paths, *barriers, *trees, *ground, *hidden)
    _count_unknown(site, [*areas, *lines], {id(feature) for feature in used})
    # The base depends on whether the place is a town, which its buildings show.
    lay_base(site, is_town=_is_town(site, buildings))
    raise_buildings(site, buildings)
    lay_streets(site, streets)
    # Separate sidewalks belong to the street's pavements, other footways are surfaces.
    footways, walks = _split(paths, lambda tags: tags.get("footway") == "sidewalk")
    lay_pavements(site, streets, footways)
    rails_and_rivers = [f for f in lines if f not in paths and f not in streets]
    lay_surfaces(site, [*others, *walks, *rails_and_rivers])
    bands = [f.geometry.buffer(1.0) for f in paths]
    raise_barriers(site, barriers, [*site.carriageways.shapes, *bands], _gates(points))
    ways = [f.geometry for f in (*streets, *paths)]
    place_furniture(site, [f for f in points if f not in trees], ways)
    plant_trees(site, trees, _with(areas, is_wood))
    site.dropped += Counter()  # Without reasons that nothing was left out for.


def _count_unknown(site: Site, features: Sequence[Feature], used: AbstractSet[int]) -> None:
    """Count areas and lines of kinds that are not built; points are mostly addresses."""
    kinds = Counter(
        f"{key}={feature.tags[key]}"
        for feature in features
        if id(feature) not in used and not is_wood(feature.tags) and not is_strip(feature.tags)
        for key in [key for key in _PHYSICAL if key in feature.tags][:1]
    )
    if kinds:
        named = ", ".join(f"{visible(kind[:60])} {n}" for kind, n in kinds.most_common(_MOST_NAMED))
        more = ", ..." if len(kinds) > _MOST_NAMED else ""
        site.dropped[f"of kinds that are not built ({named}{more})"] += sum(kinds.values())


def _is_town(site: Site, buildings: Sequence[Feature]) -> bool:
    """Return true if the ground between buildings is paved: many of them, and few houses."""
    built = [(f.geometry.area, building_facts.category(f.tags)) for f in buildings]
    built_m2 = sum(area for area, _ in built)
    houses_m2 = sum(area for area, category in built if category == "house")
    is_dense = built_m2 > _TOWN_SHARE * site.place.area.area
    return is_dense and houses_m2 < _HOUSES_SHARE * built_m2


def _of_dimension(features: Sequence[Feature], dimension: int) -> list[Feature]:
    return [f for f in features if shapely.get_dimensions(f.geometry) == dimension]


def _with(features: Sequence[Feature], is_wanted: Callable[[Tags], bool]) -> list[Feature]:
    return [feature for feature in features if is_wanted(feature.tags)]


def _split(
    features: Sequence[Feature], is_first: Callable[[Tags], bool]
) -> tuple[list[Feature], list[Feature]]:
    first = _with(features, is_first)
    return first, [feature for feature in features if not is_first(feature.tags)]


def _gates(points: Sequence[Feature]) -> list[Feature]:
    kinds = {"gate", "entrance", "lift_gate", "swing_gate", "kissing_gate", "bollard", "stile"}
    return [f for f in points if f.tags.get("barrier") in kinds or "entrance" in f.tags]


def _draft(site: Site, scene_id: str) -> Scene:
    """The scene without a start and areas, which come later."""
    x0, y0, x1, y1 = site.place.area.bounds
    objects = [obj for obj in map(_below_the_top, site.assembly.objects) if obj is not None]
    top_m = max(float(obj.bbox.p[2] + obj.bbox.s[2] / 2) for obj in objects)
    high_m = round(max(top_m + SKY_M, LEAST_TOP_M), 2)
    return Scene(
        scene_id=scene_id,
        domain="outdoor",
        theme="map",
        seed=0,
        extent_min_enu_m=(x0, y0, 0.0),
        extent_max_enu_m=(x1, y1, high_m),
        start_position_enu_m=(x0, y0, 0.0),
        start_yaw_rad=0.0,
        latitude_deg=site.place.bounds.latitude_deg,
        longitude_deg=site.place.bounds.longitude_deg,
        altitude_m=ALTITUDE_M,
        objects=tuple(objects),
    )


def _below_the_top(obj: SceneObject) -> SceneObject | None:
    """Cut an object at the highest top that a flight volume may have; None if it is above."""
    p, s = obj.bbox.p, obj.bbox.s
    low, high = p[2] - s[2] / 2, p[2] + s[2] / 2
    if high <= MOST_TOP_M:
        return obj
    # The rest would be lower than a metre.
    if low >= MOST_TOP_M - 1.0:
        return None
    box = replace(
        obj.bbox,
        p=(p[0], p[1], round((low + MOST_TOP_M) / 2, 4)),
        s=(s[0], s[1], round(MOST_TOP_M - low, 4)),
    )
    return replace(obj, bbox=box)


def _sound(site: Site, scene: Scene) -> Scene:
    """The scene without objects that overlap others or float."""
    wrong: dict[int, str] = {}
    for finding in overlaps(scene):
        wrong.setdefault(_id(finding.object_id), _OVERLAPS)
    solids = colliding(scene_primitives(scene))
    for finding in floating(scene, solids):
        wrong.setdefault(_id(finding.object_id), _FLOATS)
    kept: list[SceneObject] = []
    gone = {obj.id for obj in site.assembly.objects} - {obj.id for obj in scene.objects}
    # Objects whose bearer is gone would float.
    for obj in scene.objects:
        if obj.id in wrong or obj.parent_id in gone:
            gone.add(obj.id)
            site.dropped[wrong.get(obj.id, _FLOATS)] += 1
        else:
            kept.append(obj)
    return replace(scene, objects=tuple(kept))


def _id(object_id: int | None) -> int:
    assert object_id is not None
    return object_id


def _grounds(site: Site, scene: Scene) -> list[list[Ground]]:
    """Ground where a flight may start: open ground first, then streets."""
    there = {obj.id for obj in scene.objects}
    covers = [c for c in site.covers[1:] if c.object_id in there]
    x0, y0, x1, y1 = site.place.area.bounds
    inner = shapely.box(x0 + 3, y0 + 3, x1 - 3, y1 - 3)
    taken = shapely.union_all(site.ground.shapes)
    ranks: list[list[Ground]] = [[], []]
    for number, cover in enumerate(covers):
        outline = shapely.intersection(cover.polygon, inner)
        # The tiles of the base lie below everything else, so that only their free part counts.
        if number < site.n_base:
            outline = shapely.difference(outline, taken)
        ranks[0 if cover.is_open else 1].append(Ground(outline, cover.top_m))
    return ranks
