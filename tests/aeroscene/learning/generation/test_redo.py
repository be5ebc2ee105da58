"""Regions of scenes drawn anew by the model that ships."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aeroscene.corpus.shipped import read_shipped
from aeroscene.learning.generation import Generated, Generator, Redo, Region, Request, RequestError
from aeroscene.learning.wishes import Wish
from aeroscene.scene import Scene
from aeroscene.scene.io import scene_to_json
from aeroscene.validation import validate
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.feasibility.scenes import BENCH, CUP, TABLE, garden, thing


def quarter(scene: Scene, east: int = 0, north: int = 0) -> Region:
    """A quarter of a scene's ground plan."""
    low, high = scene.extent_min_enu_m, scene.extent_max_enu_m
    sides = [
        ((a, (a + b) / 2), ((a + b) / 2, b))[k]
        for a, b, k in zip(low[:2], high[:2], (east, north), strict=True)
    ]
    (x0, x1), (y0, y1) = sides
    return Region(low_enu_m=(x0, y0, -math.inf), high_enu_m=(x1, y1, math.inf))


def fullest_quarter(scene: Scene) -> Region:
    """The quarter in which most goes."""
    quarters = [quarter(scene, east, north) for east in (0, 1) for north in (0, 1)]
    return max(quarters, key=lambda region: len(Redo(scene=scene, region=region).gone))


@pytest.fixture(scope="module")
def generator() -> Generator:
    return Generator.load(device="cpu", n_steps=12)


SCENES = {"mixed": lambda: read_shipped(42), "indoor": lambda: read_shipped(230)}


@pytest.fixture(scope="module", params=sorted(SCENES))
def made(request: pytest.FixtureRequest, generator: Generator) -> Generated:
    scene = SCENES[request.param]()
    redo = Redo(scene=scene, region=fullest_quarter(scene))
    return generator.sound_scene(Request(seed=42, redo=redo))


def parts(made: Generated) -> tuple[Redo, list, list]:
    """What was asked for, what stays of the scene, and what is new."""
    redo, scene = made.request.redo, made.scene
    assert redo is not None
    assert scene is not None
    known = redo.scene.object_by_id
    objects = [replace(obj, scene_id=redo.scene.scene_id) for obj in scene.objects]
    kept = [obj for obj in objects if obj.id in known]
    return redo, kept, [obj for obj in objects if obj.id not in known]


def test_what_is_not_in_the_region_stays_exactly_as_it_is(made):
    redo, kept, _ = parts(made)
    assert len(redo.gone) > 10
    assert kept == [obj for obj in redo.scene.objects if obj.id not in redo.gone]
    frame = ("domain", "theme", "extent_min_enu_m", "extent_max_enu_m")
    for name in (*frame, "start_position_enu_m", "start_yaw_rad"):
        assert getattr(made.scene, name) == getattr(redo.scene, name)


def test_about_as_many_come_as_go_all_of_them_in_the_region(made):
    redo, _, new = parts(made)
    assert 0.6 * len(redo.gone) <= len(new) <= 1.5 * len(redo.gone)
    assert all(redo.region.holds(obj.bbox.p) for obj in new)
    assert not any(obj.is_coarse or obj.attributes.get("is_start") for obj in new)
    old = {(obj.category, obj.bbox) for obj in redo.scene.objects}
    assert not old & {(obj.category, obj.bbox) for obj in new}


def test_the_scene_is_sound_and_says_what_was_redone(made):
    redo, _, _ = parts(made)
    assert validate(made.scene) == ()
    assert made.scene.wishes == {"redo": redo.scene.scene_id, "region": str(redo.region)}


def test_areas_outside_of_the_region_stay(made):
    redo, _, _ = parts(made)
    (x0, y0, _), (x1, y1, _) = redo.region.low_enu_m, redo.region.high_enu_m

    def is_outside(area):
        east, north, _ = zip(*area.polygon, strict=True)
        return max(east) < x0 or min(east) > x1 or max(north) < y0 or min(north) > y1

    before = {area for area in redo.scene.interaction_areas if is_outside(area)}
    after = set(made.scene.interaction_areas)
    # At the border something new may stand in the way of one.
    assert len(before - after) <= 0.1 * len(before)
    new = [area for area in after if area not in set(redo.scene.interaction_areas)]
    assert new
    assert all(redo.region.holds(corner) for area in new for corner in area.polygon)


def test_same_seed_gives_the_same_and_another_another(generator):
    scene = read_shipped(230)
    redo = Redo(scene=scene, region=fullest_quarter(scene))
    requests = [Request(seed=seed, redo=redo) for seed in (3, 3, 4)]
    first, again, other = (next(generator.generate([each])).raw for each in requests)
    assert scene_to_json(first) == scene_to_json(again)
    assert {obj.bbox for obj in first.objects} != {obj.bbox for obj in other.objects}
    both = [each.raw for each in generator.generate(requests[:1] + requests[2:], batch_size=2)]
    assert [scene_to_json(each) for each in both] == [scene_to_json(first), scene_to_json(other)]


def test_an_empty_region_is_furnished(generator):
    scene = read_shipped(230)
    emptied = Redo(scene=scene, region=quarter(scene, 1, 1)).kept
    redo = Redo(scene=emptied, region=quarter(scene, 1, 1))
    assert not redo.gone
    made = next(generator.generate([Request(seed=5, redo=redo)]))
    new = [obj for obj in made.projected.objects if obj.id not in emptied.object_by_id]
    assert len(new) > 3
    assert all(redo.region.holds(obj.bbox.p) for obj in new)


