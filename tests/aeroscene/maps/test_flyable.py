from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
import shapely

from aeroscene.maps import MapError, MapReport, open_map
from aeroscene.maps.flyable import MOST_OBJECTS
from aeroscene.scene import Scene, SceneObject
from aeroscene.scene.footprint import footprint
from aeroscene.scene.io import scene_from_json, scene_to_json
from aeroscene.solids.shapes import object_primitives, scene_primitives
from aeroscene.solids.solids import colliding
from aeroscene.sources import load_scene
from aeroscene.validation import validate
from tests.aeroscene.maps.samples import L_SHAPE, SKEWED, OsmFile, bounds_text, town

WALL_M = 0.3
"""Farthest that a wall may stand from where the map has it."""
COURT = shapely.Polygon(
    [(10, -45), (45, -45), (45, -12), (10, -12)], [[(20, -35), (35, -35), (35, -22), (20, -22)]]
)


@pytest.fixture(scope="module")
def opened(tmp_path_factory) -> tuple[Scene, MapReport]:
    path = town().write(tmp_path_factory.mktemp("maps") / "town.osm")
    return open_map(path, bounds_text())


def made(file: OsmFile, tmp_path, *half_m: float) -> tuple[Scene, MapReport]:
    return open_map(file.write(tmp_path / "map.osm"), bounds_text(*half_m))


def of(scene: Scene, *categories: str) -> list[SceneObject]:
    return [obj for obj in scene.objects if obj.category in categories]


def walls(obj: SceneObject) -> shapely.Geometry:
    """What of an object collides, seen from above."""
    solids = colliding(object_primitives(obj))
    return shapely.union_all(
        [shapely.MultiPoint(solids.points(k)[:, :2]).convex_hull for k in range(len(solids))]
    )


def top_m(obj: SceneObject) -> float:
    return obj.bbox.p[2] + obj.bbox.s[2] / 2


def test_a_town_has_nothing_wrong_with_it(opened):
    scene, _ = opened
    assert validate(scene) == ()


def test_everything_of_the_map_is_there(opened):
    scene, report = opened
    counts = Counter(obj.category for obj in scene.objects)
    assert counts["house"] == 1
    assert counts["building"] == 2
    assert counts["roof"] == 3
    assert counts["tree"] >= 4
    assert counts["water"] == counts["bin"] == counts["street_lamp"] == 1
    assert counts["traffic_light"] == 1
    assert counts["fence"] >= 2
    assert counts["road"] >= 4
    assert report.dropped == {"inside a building": 1}


def test_the_start_is_on_open_ground_and_areas_are_all_over_the_place(opened):
    scene, _ = opened
    start = shapely.Point(scene.start_position_enu_m[:2])
    solid = of(scene, "house", "building", "road", "water", "tree", "fence")
    assert all(footprint(obj).distance(start) > 0.5 for obj in solid)
    bearers = {scene.object_by_id[a.object_id].category for a in scene.landing_areas}
    assert {"lawn", "roof"} <= bearers


@pytest.mark.parametrize(
    ("category", "outline"),
    [
        ("house", shapely.Polygon(L_SHAPE)),
        ("building", shapely.Polygon(SKEWED)),
        ("building", COURT),
        ("roof", shapely.Polygon(L_SHAPE)),
        ("roof", COURT),
    ],
)
def test_walls_and_roofs_stand_within_30_cm_of_their_outline(opened, category, outline):
    scene, _ = opened
    near = [obj for obj in of(scene, category) if footprint(obj).intersects(outline)]
    gap_m = min(walls(obj).boundary.hausdorff_distance(outline.boundary) for obj in near)
    assert gap_m < WALL_M


def test_a_court_is_open_to_the_sky(opened):
    scene, _ = opened
    solids = colliding(scene_primitives(scene))
    inside = np.array([27.0, -28.0])
    covering = [
        scene.object_by_id[solids.object_id[k]].category
        for k in range(len(solids))
        if shapely.MultiPoint(solids.points(k)[:, :2]).convex_hull.covers(shapely.Point(inside))
    ]
    assert set(covering) <= {"lawn", "plaza"}


