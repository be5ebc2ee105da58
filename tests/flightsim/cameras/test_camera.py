import dataclasses
import logging
import math
import subprocess
import sys

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.corpus.curation import curate_scene
from flightsim.cameras import (
    CameraError,
    Cameras,
    depth_noise,
    look_at,
    open_camera_renderer,
)
from flightsim.cameras.view import NO_OBJECT_ID
from flightsim.plant import Plant, PlantCfg
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import GROUND_ID, build_world
from tests.flightsim.handmade import empty_scene, solid

IRIS = AIRFRAMES["iris"]
FORWARD, DOWN = IRIS.rgbd_cameras
WALL_X_M = 6.0

WALL, RED, GREEN = 1, 2, 3


def build_yard():
    """A wall ahead (east), a red block to its left, a green one below a point 4 m up."""
    return build_world(
        empty_scene(),
        IRIS,
        extra=(
            solid("box", (WALL_X_M + 0.5, 0.0, 4.0), (1.0, 40.0, 8.0), object_id=WALL),
            solid("box", (4.0, 1.5, 4.0), (0.4, 0.4, 0.4), material="paint_red", object_id=RED),
            solid(
                "box", (0.6, 0.0, 0.25), (0.5, 0.5, 0.5), material="paint_green", object_id=GREEN
            ),
        ),
    )


@pytest.fixture(scope="module")
def yard():
    return build_yard()


@pytest.fixture(scope="module")
def block():
    return build_world(curate_scene(42), IRIS)


def open_or_skip(world, width, height, backend):
    try:
        return open_camera_renderer(world, width, height, backend)
    except CameraError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module", params=["gl", "raycast"])
def renderer(request, yard):
    opened = open_or_skip(yard, 160, 120, request.param)
    yield opened
    opened.close()


def hover(world, position_enu_m=(0.0, 0.0, 4.0), yaw_rad=0.0):
    data = world.new_data()
    data.qpos[:7] = (*position_enu_m, math.cos(yaw_rad / 2), 0.0, 0.0, math.sin(yaw_rad / 2))
    return data


def points_enu(frame):
    height, width = frame.depth_m.shape
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    z = frame.depth_m
    optical = np.stack([(u - frame.cx) / frame.fx * z, (v - frame.cy) / frame.fy * z, z], axis=-1)
    return optical @ frame.rotation_enu_from_optical.T + np.array(frame.position_enu_m)


def test_frame_says_what_it_is(renderer, yard):
    frame = renderer.render(hover(yard), "forward", 123_000)
    assert (frame.time_us, frame.camera) == (123_000, "forward")
    assert frame.rgb.shape == (120, 160, 3)
    assert frame.rgb.dtype == np.uint8
    assert frame.depth_m.shape == (120, 160)
    assert frame.depth_m.dtype == np.float32
    assert (frame.cx, frame.cy) == (79.5, 59.5)
    assert frame.fx == frame.fy == pytest.approx(60 / math.tan(FORWARD.vertical_fov_rad / 2))
    rotation = frame.rotation_enu_from_optical
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_camera_is_where_the_vehicle_carries_it(renderer, yard):
    frame = renderer.render(hover(yard, (1.0, 2.0, 4.0), math.pi / 2), "down", 0)
    x, y, z = DOWN.position_flu_m
    np.testing.assert_allclose(frame.position_enu_m, (1.0 - y, 2.0 + x, 4.0 + z), atol=1e-9)
    np.testing.assert_allclose(frame.rotation_enu_from_optical[:, 2], (0, 0, -1), atol=1e-9)
    # The top of the image is ahead: north after a quarter turn from east.
    np.testing.assert_allclose(-frame.rotation_enu_from_optical[:, 1], (0, 1, 0), atol=1e-9)


def test_depth_puts_every_pixel_on_the_surface_it_shows(renderer, yard):
    data = hover(yard)
    for camera in ("forward", "down"):
        points = points_enu(renderer.render(data, camera, 0))
        ids = renderer.render_ids(data, camera)
        assert set(np.unique(ids)) <= {WALL, RED, GREEN, GROUND_ID, NO_OBJECT_ID}
        wall, ground = points[ids == WALL], points[ids == GROUND_ID]
        np.testing.assert_allclose(wall[:, 0], WALL_X_M, atol=0.005)
        np.testing.assert_allclose(ground[:, 2], 0.0, atol=0.005)
        assert len(wall) + len(ground) > 5000
    tops = points[(ids == GREEN) & (points[..., 2] > 0.45)]
    assert len(tops) > 100
    np.testing.assert_allclose(tops[:, 2], 0.5, atol=0.005)


