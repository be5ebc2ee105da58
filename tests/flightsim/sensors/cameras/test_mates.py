"""Vehicles of one world in each other's cameras."""

import mujoco
import numpy as np
import pytest

from flightsim.sensors.cameras import CameraError, open_camera_renderer
from flightsim.vehicles import airframe_by_name
from flightsim.world import build_worlds
from tests.flightsim.handmade import empty_scene

AWAY_M = 3.0


@pytest.fixture(scope="module")
def worlds():
    return build_worlds(empty_scene(), [airframe_by_name("iris"), airframe_by_name("hummingbird")])


@pytest.fixture(scope="module", params=["gl", "raycast"])
def backend(request, worlds):
    try:
        open_camera_renderer(worlds[0], 8, 8, request.param).close()
    except CameraError as error:
        pytest.skip(str(error))
    return request.param


def face_to_face(worlds):
    """The second vehicle in front of the first one, which it looks back at."""
    data = worlds[0].new_data()
    for world, x, quat in zip(worlds, (0.0, AWAY_M), ((1, 0, 0, 0), (0, 0, 0, 1)), strict=True):
        at = world.qpos_address
        data.qpos[at : at + 7] = (x, 0.0, 5.0, *quat)
    mujoco.mj_forward(worlds[0].model, data)
    return data


@pytest.mark.parametrize("number", [0, 1])
def test_each_sees_the_other_and_not_itself(worlds, backend, number):
    data = face_to_face(worlds)
    renderer = open_camera_renderer(worlds[number], 160, 120, backend)
    frame = renderer.render(data, "forward", 0)
    ids = renderer.render_ids(data, "forward")
    renderer.close()
    seen = ids == -100 - (1 - number)
    assert seen.sum() > 10
    assert not np.any(np.isin(ids, [-1, -100 - number]))
    assert np.median(frame.depth_m[seen]) == pytest.approx(AWAY_M, abs=0.5)
    assert worlds[number].name_of(-100 - (1 - number)) == f"vehicle {2 - number}"


def test_both_are_in_a_picture_from_aside(worlds, backend):
    data = face_to_face(worlds)
    renderer = open_camera_renderer(worlds[1], 160, 120, backend)
    picture = renderer.render_view(data, (AWAY_M / 2, -5.0, 5.2), (AWAY_M / 2, 0.0, 5.0))
    renderer.close()
    near = picture.depth_m < 6.0
    assert near[:, :80].sum() > 10
    assert near[:, 80:].sum() > 10
