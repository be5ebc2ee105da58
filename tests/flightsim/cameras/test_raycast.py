import math
from contextlib import closing
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flightsim.cameras import look_at, open_camera_renderer
from flightsim.cameras.raycast_mesh import geom_triangles
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene, solid

SOLIDS = (
    solid("box", (0, 8, 1), (2, 1, 3)),
    solid("cylinder", (4, 8, 1), (2, 2, 3)),
    solid("ellipsoid", (8, 8, 1), (1, 2, 3)),
    solid(
        "mesh",
        (12, 8, 1),
        (2, 2, 2),
        vertices_m=((-1, -1, -1), (1, -1, -1), (0, 1, -1), (0, 0, 1)),
    ),
)


@pytest.fixture(scope="module")
def world():
    return build_world(empty_scene(), AIRFRAMES["iris"], extra=SOLIDS)


@pytest.mark.parametrize("index", range(len(SOLIDS)), ids=[s.kind for s in SOLIDS])
def test_triangles_of_a_geom_span_its_primitive(world, index):
    triangles = geom_triangles(world.model, 1 + index).reshape(-1, 3)
    spans_m = np.ptp(triangles, axis=0)
    if SOLIDS[index].kind == "mesh":
        # MuJoCo turns meshes to their principal axes.
        corners = np.array(SOLIDS[index].vertices_m)
        spans_m = np.linalg.norm(np.ptp(triangles, axis=0)) * np.ones(1)
        assert spans_m[0] < 2 * np.linalg.norm(np.ptp(corners, axis=0))
        return
    np.testing.assert_allclose(spans_m, SOLIDS[index].size_m, rtol=0.03)


def test_every_geom_that_a_camera_sees_has_triangles(world):
    for g in range(world.model.ngeom):
        triangles = geom_triangles(world.model, g)
        assert triangles.shape[1:] == (3, 3)
        assert np.isfinite(triangles).all()


def test_rays_meet_what_mujocos_own_rays_meet(world):
    renderer = open_camera_renderer(world, 60, 40, "raycast")
    data = world.new_data()
    eye, target = (4.0, -3.0, 4.0), (5.0, 8.0, 1.0)
    frame = renderer.render_view(data, eye, target, math.radians(60))
    mujoco.mj_forward(world.model, data)
    hit = np.zeros(1, np.int32)
    groups = np.array([1, 1, 1, 0, 0, 0], np.uint8)
    rng = np.random.default_rng(5)
    differences_m = []
    for u, v in zip(rng.integers(0, 60, 300), rng.integers(0, 40, 300), strict=True):
        ray = frame.rotation_enu_from_optical @ (
            (u - frame.cx) / frame.fx,
            (v - frame.cy) / frame.fy,
            1.0,
        )
        length = np.linalg.norm(ray)
        distance_m = mujoco.mj_ray(world.model, data, eye, ray / length, groups, 1, -1, hit)
        depth_m = distance_m / length if distance_m >= 0 else np.inf
        if np.isfinite(depth_m) and np.isfinite(frame.depth_m[v, u]):
            differences_m.append(abs(depth_m - frame.depth_m[v, u]))
    assert len(differences_m) > 200
    assert np.median(differences_m) < 1e-4


@pytest.mark.parametrize("roll_deg", [0.0, 8.0, -25.0])
@pytest.mark.parametrize("pitch_deg", [5.0, 60.0])
def test_a_rolled_and_pitched_camera_sees_the_same_by_both_renderers(world, roll_deg, pitch_deg):
    upright = look_at((4.0, -3.0, 4.0), (5.0, 8.0, 1.0), math.radians(60))
    turn = Rotation.from_euler("xz", (pitch_deg, roll_deg), degrees=True).as_matrix()
    view = replace(upright, rotation_enu_from_optical=upright.rotation_enu_from_optical @ turn.T)
    images = []
    for backend in ("gl", "raycast"):
        with closing(open_camera_renderer(world, 60, 40, backend)) as renderer:
            images.append(renderer.render_from(world.new_data(), view, 0).depth_m)
    ours_m, theirs_m = images
    is_seen = np.isfinite(ours_m) & np.isfinite(theirs_m)
    # Pixels on edges may show either side.
    assert np.mean(np.isfinite(ours_m) == np.isfinite(theirs_m)) > 0.98
    ours_m, theirs_m = ours_m[is_seen], theirs_m[is_seen]
    assert np.mean(np.abs(ours_m - theirs_m) < 0.02 + 0.01 * theirs_m) > 0.97


def test_moving_the_vehicle_moves_it_in_the_picture(world):
    renderer = open_camera_renderer(world, 80, 60, "raycast")
    data = world.new_data()
    for x in (-3.0, 2.0):
        data.qpos[:7] = (x, 0.0, 2.0, math.cos(0.4), 0.0, 0.0, math.sin(0.4))
        frame = renderer.render_view(data, (x, -2.0, 2.4), (x, 0.0, 2.0))
        assert frame.depth_m[30, 40] == pytest.approx(2.0, abs=0.15)