def test_a_region_without_room_says_so_in_one_line(generator):
    scene = read_shipped(230)
    region = Region(low_enu_m=(0.0, 0.0, 2.9), high_enu_m=(0.01, 0.01, 2.91))
    made = next(generator.generate([Request(seed=5, redo=Redo(scene=scene, region=region))]))
    assert made.scene is None
    assert made.report.rejection.startswith("nothing new has a place in the region 0,0,0.01,0.01")
    assert [obj.bbox for obj in made.projected.objects] == [obj.bbox for obj in scene.objects]


@pytest.mark.parametrize("number", [20, 160, 794])
def test_scenes_without_a_whole_partition_are_redone_too(generator, number):
    scene = read_shipped(number)
    redo = Redo(scene=scene, region=quarter(scene))
    made = next(generator.generate([Request(seed=5, redo=redo)]))
    kept = [replace(o, scene_id=scene.scene_id) for o in made.projected.objects]
    assert kept[: len(redo.kept.objects)] == list(redo.kept.objects)
    assert len(kept) > len(redo.kept.objects)


WEST = Region(low_enu_m=(-20.0, -20.0, -math.inf), high_enu_m=(0.0, 20.0, math.inf))


def gone(scene: Scene, region: Region = WEST) -> frozenset[int]:
    return Redo(scene=scene, region=region).gone


def test_fine_objects_in_the_region_go_with_what_they_bear():
    assert gone(garden()) == {TABLE, CUP, BENCH}
    beside = thing(CUP, "cup", (-6.0, 0.5, 0.86), (0.1, 0.1, 0.1), TABLE)
    narrow = Region(low_enu_m=(-7.0, -0.1, -math.inf), high_enu_m=(-5.0, 0.1, math.inf))
    assert gone(garden(beside), narrow) == {TABLE, CUP}


def test_what_stands_upon_them_goes_though_it_belongs_to_something_else():
    cup = thing(CUP, "cup", (-6.0, 0.5, 0.86), (0.1, 0.1, 0.1), 0)
    narrow = Region(low_enu_m=(-7.0, -0.1, -math.inf), high_enu_m=(-5.0, 0.1, math.inf))
    assert gone(garden(cup), narrow) == {TABLE, CUP}


def test_coarse_objects_and_the_pad_of_the_start_stay():
    everything = Region(low_enu_m=(-90.0, -90.0, -math.inf), high_enu_m=(90.0, 90.0, math.inf))
    assert gone(garden(), everything) == {TABLE, CUP, BENCH}


def test_heights_of_a_region_choose_a_storey():
    scene = cached_scene(42)
    low, high = scene.extent_min_enu_m, scene.extent_max_enu_m
    region = Region(low_enu_m=(*low[:2], 3.0), high_enu_m=(*high[:2], 6.0))
    found = [scene.object_by_id[each] for each in gone(scene, region)]
    assert found
    bearers = {obj.id for obj in found}
    assert all(obj.parent_id in bearers or 3.0 <= obj.bbox.p[2] <= 6.0 for obj in found)


def test_as_many_are_wished_for_as_go_times_the_density():
    redo = Redo(scene=garden(), region=WEST)
    seen = [Wish("outdoor", 40, 100, 20)]

    def n_fine(request: Request) -> int:
        return request.drawn(np.random.default_rng(0), seen)[0].n_fine

    assert n_fine(Request(seed=0, redo=redo)) == 1 + 3
    assert n_fine(Request(seed=0, redo=redo, density=2.0)) == 1 + 6
    empty = Region(low_enu_m=(0.0, -20.0, -math.inf), high_enu_m=(20.0, 5.0, math.inf))
    # A quarter of what is usual where there was nothing.
    assert n_fine(Request(seed=0, redo=Redo(scene=garden(), region=empty))) == 4 + 25


def test_a_region_beside_the_scene_is_refused():
    for low, high in (
        ((30.0, 0.0, 0.0), (40.0, 5.0, 3.0)),
        ((0.0, 0.0, 50.0), (5.0, 5.0, 60.0)),
    ):
        with pytest.raises(RequestError, match="lies outside of scene 'garden'; valid: some of x"):
            Redo(scene=garden(), region=Region(low_enu_m=low, high_enu_m=high))


@pytest.mark.parametrize(
    ("wish", "message"),
    [
        ({"complete": garden()}, "complete is 'garden' beside a scene to redo"),
        ({"theme": "park"}, "theme is 'park' beside a scene to redo"),
        ({"domain": "indoor"}, "domain is 'indoor' beside a scene to redo"),
        ({"outline_m": (60.0, 60.0)}, "outline is '60,60' beside"),
        ({"n_objects": 100}, "objects is 100 beside .* density has a factor"),
        ({"n_areas": 20}, "areas is 20 beside .* what is outside of the region stays as it is"),
        ({"clutter": 2.0}, r"clutter is 2\.0 beside"),
        ({"min_passage_m": 2.0}, r"min-passage is 2\.0 beside"),
    ],
)
def test_what_would_change_the_rest_of_the_scene_is_refused(wish, message):
    with pytest.raises(RequestError, match=message):
        Request(seed=0, redo=Redo(scene=garden(), region=WEST), **wish)