def test_left_is_left_and_ahead_is_up(renderer, yard):
    data = hover(yard)
    red_u = np.nonzero(renderer.render_ids(data, "forward") == RED)[1]
    assert len(red_u) > 20
    assert red_u.max() < 80
    green_v = np.nonzero(renderer.render_ids(data, "down") == GREEN)[0]
    assert len(green_v) > 20
    assert green_v.mean() < 60


def test_colours_are_the_materials(renderer, yard):
    data = hover(yard)
    red = renderer.render(data, "forward", 0).rgb[renderer.render_ids(data, "forward") == RED]
    green = renderer.render(data, "down", 0).rgb[renderer.render_ids(data, "down") == GREEN]
    red_mean, green_mean = red.mean(axis=0), green.mean(axis=0)
    assert red_mean[0] > 2 * max(red_mean[1], red_mean[2])
    assert green_mean[1] > 1.3 * max(green_mean[0], green_mean[2])


def test_sky_is_blue_and_infinitely_far(renderer, yard):
    data = hover(yard, (0.0, 0.0, 10.0))
    frame = renderer.render(data, "forward", 0)
    is_sky = renderer.render_ids(data, "forward") == NO_OBJECT_ID
    assert is_sky.sum() > 500
    assert np.isinf(frame.depth_m[is_sky]).mean() > 0.99
    assert np.isfinite(frame.depth_m[~is_sky]).mean() > 0.99
    red, _, blue = frame.rgb[is_sky].astype(float).mean(axis=0)
    assert blue > red + 15


def test_on_board_cameras_do_not_see_the_vehicle_but_views_do(renderer, yard):
    data = hover(yard)
    assert renderer.render(data, "forward", 0).depth_m.min() > 1.0
    views = [
        renderer.render_view(hover(yard, (0.0, y, 4.0)), (-2.0, 0.0, 4.5), (0.0, 0.0, 4.0))
        for y in (0.0, 30.0)
    ]
    assert views[0].depth_m[60, 80] == pytest.approx(2.0, abs=0.15)
    assert views[1].depth_m[60, 80] > 5.0


def test_rendering_leaves_model_and_flight_untouched(renderer):
    worlds = [build_yard(), build_yard()]
    model = worlds[0].model
    watched = open_camera_renderer(worlds[0], 64, 48, renderer.backend)
    settings = (model.geom_group.copy(), model.vis.global_.fovy, model.vis.quality.offsamples)
    states = []
    for world in worlds:
        data = hover(world)
        data.qvel[:] = (1.0, 0.5, 0.0, 0.3, 2.0, -1.0)
        for k in range(120):
            mujoco.mj_step(world.model, data)
            if world is worlds[0] and k % 20 == 0:
                before = data.qpos.tobytes(), data.xpos.tobytes(), data.cam_xpos.tobytes()
                watched.render(data, "forward", 0)
                watched.render_view(data, (-2.0, 0.0, 4.5), (0.0, 0.0, 4.0))
                assert before == (data.qpos.tobytes(), data.xpos.tobytes(), data.cam_xpos.tobytes())
        states.append(data.qpos.tobytes() + data.qvel.tobytes())
    watched.close()
    assert states[0] == states[1]
    assert (model.geom_group == settings[0]).all()
    assert (model.vis.global_.fovy, model.vis.quality.offsamples) == settings[1:]


def test_frame_is_of_the_state_given_and_not_of_the_last_step(renderer, yard):
    data = hover(yard)
    data.qpos[:3] = (1.0, 1.0, 5.0)
    frame = renderer.render(data, "forward", 0)
    x, y, z = FORWARD.position_flu_m
    np.testing.assert_allclose(frame.position_enu_m, (1.0 + x, 1.0 + y, 5.0 + z), atol=1e-9)


def test_unknown_camera_is_named_with_the_valid_ones(renderer, yard):
    valid = "forward, down, up_left, up_right, up_rear"
    with pytest.raises(CameraError, match=f"^camera 'left' is unknown; valid: {valid}$"):
        renderer.render(yard.new_data(), "left", 0)


