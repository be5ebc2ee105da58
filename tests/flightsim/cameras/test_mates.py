"""Vehicles of one world in each other's cameras."""

import math

import mujoco
import numpy as np
import pytest

from autonomy.types import quat_about_up
from flightsim.cameras import CameraError, open_camera_renderer
from flightsim.vehicles import airframe_by_name
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene

AWAY_M = 3.0
AIRFRAMES = ("iris", "hummingbird", "iris")


@pytest.fixture(scope="module")
def worlds():
    return build_world(empty_scene(), *map(airframe_by_name, AIRFRAMES)).views


@pytest.fixture(scope="module", params=["gl", "raycast"])
def backend(request, worlds):
    try:
        open_camera_renderer(worlds[0], 8, 8, request.param).close()
    except CameraError as error:
        pytest.skip(str(error))
    return request.param


def in_a_ring(worlds):
    """The vehicles at the corners of a level triangle, which look at its middle."""
    data = worlds[0].new_data()
    for number, world in enumerate(worlds):
        bearing_rad, at = 2.0 * math.pi / 3.0 * number, world.qpos_address
        x, y = (AWAY_M / math.sqrt(3.0) * turn(bearing_rad) for turn in (math.cos, math.sin))
        data.qpos[at : at + 7] = (x, y, 5.0, *quat_about_up(bearing_rad + math.pi))
    mujoco.mj_forward(worlds[0].model, data)
    return data


@pytest.mark.parametrize("number", range(len(AIRFRAMES)))
def test_each_sees_every_other_and_not_itself(worlds, backend, number):
    data = in_a_ring(worlds)
    renderer = open_camera_renderer(worlds[number], 160, 120, backend)
    frame = renderer.render(data, "forward", 0)
    ids = renderer.render_ids(data, "forward")
    renderer.close()
    assert not np.any(np.isin(ids, [-1, -100 - number]))
    for other in {0, 1, 2} - {number}:
        seen = ids == -100 - other
        assert seen.sum() > 10
        # Those that follow around the ring are to the right of its middle.
        is_right = np.median(np.nonzero(seen)[1]) > 80
        assert is_right == ((other - number) % 3 == 1)
        along_m = AWAY_M * math.cos(math.pi / 6.0)
        assert np.median(frame.depth_m[seen]) == pytest.approx(along_m, abs=0.5)
        assert worlds[number].name_of(-100 - other) == f"vehicle {other + 1}"


def test_all_are_in_a_picture_from_aside(worlds, backend):
    data = in_a_ring(worlds)
    renderer = open_camera_renderer(worlds[1], 160, 120, backend)
    picture = renderer.render_view(data, (-0.1, 6.0, 5.2), (-0.1, 0.0, 5.0))
    renderer.close()
    # From the north: the first vehicle left of the middle, the others right of it, one behind.
    assert ((picture.depth_m > 5.5) & (picture.depth_m < 6.5))[:, :80].sum() > 10
    assert (picture.depth_m < 5.0)[:, 80:].sum() > 10
    assert ((picture.depth_m > 7.0) & (picture.depth_m < 8.0))[:, 80:].sum() > 4
