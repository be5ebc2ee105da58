"""What stands around a site: outside its volume, apart from each other, where roads lead."""

from dataclasses import replace

import numpy as np
import pytest
import shapely

from aeroscene.corpus.curation.composers import mixed, outdoor
from aeroscene.corpus.field import field_scene
from aeroscene.neighbourhood import GAP_M, NEIGHBOURHOOD_STYLES, RING_M, neighbours_of
from aeroscene.neighbourhood.plots import Plot
from aeroscene.neighbourhood.streets import streets_around
from aeroscene.scene.catalogue import ROADS
from aeroscene.solids.outlines import outline_of
from aeroscene.solids.solids import Solids
from aeroscene.sources import load_scene

OUTDOOR = [i for i in range(0, 48, 2) if load_scene(str(i)).domain != "indoor"]


def volume(scene, margin_m=0.0):
    low, high = scene.extent_min_enu_m, scene.extent_max_enu_m
    return shapely.box(*low[:2], *high[:2]).buffer(margin_m, join_style="mitre")


def outlines(primitives):
    solids = Solids(primitives)
    return [outline_of(solids.points(i)) for i in range(len(solids))]


@pytest.mark.parametrize("index", OUTDOOR)
def test_all_that_can_be_touched_stands_in_the_ring_and_not_in_the_volume(index):
    scene = load_scene(str(index))
    touchable = [part for part in neighbours_of(scene) if part.collides]
    assert len(touchable) > 20
    for outline in outlines(touchable):
        # Eaves reach a little over their walls.
        assert not outline.intersects(volume(scene, GAP_M - 0.8))
        assert outline.within(volume(scene, RING_M + 0.8))
    assert min(part.position_enu_m[2] - part.size_m[2] / 2 for part in touchable) < 0.01


@pytest.mark.parametrize("index", OUTDOOR[:6])
def test_houses_and_trees_stand_neither_in_each_other_nor_on_a_street(index):
    parts = neighbours_of(load_scene(str(index)))
    walls = outlines([p for p in parts if p.collides and p.kind == "box"])
    streets = shapely.union_all(outlines([p for p in parts if p.material == "asphalt"]))
    for number, outline in enumerate(walls):
        assert outline.distance(streets) > 0.5
        assert min(outline.distance(other) for other in walls[:number] or [shapely.Point()]) != 0.0


def test_the_same_scene_has_the_same_neighbours_and_another_one_others():
    scene = load_scene("42")
    once = neighbours_of(scene)
    neighbours_of.cache_clear()
    assert neighbours_of(scene) == once
    assert neighbours_of(replace(scene, seed=scene.seed + 1)) != once


def test_indoor_scenes_and_those_of_no_theme_have_none():
    assert neighbours_of(field_scene()) == ()
    assert neighbours_of(load_scene("5")) == ()
    assert neighbours_of(replace(load_scene("42"), theme="")) == ()
    assert neighbours_of(replace(load_scene("42"), theme="moon")) == ()


def end_of(box, way):
    """Middle of one end of a road, to the millimetre."""
    along = np.array([np.cos(box.yaw_rad), np.sin(box.yaw_rad)])
    return tuple((np.array(box.p[:2]) + way * box.s[0] / 2 * along).round(3))


@pytest.mark.parametrize("index", [0, 3, 12, 21, 42, 61])
def test_a_road_that_ends_at_the_edge_goes_on_and_one_that_meets_another_does_not(index):
    scene = load_scene(str(index))
    streets = streets_around(scene, RING_M)
    assert streets
    road_ends = [
        tuple(
            (
                np.array(road.bbox.p[:2])
                + way * np.array([np.cos(yaw), np.sin(yaw)]) * road.bbox.s[0] / 2
            ).round(3)
        )
        for road in scene.objects
        if road.category in ROADS
        for yaw in [road.bbox.yaw_rad]
        for way in (-1, 1)
    ]
    continuations = [s for s in streets if tuple(np.round(s.begin, 3)) in road_ends]
    assert continuations
    for street in continuations:
        end = np.array(street.begin) + street.length_m * np.array(street.along)
        assert volume(scene).distance(shapely.Point(end)) > 0.5 * RING_M
    sites = shapely.union_all(
        [outline_of(obj.bbox.corners()) for obj in scene.objects if obj.category in ROADS]
    )
    for street in continuations:
        ahead = np.array(street.begin) + 3.0 * np.array(street.along)
        assert not sites.contains(shapely.Point(ahead))


def test_in_the_country_fields_begin_and_in_town_they_do_not():
    rural = {name for name, style in NEIGHBOURHOOD_STYLES.items() if style.is_rural}
    assert rural == {"park", "hillside", "village"}


def test_every_theme_of_the_open_air_has_a_manner():
    assert {*outdoor.THEMES, *mixed.THEMES} <= set(NEIGHBOURHOOD_STYLES)


def test_neighbours_of_a_relief_stand_on_it():
    scene = load_scene("hills")
    parts = [part for part in neighbours_of(scene) if part.kind == "box"]
    assert len(parts) > 20
    for part in parts:
        foot_m = part.position_enu_m[2] - part.size_m[2] / 2
        ground_m = float(scene.relief.height_m(*part.position_enu_m[:2]))
        assert ground_m - 4.0 < foot_m <= ground_m + 1e-6


def test_plots_are_apart_exactly_where_rectangles_are():
    rng, n_apart = np.random.default_rng(3), 0
    for _ in range(500):
        places = rng.uniform((-9.0, -9.0, -4.0), (9.0, 9.0, 4.0), (2, 3)).tolist()
        sizes = rng.uniform(1.0, 8.0, (2, 3)).tolist()
        first, second = (Plot.at(tuple(p), tuple(s)) for p, s in zip(places, sizes, strict=True))
        shapes = [shapely.Polygon(plot.corners()) for plot in (first, second)]
        gap_m = shapes[0].distance(shapes[1])
        n_apart += first.is_apart(second, 0.0)
        assert first.is_apart(second, 1e-9) == second.is_apart(first, 1e-9)
        # A line between them is at most as far from both as they are from each other.
        assert first.is_apart(second, 1e-9) == (gap_m > 1e-9)
        assert not first.is_apart(second, gap_m + 1e-6)
    assert 100 < n_apart < 400