def test_heights_follow_height_and_storeys(opened):
    scene, _ = opened
    office = next(b for b in of(scene, "building") if footprint(b).covers(shapely.Point(22, 22)))
    roof = next(r for r in of(scene, "roof") if r.parent_id == office.id)
    assert top_m(roof) == pytest.approx(14.04, abs=0.02)
    house = of(scene, "house")[0]
    assert top_m(house) == pytest.approx(2 * 3.0 + 0.3 + 0.04, abs=0.02)


def test_pavements_lie_a_kerb_above_the_carriageway(opened):
    scene, _ = opened
    (road,) = {round(top_m(obj), 3) for obj in of(scene, "road")}
    pavements = {round(top_m(obj), 3) for obj in of(scene, "sidewalk") if obj.bbox.s[2] > 0.1}
    assert pavements == {round(road + 0.10, 3)}


def test_covers_do_not_lie_on_each_other(opened):
    scene, _ = opened
    covers = [footprint(obj) for obj in of(scene, "road", "sidewalk", "water", "parking_lot")]
    total = sum(cover.area for cover in covers)
    assert shapely.union_all(covers).area == pytest.approx(total, rel=1e-3)


def test_a_road_with_lanes_is_as_wide_as_they_are(opened):
    scene, _ = opened
    widths = {obj.attributes.get("lanes"): obj.bbox.s[1] for obj in of(scene, "road")}
    assert widths[2] in (pytest.approx(6.0, abs=0.02), pytest.approx(5.0, abs=0.02))


def test_the_same_map_gives_the_same_scene_and_survives_its_file(opened, tmp_path):
    scene, _ = opened
    again, _ = made(town(), tmp_path)
    assert scene_to_json(again).replace(b"map@", b"town@") == scene_to_json(scene)
    assert scene_from_json(scene_to_json(scene)) == scene


def test_a_map_has_a_name_as_other_scenes_do(tmp_path, caplog):
    path = town().write(tmp_path / "town.osm")
    scene = load_scene(f"{path}#{bounds_text()}")
    assert scene.scene_id.startswith("town@17.99")
    assert "1 left out: inside a building" in caplog.text


PARTS = [
    # storeys of a part, where it begins, where it ends
    ([(-10, -10), (0, -10), (0, 10), (-10, 10)], {"height": "6"}, (0.04, 6.04)),
    ([(0, -10), (10, -10), (10, 10), (0, 10)], {"height": "12", "min_height": "0"}, (0.04, 12.04)),
    ([(2, -4), (8, -4), (8, 4), (2, 4)], {"height": "20", "min_height": "12"}, (12.04, 20.04)),
]


def test_parts_of_a_building_stand_on_each_other(tmp_path):
    file = OsmFile()
    file.area([(-10, -10), (10, -10), (10, 10), (-10, 10)], {"building": "yes", "height": "20"})
    for outline, tags, _ in PARTS:
        file.area(outline, {"building:part": "yes", "roof:shape": "flat", **tags})
    scene, report = made(file, tmp_path, 40, 40)
    assert not report.dropped
    assert validate(scene) == ()
    for outline, _, (low, high) in PARTS:
        point = shapely.Polygon(outline).buffer(-0.5).exterior.interpolate(0)
        there = [
            o
            for o in of(scene, "building", "house", "tower", "garage", "roof")
            if footprint(o).covers(point) and low - 0.01 <= o.bbox.p[2] <= high
        ]
        assert min(o.bbox.p[2] - o.bbox.s[2] / 2 for o in there) == pytest.approx(low, abs=0.01)
        assert max(top_m(o) for o in there) == pytest.approx(high, abs=0.01)


def test_a_part_over_nothing_reaches_down_to_the_ground(tmp_path):
    file = OsmFile()
    corners = [(-6, -5), (6, -5), (6, 5), (-6, 5)]
    file.area(corners, {"building:part": "yes", "min_height": "6", "height": "9"})
    scene, report = made(file, tmp_path, 30, 30)
    assert "1 parts of buildings with nothing below them" in " ".join(report.lines)
    assert validate(scene) == ()


def test_buildings_that_overlap_in_the_map_do_not_in_the_scene(tmp_path):
    file = OsmFile()
    file.area([(-10, -10), (6, -10), (6, 10), (-10, 10)], {"building": "yes", "height": "9"})
    file.area([(0, -6), (15, -6), (15, 6), (0, 6)], {"building": "yes", "height": "6"})
    scene, _ = made(file, tmp_path, 40, 40)
    assert validate(scene) == ()
    low = next(obj for obj in of(scene, "house", "building") if obj.bbox.p[0] > 3)
    assert footprint(low).bounds[0] == pytest.approx(6.0, abs=0.05)


