"""Rooms of the corpus beside real ones: their sizes, how full they are, what lies where.

The figures are those of `aeroscene.corpus.curation.rooms.uses`, which names their sources.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from functools import cache
from itertools import combinations

import numpy as np
import pytest
import shapely

from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.composers.indoor import draw_plan
from aeroscene.corpus.curation.curate import curate_layout
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.indoor.themes import THEMES
from aeroscene.corpus.curation.interiors import furnish_room
from aeroscene.corpus.curation.room_space import RoomSpace
from aeroscene.corpus.curation.rooms.interior import GAP_M
from aeroscene.corpus.curation.shells import raise_shell
from aeroscene.scene import Scene, SceneObject

INDOOR = range(2, 92, 3)
MIXED = range(0, 45, 3)
DWELLING = frozenset(("bedroom", "living", "kitchen", "dining", "bathroom"))
LEAST_PER_100_M2 = {
    "apartments": 40.0, "hotel": 30.0, "office": 30.0, "clinic": 30.0, "supermarket": 30.0,
    "restaurant": 30.0, "library": 28.0, "school": 24.0, "station": 23.0,
}  # fmt: skip
"""Least fine objects on 100 m2 of a theme's floors, all of its scenes in the sample together."""
MEDIAN_M2 = {
    "bedroom": (11.0, 18.0), "living": (20.0, 32.0), "kitchen": (12.0, 24.0),
    "office": (11.0, 19.0), "meeting": (16.0, 28.0), "classroom": (45.0, 65.0),
    "bathroom": (9.0, 17.0), "washroom": (9.0, 24.0),
}  # fmt: skip
"""Between which areas the median of a use lies."""


@cache
def layouts(numbers: range) -> list[Scene]:
    """Scenes of the corpus without their landing areas."""
    return [curate_layout(number) for number in numbers]


def rooms_of(scene: Scene) -> dict[int, SceneObject]:
    return {obj.id: obj for obj in scene.objects if obj.category == "room"}


def floor_m2(room: SceneObject) -> float:
    return room.bbox.s[0] * room.bbox.s[1]


def contents(scene: Scene) -> dict[int, list[SceneObject]]:
    """The fine objects of each room."""
    rooms = rooms_of(scene)
    found: dict[int, list[SceneObject]] = {room: [] for room in rooms}
    for obj in scene.objects:
        room = next((i for i in scene.ancestors(obj.id) if i in rooms), None)
        if room is not None and not obj.is_coarse:
            found[room].append(obj)
    return found


def per_100_m2(pairs: Sequence[tuple[Scene, SceneObject]]) -> float:
    """Fine objects on 100 m2 of some rooms."""
    total = sum(len(contents(scene)[room.id]) for scene, room in pairs)
    return 100.0 * total / sum(floor_m2(room) for _, room in pairs)


def test_floors_of_each_theme_are_as_full_as_real_ones() -> None:
    by_theme: dict[str | None, list[tuple[Scene, SceneObject]]] = defaultdict(list)
    for scene in layouts(INDOOR):
        by_theme[scene.theme] += [(scene, room) for room in rooms_of(scene).values()]
    seen = set(by_theme) & set(LEAST_PER_100_M2)
    assert len(seen) >= 6
    for theme in seen:
        assert per_100_m2(by_theme[theme]) >= LEAST_PER_100_M2[str(theme)], theme


def test_rooms_of_mixed_scenes_are_as_full_as_real_ones() -> None:
    pairs = [(s, room) for s in layouts(MIXED) for room in rooms_of(s).values()]
    at_home = [(s, room) for s, room in pairs if room.attributes.get("use") in DWELLING]
    at_work = [
        (s, room)
        for s, room in pairs
        if room.attributes.get("use", "racks") not in DWELLING | {"racks"}
    ]
    assert len(at_home) >= 20
    assert len(at_work) >= 15
    assert per_100_m2(at_home) >= 40.0
    assert per_100_m2(at_work) >= 30.0


def test_sizes_of_rooms_by_use_are_those_of_real_ones() -> None:
    sizes: dict[str, list[float]] = defaultdict(list)
    for theme in THEMES:
        for seed in range(12):
            for zone in draw_plan(Draw(np.random.default_rng(seed)), theme).zones:
                if zone.role == "room":
                    sizes[zone.kind].append(zone.area)
                    assert max(zone.size) / min(zone.size) <= 2.6, zone
    bedrooms = np.array(sizes["bedroom"])
    assert np.mean((bedrooms >= 9.0) & (bedrooms <= 25.0)) >= 0.9
    for use, (low, high) in MEDIAN_M2.items():
        assert low <= np.median(sizes[use]) <= high, use


