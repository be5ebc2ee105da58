"""Segments: objects and classes in frames of the cameras."""

import numpy as np
import pytest

from aeroscene import load_scene
from flightsim.cameras import CLASS_NAMES, Cameras, open_camera_renderer
from flightsim.cameras.segmentation import (
    DRONE_CLASS,
    GROUND_CLASS,
    NOTHING_CLASS,
    PERSON_CLASS,
    VEHICLE_CLASS,
    Classes,
)
from flightsim.environment.movers import MovingObstacle
from flightsim.plant import Plant, PlantCfg
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene

KINDS = ("person", "car", "drone")


def test_classes_are_the_categories_of_the_scene_and_others():
    world = build_world(load_scene("42"), AIRFRAMES["iris"])
    classes = Classes(world)
    ids = np.array([[obj.id for obj in world.scene.objects]], dtype=np.int32)
    found = classes.of(ids)
    assert found.tolist() == [[obj.category_id for obj in world.scene.objects]]
    assert [CLASS_NAMES[i] for i in found[0]] == [obj.category for obj in world.scene.objects]
    others = classes.of(np.array([-1, -2, -3, -400, 10_000], dtype=np.int32))
    assert others.tolist() == [VEHICLE_CLASS, GROUND_CLASS, NOTHING_CLASS, 0, 0]
    assert len(set(CLASS_NAMES.values())) == len(CLASS_NAMES)


def test_movers_have_the_class_of_their_kind():
    movers = [
        MovingObstacle(kind=kind, path_enu_m=((x, 3.0, 1.0), (x, 9.0, 1.0)), speed_mps=1.0)
        for kind, x in zip(KINDS, (3.0, 6.0, 9.0), strict=True)
    ]
    world = build_world(empty_scene(), AIRFRAMES["iris"], traffic=movers)
    found = Classes(world).of(np.array([-10, -11, -12], dtype=np.int32))
    assert [CLASS_NAMES[i] for i in found.tolist()] == list(KINDS)
    assert found[0] == PERSON_CLASS
    assert found[2] == DRONE_CLASS


def test_other_vehicles_are_drones_and_each_is_its_own():
    first, second = build_world(empty_scene(), *[AIRFRAMES["iris"]] * 2).views
    for world, mate in ((first, -101), (second, -100)):
        assert {-1, mate} <= set(world.geom_object_id.tolist())
        found = Classes(world).of(np.array([-1, mate], dtype=np.int32))
        assert found.tolist() == [VEHICLE_CLASS, DRONE_CLASS]


@pytest.mark.parametrize("camera", ["forward", "down"])
def test_frames_have_segments_only_where_they_are_asked_for(camera):
    world = build_world(load_scene("42"), AIRFRAMES["iris"])
    plant = Plant(world, PlantCfg(seed=0))
    renderer = open_camera_renderer(world, 32, 24, "raycast")
    with Cameras(plant, renderer=renderer, segments=True) as cameras:
        frame, ids = cameras.render(camera), cameras.render_ids(camera)
    with Cameras(plant, renderer=renderer) as cameras:
        plain = cameras.render(camera)
    assert plain.instance_ids is None
    assert plain.class_ids is None
    np.testing.assert_array_equal(frame.rgb, plain.rgb)
    np.testing.assert_array_equal(frame.instance_ids, ids)
    np.testing.assert_array_equal(frame.class_ids, Classes(world).of(ids))
    assert frame.class_ids.dtype == np.uint8
    assert set(np.unique(frame.class_ids).tolist()) <= set(CLASS_NAMES)
    by_id = world.scene.object_by_id
    for number in np.unique(ids[ids >= 0]).tolist():
        assert np.all(frame.class_ids[ids == number] == by_id[number].category_id)