def test_view_from_the_target_itself_is_refused(renderer, yard):
    with pytest.raises(CameraError, match="is the eye itself"):
        renderer.render_view(yard.new_data(), (1.0, 2.0, 3.0), (1.0, 2.0, 3.0))


def test_closing_twice_is_harmless(yard, renderer):
    second = open_camera_renderer(yard, 32, 24, renderer.backend)
    second.close()
    second.close()
    assert renderer.render(hover(yard), "forward", 0).rgb.any()


@pytest.mark.parametrize("camera", ["forward", "down"])
def test_both_renderers_measure_the_same_depth_in_a_scene(block, camera):
    gl = open_or_skip(block, 160, 120, "gl")
    rays = open_camera_renderer(block, 160, 120, "raycast")
    data = block.new_data()
    for height_m, yaw_rad in ((0.0, 0.0), (2.0, 1.0), (9.0, 3.0)):
        data.qpos[2] = block.rest_qpos[2] + height_m
        data.qpos[3:7] = (math.cos(yaw_rad / 2), 0.0, 0.0, math.sin(yaw_rad / 2))
        frames = [r.render(data, camera, 0) for r in (gl, rays)]
        ids = [r.render_ids(data, camera) for r in (gl, rays)]
        is_same = ids[0] == ids[1]
        assert is_same.mean() > 0.97
        a, b = (f.depth_m[is_same & (ids[0] != NO_OBJECT_ID)] for f in frames)
        difference_m = np.abs(
            a[np.isfinite(a) & np.isfinite(b)] - b[np.isfinite(a) & np.isfinite(b)]
        )
        assert np.median(difference_m) < 0.02
        assert np.quantile(difference_m, 0.95) < 0.05
        colour = [f.rgb.astype(float).mean(axis=(0, 1)) for f in frames]
        assert np.abs(colour[0] - colour[1]).max() < 25
    gl.close()
    rays.close()


@pytest.mark.parametrize("backend", ["gl", "raycast"])
def test_depth_without_colours_is_the_same_depth(block, backend):
    renderer = open_or_skip(block, 160, 120, backend)
    east, north, up = block.scene.start_position_enu_m
    for camera in (FORWARD.name, DOWN.name):
        for height_m, yaw_rad in ((1.0, 0.3), (4.0, 2.0), (12.0, 4.0)):
            data = hover(block, (east, north, up + height_m), yaw_rad)
            whole = renderer.render(data, camera, 5)
            alone = renderer.render_depth(data, camera, 5)
            np.testing.assert_array_equal(alone.depth_m, whole.depth_m)
            pose = [{**vars(frame), "depth_m": None} for frame in (alone, whole)]
            for name in ("rgb", "instance_ids", "class_ids"):
                del pose[1][name]
            np.testing.assert_equal(*pose)
    renderer.close()


def test_who_listens_gets_colours_and_the_pilot_the_same_depth(yard):
    noise = depth_noise("d435", 1, "yard")
    frames = []
    plant = Plant(yard, PlantCfg(seed=0))
    with (
        Cameras(plant, depth_noise=noise) as alone,
        Cameras(plant, depth_noise=noise) as heard,
    ):
        heard.listen(frames.append)
        depth = alone.render_depth("forward")
        assert not hasattr(depth, "rgb")
        assert alone.render_depth("forward") is depth
        np.testing.assert_array_equal(heard.render_depth("forward").depth_m, depth.depth_m)
        assert [frame.rgb.shape for frame in frames] == [(240, 320, 3)]


def test_culling_changes_no_pixel_of_a_view(block):
    gl = open_or_skip(block, 160, 120, "gl")
    data = block.new_data()
    data.qpos[2] += 3.0
    culled = gl.render(data, "forward", 0)
    stage = gl._stages["fast"]
    stage._in_view = lambda _view: np.ones(stage._model.ngeom, dtype=bool)
    whole = gl.render(data, "forward", 0)
    gl.close()
    assert (culled.rgb == whole.rgb).all()
    np.testing.assert_allclose(culled.depth_m, whole.depth_m, rtol=2e-5)


