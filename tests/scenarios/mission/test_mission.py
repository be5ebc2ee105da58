"""The mission: a fitting area, a free place to look at it from, a proved way there."""

import dataclasses
import math

import numpy as np
import pytest

from aeroscene.sources import load_scene
from flightsim.vehicles.catalogue import AIRFRAMES
from scenarios.mission.mission import FAR_ENOUGH_M, plan_mission, rank_areas, takeoff_point
from scenarios.mission.surroundings import HOVER_MARGIN_M, MissionError, survey
from tests.scenarios.landing_scenes import (
    CONTAINER,
    ON_CONTAINER,
    ON_LAWN,
    TOP_M,
    rectangle,
    thing,
    yard,
)

IRIS, HUMMINGBIRD = AIRFRAMES["iris"], AIRFRAMES["hummingbird"]


def test_areas_too_small_for_the_vehicle_are_left_out():
    scene = load_scene("corpus:42")
    small = [area for area in scene.landing_areas if area.drone_class == "small"]
    assert small
    assert not set(small) & set(rank_areas(scene, IRIS, 0))
    assert set(rank_areas(scene, HUMMINGBIRD, 0)) == set(scene.landing_areas)


def test_nobody_is_sent_to_a_perch_unasked():
    scene = load_scene("corpus:42")
    assert scene.perching_areas
    for airframe in (IRIS, HUMMINGBIRD):
        assert all(area.kind == "landing" for area in rank_areas(scene, airframe, 0))


def test_somebody_who_wants_a_perch_gets_one_that_fits():
    scene = load_scene("corpus:42")
    perches = rank_areas(scene, HUMMINGBIRD, 0, "perching")
    assert set(perches) == set(scene.perching_areas)
    both = rank_areas(scene, HUMMINGBIRD, 0, "any")
    assert set(both) == {*scene.landing_areas, *scene.perching_areas}
    mission = plan_mission(scene, HUMMINGBIRD, target="perching")
    assert mission.area.kind == "perching"
    with pytest.raises(MissionError, match="iris: no place to perch suits class medium"):
        plan_mission(scene, IRIS, target="perching")


@pytest.mark.parametrize("seed", range(4))
def test_the_choice_is_far_outdoors_and_the_same_for_the_same_seed(seed):
    scene = load_scene("corpus:42")
    ranked = rank_areas(scene, IRIS, seed)
    assert ranked == rank_areas(scene, IRIS, seed)
    best = ranked[0]
    assert math.dist(best.centroid, scene.start_position_enu_m) >= FAR_ENOUGH_M
    assert best.object_id is None or scene.object_by_id[best.object_id].domain == "outdoor"


def test_seeds_differ_in_their_choice():
    scene = load_scene("corpus:42")
    assert len({rank_areas(scene, IRIS, seed)[0].id for seed in range(20)}) > 2


def test_a_mission_leads_from_above_the_start_to_above_the_area():
    mission = plan_mission(yard(), IRIS, area=ON_CONTAINER)
    world = mission.surroundings
    begin = mission.trajectory.sample(0.0)
    end = mission.trajectory.sample(mission.trajectory.duration_s)
    np.testing.assert_allclose(begin.position_enu_m, mission.takeoff_enu_m, atol=1e-6)
    np.testing.assert_allclose(end.position_enu_m, mission.hover_enu_m, atol=1e-6)
    assert begin.yaw_rad == world.scene.start_yaw_rad
    assert mission.takeoff_enu_m[:2] == world.scene.start_position_enu_m[:2]
    assert mission.hover_enu_m[:2] == ON_CONTAINER.centroid[:2]
    assert mission.hover_enu_m[2] > TOP_M + 1.0
    dense = mission.trajectory.positions(np.linspace(0, mission.trajectory.duration_s, 2000))
    assert world.clearance_m(dense).min() >= mission.trajectory.min_clearance_m > 0
    path = mission.path_enu_m(0.5)
    assert path is not None
    assert tuple(path[0]) == world.scene.start_position_enu_m
    np.testing.assert_allclose(path[1], mission.takeoff_enu_m, atol=1e-6)
    np.testing.assert_allclose(path[-1], mission.hover_enu_m, atol=1e-6)
    onboard = survey(world.scene, IRIS, map_source="onboard")
    assert dataclasses.replace(mission, surroundings=onboard).path_enu_m(0.5) is None


def test_without_a_choice_an_area_is_drawn_and_others_are_kept():
    mission = plan_mission(yard(), IRIS)
    assert mission.area in {ON_CONTAINER, ON_LAWN}
    assert mission.alternates
    assert mission.area not in mission.alternates


def test_a_roof_over_an_area_lowers_the_hover_point_or_takes_the_area_away():
    low = yard()
    canopy = thing(90, "canopy", (9.0, 8.0, 2.8), (4.0, 4.0, 0.2))
    scene = dataclasses.replace(low, objects=(*low.objects, canopy))
    under = survey(scene, HUMMINGBIRD).hover_point(ON_LAWN)
    assert survey(low, HUMMINGBIRD).hover_point(ON_LAWN)[2] == 4.0
    assert under is None or under[2] < 2.6
    inside = rectangle(6, (9.0, 0.0, 1.0), (0.5, 0.5), CONTAINER)
    assert survey(low, HUMMINGBIRD).hover_point(inside) is None


def test_beside_a_post_an_area_is_approached_aslant():
    low = yard()
    post = thing(91, "container", (9.65, 8.0, 3.0), (0.2, 0.2, 6.0))
    world = survey(dataclasses.replace(low, objects=(*low.objects, post)), HUMMINGBIRD)
    assert world.hover_above(ON_LAWN) is None
    hover = world.hover_point(ON_LAWN)
    aside_m = math.dist(hover[:2], ON_LAWN.centroid[:2])
    assert 0.2 < aside_m <= hover[2]
    assert world.clearance_m(np.array([hover]))[0] >= HOVER_MARGIN_M
    mission = plan_mission(world.scene, HUMMINGBIRD, area=ON_LAWN)
    np.testing.assert_allclose(mission.hover_enu_m, hover)


def test_no_area_and_no_way_are_named():
    with pytest.raises(MissionError, match="scene yard, iris: no landing area suits class medium"):
        plan_mission(yard(areas=()), IRIS)
    inside = rectangle(6, (9.0, 0.0, 1.0), (0.5, 0.5), CONTAINER)
    with pytest.raises(MissionError, match="area 6 has no free place to hover above it"):
        plan_mission(yard(), IRIS, area=inside)


def test_a_start_below_a_slab_is_named():
    slab = thing(90, "canopy", (0.0, 0.0, 1.0), (3.0, 3.0, 0.2))
    plain = yard()
    world = dataclasses.replace(survey(plain, IRIS), scene=plain)
    assert takeoff_point(world) == (0.0, 0.0, 2.5)
    covered = dataclasses.replace(plain, objects=(*plain.objects, slab))
    with pytest.raises(MissionError, match="start"):
        plan_mission(covered, IRIS)