def test_rooms_of_furnished_houses_have_real_sizes_too() -> None:
    kinds = ("living", "kitchen", "bedroom", "bathroom", "bedroom")
    sizes: dict[str, list[float]] = defaultdict(list)
    for seed in range(20):
        builder, draw = Builder("s"), Draw(np.random.default_rng(seed))
        length = draw.count(3, 4) * draw.between(3.2, 3.36)
        shell = raise_shell(
            builder, draw, Frame(0.0, 0.0, 0.0), (0.0, 0.0), name="house", depth=8.4,
            length=round(length, 2), storeys=2, base=0.0, turn=0.0, colour="sand", kinds=kinds,
        )  # fmt: skip
        assert shell
        for space in shell.rooms:
            sizes[space.kind].append(space.placed.size[0] * space.placed.size[1])
    assert set(sizes) == set(kinds)
    bedrooms = np.array(sizes["bedroom"])
    assert np.mean((bedrooms >= 9.0) & (bedrooms <= 25.0)) >= 0.9
    assert 18.0 <= np.median(sizes["living"]) <= 34.0
    assert max(sizes["bathroom"]) <= 16.0


@pytest.mark.parametrize("theme", ["apartments", "hotel", "clinic", "office", "school"])
def test_buildings_in_which_people_stay_have_bathrooms(theme: str) -> None:
    (found,) = (each for each in THEMES if each.name == theme)
    plans = [draw_plan(Draw(np.random.default_rng(seed)), found) for seed in range(10)]
    kind = "bathroom" if theme in {"apartments", "hotel"} else "washroom"
    share = np.mean([any(zone.kind == kind for zone in plan.zones) for plan in plans])
    assert share >= 0.9


def furnished(kind: str, seed: int, size: tuple[float, float]) -> list[SceneObject]:
    """The fine objects of a room by itself."""
    builder = Builder("s")
    room = builder.place("room", Frame(0.0, 0.0, 0.0), (*size, 3.35), base=0.15)
    assert room
    for _ in furnish_room(builder, Draw(np.random.default_rng(seed)), RoomSpace(room, kind)):
        pass
    return builder.objects[1:]


@pytest.mark.parametrize("seed", range(6))
def test_stove_fridge_and_worktop_of_a_kitchen_stand_in_line(seed: int) -> None:
    objects = furnished("kitchen", seed, (4.4, 4.0))
    (stove,) = (obj for obj in objects if obj.category == "stove")
    (fridge,) = (obj for obj in objects if obj.category == "fridge")
    tops = [obj for obj in objects if obj.category == "counter"]
    assert any(are_in_line(stove, top) for top in tops)
    assert any(are_in_line(fridge, top) for top in tops)
    assert any(obj.parent_id in {top.id for top in tops} for obj in objects)


def are_in_line(first: SceneObject, second: SceneObject) -> bool:
    """Whether two pieces of furniture touch side by side and look the same way."""
    u, v = Frame(*first.bbox.p[:2], first.bbox.yaw_rad).local(*second.bbox.p[:2])
    is_beside = abs(abs(v) - (first.bbox.s[1] + second.bbox.s[1]) / 2) < 2e-3
    is_alike = abs(np.cos(first.bbox.yaw_rad - second.bbox.yaw_rad) - 1.0) < 1e-6
    return is_beside and is_alike and abs(u) < 0.1


@pytest.mark.parametrize("kind", ["kitchen", "living", "dining", "restaurant", "cafe"])
def test_plates_on_tables_have_a_cup_beside_them(kind: str) -> None:
    found: Counter[bool] = Counter()
    for seed in range(4):
        objects = furnished(kind, seed, (7.0, 6.0))
        tables = {obj.id for obj in objects if obj.category == "table"}
        cups = [obj for obj in objects if obj.category == "cup"]
        for plate in objects:
            if plate.category == "plate" and plate.parent_id in tables:
                own = [c.bbox.p for c in cups if c.parent_id == plate.parent_id]
                gaps = [np.hypot(*np.subtract(p, plate.bbox.p)[:2]) for p in own]
                found[min(gaps, default=9.0) < 0.3] += 1
    assert found[True] >= 4
    assert found[True] >= 0.8 * found.total()


FITTINGS = {"toilet": 0.6, "basin": 0.7, "bath": 0.6}
"""Fittings of a bathroom, and the depth of clear floor before each, m."""


def fitted_rooms(*uses: str) -> list[tuple[Scene, SceneObject, list[SceneObject]]]:
    """Rooms of some uses in the corpus, with the fittings that they hold."""
    found = []
    for scene in (*layouts(INDOOR), *layouts(MIXED)):
        rooms, held = rooms_of(scene), contents(scene)
        for number, room in rooms.items():
            if room.attributes.get("use") in uses:
                found.append((scene, room, [o for o in held[number] if o.category in FITTINGS]))
    return found


def test_bathrooms_have_a_toilet_a_basin_and_a_bath_or_shower() -> None:
    rooms = fitted_rooms("bathroom")
    assert len(rooms) >= 8
    kinds = [Counter(obj.category for obj in held) for _, _, held in rooms]
    complete = [kind for kind in kinds if kind == {"toilet": 1, "basin": 1, "bath": 1}]
    assert len(complete) >= 0.9 * len(kinds), kinds