@pytest.mark.parametrize("quality", ["fast", "fine"])
def test_the_wall_throws_its_shadow_on_the_ground(renderer, yard, quality):
    # Beyond the wall, whose shadow is 6.7 m deep there: the sun is in the west-south-west.
    eye, target = (22.0, -6.0, 12.0), (12.0, 0.0, 0.0)
    frame = renderer.render_view(yard.new_data(), eye, target, quality=quality)
    points, bright = points_enu(frame), frame.rgb.astype(float).mean(axis=2)
    is_ground = np.abs(points[..., 2]) < 0.01
    depth_m = points[..., 0] - (WALL_X_M + 1.0)
    shade, sun = (bright[is_ground & near] for near in (depth_m < 5.0, depth_m > 8.0))
    assert min(len(shade), len(sun)) > 500
    assert np.median(shade) < 0.75 * np.median(sun)
    # No acne: hardly a pixel in the sun is as dark as the shade.
    assert np.quantile(sun, 0.02) > np.median(shade)


def test_looks_leave_depth_as_it_is(renderer, yard):
    data, eye, target = yard.new_data(), (-6.0, -5.0, 6.0), (5.0, 1.0, 2.0)
    fast, fine = (renderer.render_view(data, eye, target, quality=q) for q in ("fast", "fine"))
    mujoco.mj_forward(yard.model, data)
    hit = np.zeros(1, np.int32)
    groups = np.array([1, 1, 1, 0, 0, 0], np.uint8)
    away_m = {"fast": [], "fine": []}
    rng = np.random.default_rng(1)
    for u, v in zip(rng.integers(0, 160, 250), rng.integers(0, 120, 250), strict=True):
        ray = fast.rotation_enu_from_optical @ (
            (u - fast.cx) / fast.fx,
            (v - fast.cy) / fast.fy,
            1.0,
        )
        length = np.linalg.norm(ray)
        distance_m = mujoco.mj_ray(yard.model, data, eye, ray / length, groups, 1, -1, hit)
        if 0 < distance_m < 60:
            for name, frame in (("fast", fast), ("fine", fine)):
                away_m[name].append(abs(frame.depth_m[v, u] - distance_m / length))
    for distances_m in away_m.values():
        assert len(distances_m) > 150
        # Pixels at edges may show the other side.
        assert np.median(distances_m) < 0.001
        assert np.quantile(distances_m, 0.9) < 0.03


@pytest.fixture(scope="module")
def facade():
    """A wall of five bays by three storeys that looks west, into the sun."""
    panel = solid(
        "box",
        (9.98, 0.0, 4.8),
        (15.0, 9.6, 0.02),
        material="facade_sand",
        quat=(0.5, 0.5, -0.5, -0.5),
        collides=False,
    )
    core = solid("box", (12.0, 0.0, 5.0), (4.0, 16.0, 10.0), material="plaster_sand")
    return build_world(empty_scene(), IRIS, extra=(core, panel))


@pytest.mark.parametrize("backend", ["gl", "raycast"])
def test_facade_shows_the_edges_of_its_windows(facade, backend):
    opened = open_or_skip(facade, 320, 240, backend)
    frame = opened.render_view(facade.new_data(), (-2.0, 0.0, 4.9), (10.0, 0.0, 4.9))
    opened.close()
    # A line across the windows of the second storey, 12 m away.
    line = frame.rgb[120].astype(float).mean(axis=1)
    north_m = -(np.arange(320) - frame.cx) / frame.fx * 11.97
    is_panel = np.abs(north_m) < 7.4
    np.testing.assert_allclose(frame.depth_m[120, is_panel], 11.97, atol=0.02)

    def around(middle_m):
        return line[np.abs(north_m - middle_m) < 0.3]

    darkest_pier = min(np.median(around(y)) for y in (-4.5, -1.5, 1.5, 4.5))
    assert all(around(y).min() < darkest_pier - 30 for y in (-6, -3, 0, 3, 6))
    assert (np.abs(np.diff(line[is_panel])) > 25).sum() >= 2 * 5


def test_block_has_texture_nearly_everywhere(block):
    gl = open_or_skip(block, 320, 240, "gl")
    data = block.new_data()
    data.qpos[2] += 3.0
    grey = gl.render(data, "forward", 0).rgb.astype(float).mean(axis=2)
    depth_m = gl.render(data, "forward", 0).depth_m
    gl.close()
    shares = []
    for top in range(0, 240, 24):
        for left in range(0, 320, 32):
            patch = (slice(top, top + 24), slice(left, left + 32))
            if np.isfinite(depth_m[patch]).all() and depth_m[patch].max() < 25:
                shares.append(grey[patch].std() > 2.0)
    assert len(shares) > 10
    assert np.mean(shares) > 0.9


