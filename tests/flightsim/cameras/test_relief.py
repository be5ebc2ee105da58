"""Cameras over a relief: depth lies on the ground of the physics, and ids say it is ground."""

from contextlib import closing

import numpy as np
import pytest

from flightsim.cameras.raycast_mesh import geom_triangles
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import GROUND_ID, build_world
from tests.flightsim.cameras.test_camera import open_or_skip, points_enu
from tests.flightsim.handmade import hills, relief_scene, solid

BLOCK = solid("box", (6.0, 9.0, 4.0), (2.0, 2.0, 12.0), object_id=3)
FAR_M = 60.0


@pytest.fixture(scope="module")
def world():
    return build_world(relief_scene(hills()), airframe_by_name("iris"), extra=(BLOCK,))


@pytest.mark.parametrize("backend", ["gl", "raycast"])
@pytest.mark.parametrize("camera", ["down", "forward"])
def test_depth_lies_on_the_ground_and_ids_say_so(world, backend, camera):
    data, relief = world.new_data(), world.scene.relief
    data.qpos[:3] = (-12.0, 9.0, 15.0)
    with closing(open_or_skip(world, 160, 120, backend)) as renderer:
        frame, ids = renderer.render(data, camera, 0), renderer.render_ids(data, camera)
    is_near = frame.depth_m < FAR_M
    frame.depth_m[~is_near] = FAR_M
    ground = points_enu(frame)[is_near & (ids == GROUND_ID)]
    off_m = np.abs(ground[:, 2] - relief.height_m(ground[:, 0], ground[:, 1]))
    assert len(ground) > 3_000
    assert np.percentile(off_m, 99) < 0.05
    assert (BLOCK.object_id in ids) == (camera == "forward")
    # The ground beyond the grid is ground too.
    assert set(np.unique(ids[-20:])) <= {GROUND_ID, BLOCK.object_id}


def test_triangles_of_a_height_field_lie_in_the_relief(world):
    relief, data = world.scene.relief, world.new_data()
    for geom in np.flatnonzero(world.geom_object_id == GROUND_ID).tolist():
        corners = geom_triangles(world.model, geom) + data.geom_xpos[geom]
        middles = corners.mean(axis=1)
        expected = relief.height_m(middles[:, 0], middles[:, 1])
        np.testing.assert_allclose(middles[:, 2], expected, atol=1e-5)