def test_washrooms_have_rows_of_toilets_and_basins() -> None:
    rooms = fitted_rooms("washroom")
    assert len(rooms) >= 8
    kinds = [Counter(obj.category for obj in held) for _, _, held in rooms]
    assert all(kind["toilet"] and not kind["bath"] for kind in kinds), kinds
    assert np.mean([kind["basin"] > 0 for kind in kinds]) >= 0.9
    assert np.mean([kind["toilet"] >= 2 for kind in kinds]) >= 0.7


def test_fittings_stand_with_their_backs_to_walls_and_clear_floor_before_them() -> None:
    n = 0
    for scene, room, held in fitted_rooms("bathroom", "washroom"):
        others = [obj for obj in contents(scene)[room.id] if obj.parent_id == room.id]
        outlines = {
            obj.id: shapely.MultiPoint(obj.bbox.corners()[:, :2]).convex_hull for obj in others
        }
        for obj in held:
            frame = Frame(*obj.bbox.p[:2], obj.bbox.yaw_rad)
            back = Frame(*room.bbox.p[:2], room.bbox.yaw_rad).local(
                *frame.point(-obj.bbox.s[0] / 2, 0.0)
            )
            gaps = np.array(room.bbox.s[:2]) / 2 - np.abs(back)
            assert gaps.min() <= 2 * GAP_M, obj
            low, high = (
                obj.bbox.s[0] / 2 + 0.005,
                obj.bbox.s[0] / 2 + FITTINGS[obj.category] - 0.005,
            )
            half = obj.bbox.s[1] / 2 - 0.005
            clear = shapely.Polygon(
                [
                    frame.point(u, v)
                    for u, v in ((low, -half), (high, -half), (high, half), (low, half))
                ]
            )
            for other in others:
                assert not clear.intersects(outlines[other.id]), (obj, other)
            n += 1
    assert n >= 40


def test_no_fitting_stands_before_a_door() -> None:
    n = 0
    for scene, _, held in fitted_rooms("bathroom", "washroom"):
        doors = [
            obj for obj in scene.objects if obj.category == "wall" and "door_m" in obj.attributes
        ]
        for obj in held:
            outline = shapely.MultiPoint(obj.bbox.corners()[:, :2]).convex_hull
            for wall in doors:
                if abs(wall.bbox.p[2] - obj.bbox.p[2]) > 2.5:
                    continue
                x = wall.bbox.s[0]
                at, half = (
                    float(wall.attributes.get("door_offset_m", 0.0)),
                    float(wall.attributes["door_m"]) / 2,
                )
                frame = Frame(*wall.bbox.p[:2], wall.bbox.yaw_rad)
                reach = x / 2 + 0.8
                spot = (
                    (-reach, at - half),
                    (reach, at - half),
                    (reach, at + half),
                    (-reach, at + half),
                )
                ahead = shapely.Polygon([frame.point(u, v) for u, v in spot])
                assert ahead.intersection(outline).area < 1e-3, (scene.scene_id, obj, wall)
                n += 1
    assert n > 100


@pytest.mark.parametrize("kind", ["library", "office", "store", "bedroom", "aisles"])
def test_things_lie_on_the_boards_of_shelves(kind: str) -> None:
    objects = furnished(kind, 2, (7.0, 6.0))
    shelves = {obj.id: obj for obj in objects if obj.category == "shelf"}
    within = [
        obj
        for obj in objects
        if obj.parent_id in shelves and obj.bbox.p[2] < shelves[obj.parent_id].bbox.p[2] + 0.5
    ]
    assert len(within) >= len(shelves)


def test_extents_are_whole_centimetres_and_gaps_none_or_three() -> None:
    for scene in (*layouts(INDOOR)[:10], *layouts(MIXED)[:6]):
        for objects in contents(scene).values():
            sizes = np.array([obj.bbox.s for obj in objects]).reshape(-1, 3)
            assert np.mean(np.abs(100 * sizes - np.rint(100 * sizes)) < 1e-6) > 0.99
            assert not list(near_misses(objects))


def near_misses(objects: Sequence[SceneObject]) -> list[tuple[SceneObject, SceneObject]]:
    """Pairs on one bearer that neither touch nor keep the least gap, of those that share height."""
    outlines = [shapely.MultiPoint(obj.bbox.corners()[:, :2]).convex_hull for obj in objects]
    found = []
    for i, j in combinations(range(len(objects)), 2):
        first, second = objects[i], objects[j]
        share = abs(first.bbox.p[2] - second.bbox.p[2]) < (first.bbox.s[2] + second.bbox.s[2]) / 2
        gap = outlines[i].distance(outlines[j])
        if first.parent_id == second.parent_id and share and 0.002 < gap < GAP_M - 1e-4:
            found.append((first, second))
    return found