@pytest.mark.parametrize(
    ("size", "backend", "message"),
    [
        ((0, 240), "auto", "width 0 is not valid; valid: 1 to 4096 pixels"),
        ((320, 5000), "auto", "height 5000 is not valid; valid: 1 to 4096 pixels"),
        ((320, 240), "vulkan", "backend 'vulkan' is unknown; valid: auto, gl, raycast"),
    ],
)
def test_impossible_renderer_is_refused(yard, size, backend, message):
    with pytest.raises(CameraError) as caught:
        open_camera_renderer(yard, *size, backend)
    assert str(caught.value) == message


COORDINATE = st.floats(-50.0, 50.0)
POINT = st.tuples(COORDINATE, COORDINATE, COORDINATE)


@given(POINT, POINT, st.floats(0.2, 2.0))
def test_look_at_is_a_rotation_with_the_target_ahead_and_no_roll(eye, target, fov_rad):
    if math.dist(eye, target) < 1e-3:
        return
    view = look_at(eye, target, fov_rad)
    rotation = view.rotation_enu_from_optical
    np.testing.assert_allclose(rotation.T @ rotation, np.eye(3), atol=1e-9)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    in_view = rotation.T @ (np.array(target) - np.array(eye))
    np.testing.assert_allclose(in_view, (0, 0, math.dist(eye, target)), atol=1e-9)
    assert rotation[2, 0] == pytest.approx(0.0, abs=1e-12)
    assert rotation[2, 1] <= 1e-9


@given(st.integers(1, 40), st.integers(1, 30), st.floats(0.2, 2.5))
def test_rays_are_one_metre_deep_and_span_the_field_of_view(width, height, fov_rad):
    view = look_at((1.0, 2.0, 3.0), (4.0, -2.0, 2.0), fov_rad)
    rays = view.rays_enu(width, height)
    assert rays.shape == (height, width, 3)
    depth = rays @ view.rotation_enu_from_optical[:, 2]
    np.testing.assert_allclose(depth, 1.0, atol=1e-5)
    focal = view.focal_px(height)
    down = rays @ view.rotation_enu_from_optical[:, 1]
    np.testing.assert_allclose(np.ptp(down), (height - 1) / focal, atol=1e-4)


WITHOUT_GL = """
import sys
def refuse(event, args):
    if event == "ctypes.dlopen" and any(s in str(args[0]) for s in ("EGL", "libGL", "OpenGL")):
        raise OSError(f"{args[0]}: cannot open shared object file")
sys.addaudithook(refuse)
sys.path.insert(0, sys.argv[1])
from tests.flightsim.handmade import empty_scene
from flightsim.cameras import CameraError, open_camera_renderer
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
world = build_world(empty_scene(), AIRFRAMES["iris"])
renderer = open_camera_renderer(world, 32, 24)
frame = renderer.render(world.new_data(), "down", 0)
print(renderer.backend, round(float(frame.depth_m.mean()), 3))
print(renderer.reason)
try:
    open_camera_renderer(world, 32, 24, "gl")
except CameraError as error:
    print(error)
"""


def test_without_gl_libraries_ray_casting_takes_over_and_says_why(request):
    here = str(request.path.parent)
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_GL, here],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    backend, reason, refusal = done.stdout.splitlines()
    assert backend == f"raycast {IRIS.leg_length_m + DOWN.position_flu_m[2]:.3f}"
    assert reason.startswith("no OpenGL: ")
    assert refusal.startswith("backend 'gl' does not load here: ")
    assert refusal.endswith("; valid: raycast")


def test_choosing_by_itself_prefers_gl_where_it_loads(yard, caplog):
    gl = open_or_skip(yard, 32, 24, "gl")
    gl.close()
    with caplog.at_level(logging.INFO):
        chosen = open_camera_renderer(yard, 32, 24)
    assert chosen.backend == "gl"
    assert not caplog.records
    chosen.close()


def test_frames_are_documents(yard):
    renderer = open_camera_renderer(yard, 32, 24, "raycast")
    frame = renderer.render(yard.new_data(), "down", 0)
    with pytest.raises(dataclasses.FrozenInstanceError):
        frame.camera = "other"