ROOFS = {
    "gabled": 1,
    "hipped": 1,
    "pyramidal": 1,
    "skillion": 1,
    "flat": 0,
    "half-hipped": 1,
}


@pytest.mark.parametrize("shape", ROOFS)
@pytest.mark.parametrize("outline", [L_SHAPE, SKEWED, ((-8, -5), (8, -5), (8, 5), (-8, 5))])
def test_roofs_have_the_shape_that_the_map_says(tmp_path, shape, outline):
    file = OsmFile()
    x, y = shapely.Polygon(outline).centroid.coords[0]
    corners = [(px - x, py - y) for px, py in outline]
    tags = {"building": "yes", "height": "9", "roof:shape": shape, "roof:height": "3"}
    file.area(corners, tags)
    scene, _ = made(file, tmp_path, 40, 40)
    assert validate(scene) == ()
    (roof,) = of(scene, "roof")
    assert top_m(roof) == pytest.approx(9.04, abs=0.02)
    is_flat = all(p.kind == "box" or _is_level(p) for p in object_primitives(roof))
    assert is_flat == (ROOFS[shape] == 0)


def _is_level(primitive) -> bool:
    """Whether a mesh is an upright prism."""
    low = min(z for _, _, z in primitive.vertices_m)
    lower = {(x, y) for x, y, z in primitive.vertices_m if z == low}
    return lower == {(x, y) for x, y, z in primitive.vertices_m if z > low}


def test_streets_under_the_ground_are_left_out_and_counted(tmp_path):
    file = OsmFile()
    file.way([(-50, 5), (50, 5)], {"highway": "primary", "tunnel": "yes"})
    file.way([(-50, -5), (50, -5)], {"highway": "residential"})
    scene, report = made(file, tmp_path, 40, 40)
    assert report.dropped == {"below the ground or inside a building": 1}
    assert all(obj.bbox.p[1] < 0 for obj in of(scene, "road"))


def test_a_map_without_anything_we_have_is_refused(tmp_path):
    file = OsmFile()
    file.node((0, 0), name="nothing")
    with pytest.raises(
        MapError, match=r"map\.osm': .* has no building, street, ground, fence or tree"
    ):
        made(file, tmp_path)


def test_more_objects_than_the_bound_are_refused_with_their_number(tmp_path, monkeypatch):
    monkeypatch.setattr("aeroscene.maps.flyable.MOST_OBJECTS", 10)
    with pytest.raises(MapError, match=r"holds \d+ objects; valid: at most 10"):
        made(town(), tmp_path)
    assert MOST_OBJECTS == 1_000


def test_a_place_full_of_one_building_has_a_start_on_its_roof_or_says_why(tmp_path):
    file = OsmFile()
    file.area([(-80, -80), (80, -80), (80, 80), (-80, 80)], {"building": "yes"})
    with pytest.raises(MapError, match="no free place to start from"):
        made(file, tmp_path, 30, 30)


def test_crowns_are_cut_to_the_room_between_trees(tmp_path):
    file = OsmFile()
    for k in range(5):
        file.node((3.0 * k - 6, 0), natural="tree", diameter_crown="8", height="10")
    scene, _ = made(file, tmp_path, 30, 30)
    assert len(of(scene, "tree")) == 5
    assert validate(scene) == ()
    assert all(obj.bbox.s[0] < 3.0 for obj in of(scene, "tree"))


def test_a_gate_opens_a_fence(tmp_path):
    file = OsmFile()
    file.way([(-20, 0), (20, 0)], {"barrier": "fence"})
    file.node((0, 0), barrier="gate")
    scene, _ = made(file, tmp_path, 30, 30)
    fences = of(scene, "fence")
    assert len(fences) == 2
    assert all(footprint(obj).distance(shapely.Point(0, 0)) > 1.0 for obj in fences)


def test_signals_of_a_crossing_stand_beside_the_street(opened):
    scene, _ = opened
    (light,) = of(scene, "traffic_light")
    roads = shapely.union_all([footprint(obj) for obj in of(scene, "road")])
    assert not roads.intersects(footprint(light))
