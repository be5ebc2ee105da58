"""Districts: streets that meet, blocks with a hierarchy, towers that repeat their plan, counts."""

import math
from collections import Counter
from functools import cache

import numpy as np
import pytest

from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.districts import DistrictError, DistrictRequest, compose_district
from aeroscene.corpus.districts.network import lay_network
from aeroscene.scene.catalogue import BUILDINGS
from aeroscene.validation import validate

SMALL = {"seed": 5, "outline_m": (130.0, 110.0)}


@cache
def district(**asked):
    return compose_district(DistrictRequest(**asked))


def block_of(scene, obj):
    """Ground of the block that an object belongs to, None for streets and traffic."""
    while obj.parent_id is not None:
        obj = scene.object_by_id[obj.parent_id]
    return obj if obj.attributes.get("part") == "block" else None


@pytest.mark.parametrize("seed", range(20))
def test_every_street_ends_at_the_border_or_at_a_street(seed):
    network = lay_network((260.0, 200.0), np.random.default_rng(seed))
    roads = [road.placed for road in network.site.roads]
    assert len(roads) > 6
    for road in roads:
        for end in (-1, 1):
            x, y = road.frame.point(end * road.size[0] / 2, 0.0)
            is_at_border = math.isclose(abs(x), 130.0) or math.isclose(abs(y), 100.0)
            beyond = road.frame.point(end * (road.size[0] / 2 + 0.01), 0.0)
            assert is_at_border or any(holds(other, beyond) for other in roads if other != road)


@pytest.mark.parametrize("seed", range(20))
def test_blocks_and_streets_cover_the_ground_without_overlap(seed):
    network = lay_network((260.0, 200.0), np.random.default_rng(seed))
    taken = Builder("ground")
    covered_m2 = 0.0
    for road in network.site.roads:
        covered_m2 += road.placed.size[0] * road.placed.size[1]
        assert taken.place("road", road.placed.frame, road.placed.size)
    for block in network.blocks:
        area = block.area
        width, depth = area.x1 - area.x0, area.y1 - area.y0
        covered_m2 += width * depth
        middle = Frame((area.x0 + area.x1) / 2, (area.y0 + area.y1) / 2, 0.0)
        assert taken.place("plaza", middle, (width, depth, 0.1))
    assert covered_m2 == pytest.approx(260.0 * 200.0, rel=1e-3)


def holds(road, point):
    u, v = road.frame.local(*point)
    return abs(u) <= road.size[0] / 2 and abs(v) <= road.size[1] / 2


def test_a_district_is_sound_and_the_same_on_every_call():
    scene = district(**SMALL)
    assert not list(validate(scene))
    assert compose_district(DistrictRequest(**SMALL)) == scene
    assert scene.extent_max_enu_m[:2] == (65.0, 55.0)
    assert scene.wishes == {"outline": "130,110"}


def test_what_stands_in_a_block_belongs_to_it_down_to_the_plates():
    scene = district(seed=4, n_storeys=3)
    assert not list(validate(scene))
    blocks = {obj.id for obj in scene.objects if obj.attributes.get("part") == "block"}
    assert len(blocks) >= 4
    for obj in scene.objects:
        block = block_of(scene, obj)
        if obj.category in BUILDINGS | {"room", "table", "bed", "tree", "lawn"}:
            assert block is not None, obj
        if block is not None and block.id != obj.id:
            assert all(
                abs(a - b) <= size / 2 + 0.5
                for a, b, size in zip(obj.bbox.p, block.bbox.p, block.bbox.s[:2], strict=False)
            )
    indoors = [obj for obj in scene.objects if obj.domain == "indoor"]
    depths = Counter(_depth(scene, obj) for obj in indoors)
    # Block, building, room, furniture, what lies on it.
    assert max(depths) >= 4


def _depth(scene, obj):
    depth = 0
    while obj.parent_id is not None:
        obj, depth = scene.object_by_id[obj.parent_id], depth + 1
    return depth


def test_every_block_has_places_to_land_and_most_are_far_from_the_start():
    scene = district(seed=8, outline_m=(200.0, 200.0))
    blocks = {obj.id for obj in scene.objects if obj.attributes.get("part") == "block"}
    found = {
        block.id
        for area in scene.landing_areas
        if (block := block_of(scene, scene.object_by_id[area.object_id])) is not None
    }
    assert len(found) >= 0.9 * len(blocks)
    away_m = [math.dist(a.centroid, scene.start_position_enu_m) for a in scene.landing_areas]
    assert max(away_m) > 200.0
    assert np.median(away_m) > 90.0


def test_storeys_of_a_tower_repeat_one_plan_and_are_furnished_anew():
    scene = district(seed=4, n_storeys=4)
    rooms = [obj for obj in scene.objects if obj.category == "room"]
    owner, _ = Counter(room.parent_id for room in rooms).most_common(1)[0]
    storeys = {}
    for room in rooms:
        if room.parent_id == owner:
            level = round(room.bbox.p[2] - room.bbox.s[2] / 2, 2)
            storeys.setdefault(level, []).append(room)
    assert len(storeys) == 4
    plans = [
        sorted((r.attributes["use"], *r.bbox.p[:2], *r.bbox.s[:2]) for r in storey)
        for storey in storeys.values()
    ]
    assert all(plan == plans[0] for plan in plans)
    furniture = [
        sorted(
            (obj.category, *obj.bbox.p[:2])
            for obj in scene.objects
            if obj.parent_id in {room.id for room in storey}
        )
        for storey in storeys.values()
    ]
    assert all(len(each) > 8 for each in furniture)
    assert len({tuple(each) for each in furniture}) == 4


def test_numbers_of_objects_and_of_buildings_are_as_asked_for():
    scene = district(seed=2, n_objects=600)
    assert 600 <= len(scene.objects) <= 612
    homes = district(seed=3, n_houses=30)
    n_houses = sum(obj.category in BUILDINGS for obj in homes.objects)
    assert abs(n_houses - 30) <= 3


def test_areas_are_bounded():
    scene = district(seed=5, outline_m=(130.0, 110.0), n_areas=12)
    assert 0 < len(scene.landing_areas) <= 12


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"outline_m": (400.0, 59.0)}, "outline 59.0 is out of range; valid: 60 to 400 m"),
        ({"outline_m": (401.0, 90.0)}, "outline 401.0 is out of range; valid: 60 to 400 m"),
        ({"n_objects": 2501}, "objects 2501 is out of range; valid: 20 to 2500"),
        ({"n_houses": 0}, "houses 0 is out of range; valid: 1 to 150"),
        ({"n_storeys": 11}, "storeys 11 is out of range; valid: 1 to 10"),
        ({"n_areas": 0}, "areas 0 is out of range; valid: 1 to 1000"),
        (
            {"outline_m": (400.0, 400.0), "n_objects": 300},
            "objects is 300 beside outline 400,400; valid: 534 to 2500 there",
        ),
        (
            {"outline_m": (100.0, 100.0), "n_objects": 900},
            "objects is 900 beside outline 100,100; valid: 34 to 250 there",
        ),
        (
            {"outline_m": (100.0, 100.0), "n_houses": 90},
            "houses is 90 beside outline 100,100; valid: 1 to 28 there",
        ),
    ],
)
def test_what_the_ground_does_not_bear_is_refused(asked, message):
    with pytest.raises(DistrictError, match=message):
        DistrictRequest(seed=0, **asked)
