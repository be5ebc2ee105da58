"""Labels of frames against each other, and against rays and the scene itself."""

import math
from contextlib import closing
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import MultiPoint, Point, Polygon, contains_xy

from aeroscene.sources import load_scene
from flightsim.cameras import look_at, open_camera_renderer
from flightsim.environment.traffic import TrafficCfg
from flightsim.looks.geom_groups import GeomGroup
from flightsim.world import FIRST_MOVER_ID, build_world
from scenarios.images.encoding import FARTHEST_MM
from scenarios.images.frame import Labeller
from scenarios.images.labels.flow import HIDDEN, NO_FLOW, SEEN
from scenarios.images.labels.rle import decode_mask, encode_labels, encode_mask
from scenarios.images.movers import Movers
from scenarios.images.poses import CameraPose, PosePair, rotation_of

FARTHEST_M = FARTHEST_MM / 1000


@pytest.fixture(scope="module")
def scene():
    return load_scene("42")


def measured(frame):
    """Pixels whose depth is a measurement: no sky, and not beyond what 16 bits hold."""
    return frame.depth_m < FARTHEST_M


@given(st.integers(0, 2**31), st.integers(1, 9), st.integers(1, 9), st.integers(1, 4))
def test_masks_are_read_back_as_they_were(seed, height, width, n_labels):
    labels = np.random.default_rng(seed).integers(0, n_labels, (height, width))
    masks = encode_labels(labels)
    assert set(masks) == set(np.unique(labels).tolist())
    for label, rle in masks.items():
        np.testing.assert_array_equal(decode_mask(rle), labels == label)


def test_a_mask_is_packed_as_cocos_own_code_packs_it():
    # The letters are those of pycocotools 2.0.11, `encode(np.asfortranarray(mask))`.
    rows, columns = np.ogrid[:90, :120]
    mask = ((rows - 40) ** 2 + (columns - 70) ** 2 < 900) & (columns % 37 != 0)
    assert encode_mask(mask) == {"size": [90, 120], "counts": PYCOCOTOOLS}


PYCOCOTOOLS = (
    "[d3?X26J6L2M4M2M4M2N2N2N2O0O2N2O0O2N2O000O2O000O2O0000000000000000000j20VM0001N10001N10001N2"
    "N101N2N101N2N2N2N3L3N3L3N4J6JZg1"
)


def test_every_instance_has_the_box_of_its_mask(frames):
    n_found = 0
    for frame in frames:
        for each in frame.facts["instances"]:
            mask = decode_mask(each["rle"])
            np.testing.assert_array_equal(mask, frame.ids == each["id"])
            rows, columns = np.nonzero(mask)
            size = [np.ptp(columns) + 1, np.ptp(rows) + 1]
            assert each["box_px"] == [columns.min(), rows.min(), *size]
            assert each["pixels"] == len(rows)
            ends = {rows.min() == 0, columns.min() == 0, rows.max() == 119, columns.max() == 159}
            assert each["is_cut"] == (True in ends)
            n_found += 1
    assert n_found > 20


def test_every_object_that_fills_pixels_is_an_instance(frames, scene):
    objects = {obj.id: obj.category for obj in scene.objects}
    for frame in frames:
        labelled = {each["id"]: each["category"] for each in frame.facts["instances"]}
        ids, counts = np.unique(frame.ids, return_counts=True)
        large = {number for number, n in zip(ids.tolist(), counts, strict=True) if n >= 20}
        assert {number for number in labelled if number >= 0} == large & objects.keys()
        assert all(
            objects.get(number, category) == category for number, category in labelled.items()
        )


def test_depth_is_what_mujocos_rays_measure(frames, scene):
    world = build_world(scene)
    data = world.new_data()
    groups = np.zeros(mujoco.mjNGROUP, np.uint8)
    groups[[int(GeomGroup.SCENE), int(GeomGroup.DECOR)]] = 1
    rng, geom = np.random.default_rng(1), np.zeros(1, np.int32)
    ours, theirs = [], []
    for frame in frames:
        camera = frame.camera
        rays = camera.rays() @ camera.pose.rotation_enu_from_optical.T
        # Movers and the surroundings are not among these geoms.
        rows, columns = np.nonzero(measured(frame) & (frame.ids >= -2))
        for k in rng.choice(len(rows), 60).tolist():
            ray, eye = rays[rows[k], columns[k]], camera.pose.position_enu_m
            far = mujoco.mj_ray(world.model, data, eye, ray, groups, 1, -1, geom)
            if far > 0:
                ours.append(frame.depth_m[rows[k], columns[k]])
                theirs.append(far)
    off_m = np.abs(np.array(ours) - theirs)
    assert len(ours) > 300
    # At edges the pixel may show the neighbour.
    assert np.mean(off_m < 0.02 + 0.01 * np.array(theirs)) > 0.95


def test_normals_are_those_of_the_depth_image(frames):
    angles = []
    for frame in frames:
        points = frame.points_enu_m
        points[~measured(frame)] = np.nan
        camera = frame.camera
        right = points[1:-1, 2:] - points[1:-1, :-2]
        across = np.cross(right, points[:-2, 1:-1] - points[2:, 1:-1])
        across /= np.linalg.norm(across, axis=-1, keepdims=True)
        normals = frame.normals @ camera.pose.rotation_enu_from_optical.T
        cosines = np.einsum("hwi,hwi->hw", across, normals[1:-1, 1:-1])
        # Depth of 1 mm steps says little about near, steep or far surfaces.
        depth_m = frame.depth_m[1:-1, 1:-1]
        is_fit = (depth_m > 2.0) & (depth_m < 30.0) & np.isfinite(cosines)
        angles.append(np.degrees(np.arccos(np.clip(cosines[is_fit], -1, 1))))
    assert sum(map(len, angles)) > 10_000
    assert np.mean(np.concatenate(angles) < 8.0) > 0.85


def test_normals_are_of_unit_length_and_face_the_camera(frames):
    for frame in frames:
        is_seen = ~np.isinf(frame.depth_m) & frame.normals.any(axis=-1)
        length = np.linalg.norm(frame.normals, axis=-1)
        np.testing.assert_allclose(length[is_seen], 1.0, atol=1e-5)
        towards = np.einsum("hwi,hwi->hw", frame.normals, frame.camera.rays())
        assert (towards[is_seen] < 0.02).all()
        assert not frame.normals[np.isinf(frame.depth_m)].any()


def test_a_box_in_the_world_contains_its_mask(frames):
    n_found = 0
    for frame in frames:
        for each in frame.facts["instances"]:
            corners = each["box3d"]["corners_px"]
            if corners is None:
                continue
            hull = _hull(corners)
            rows, columns = np.nonzero(decode_mask(each["rle"]))
            assert contains_xy(hull.buffer(1.0), columns, rows).all(), each["category"]
            n_found += 1
    assert n_found > 15


def test_a_box_lies_where_its_pose_in_the_optical_frame_puts_it(frames):
    for frame in frames:
        for each in frame.facts["instances"]:
            box = each["box3d"]
            seen = frame.camera.to_optical(np.array([box["centre_enu_m"]]))[0]
            np.testing.assert_allclose(box["centre_optical_m"], seen, atol=1e-3)
            if box["corners_px"] is not None:
                middle = frame.camera.pixels(np.array(box["centre_optical_m"]))
                assert contains_xy(_hull(box["corners_px"]).buffer(0.5), *middle)


def test_landing_areas_lie_on_their_surface(frames, scene):
    areas = {area.id: area for area in scene.interaction_areas}
    n_found = 0
    for frame in frames:
        points = frame.points_enu_m
        for each in frame.facts["areas"]:
            area = areas[each["id"]]
            assert (each["drone_class"], each["kind"]) == (area.drone_class, area.kind)
            rows, columns = np.nonzero(decode_mask(each["rle"]))
            shown = points[rows, columns]
            outline = Polygon([corner[:2] for corner in area.polygon])
            # A pixel is wide where the camera looks along the ground.
            wide_m = 0.05 + 2.0 * _pixel_m(frame, rows, columns)
            lies = contains_xy(outline, shown[:, 0], shown[:, 1])
            near = np.array([outline.distance(_point(p)) for p in shown[~lies]])
            assert (near < wide_m[~lies]).all()
            assert np.abs(shown[:, 2] - area.centroid[2]).max() < 0.5
            owner = -2 if area.object_id is None else area.object_id
            n_found += np.count_nonzero(frame.ids[rows, columns] == owner) > 0.8 * len(rows)
    n_areas = sum(len(frame.facts["areas"]) for frame in frames)
    assert n_areas > 10
    # Some areas lie on a cover that the scene counts as another object.
    assert n_found > 0.9 * n_areas


def test_an_area_behind_a_wall_is_not_labelled(frames, scene):
    n_hidden = 0
    for frame in frames:
        seen = {each["id"] for each in frame.facts["areas"]}
        for area in scene.interaction_areas:
            x, y, z = frame.camera.to_optical(np.array([area.centroid]))[0]
            wide_px = area.radius * frame.camera.focal_px / max(z, 0.1)
            is_above = frame.camera.pose.position_enu_m[2] > area.centroid[2] + 0.3 * z
            # Large enough, and steep enough, to be labelled if nothing hid them.
            if z < 1.0 or wide_px < 6.0 or not is_above or area.id in seen:
                continue
            column, row = np.rint(frame.camera.pixels(np.array([x, y, z]))).astype(int)
            if 0 <= column < 160 and 0 <= row < 120 and z < 60:
                n_hidden += frame.depth_m[row, column] < z - 1.0
    assert n_hidden > 0


def test_flow_leads_to_the_same_point_in_the_second_image(frames):
    """The second depth follows from rays: the second image has no depth of its own in a shard."""
    scene = load_scene("42")
    world = build_world(scene)
    data, geom = world.new_data(), np.zeros(1, np.int32)
    groups = np.zeros(mujoco.mjNGROUP, np.uint8)
    groups[[int(GeomGroup.SCENE), int(GeomGroup.DECOR)]] = 1
    rng, off_px, moved_px = np.random.default_rng(2), [], []
    for frame in frames:
        is_fit = (frame.flow_kind == SEEN) & measured(frame) & (frame.ids >= -2)
        rows, columns = np.nonzero(is_fit)
        second, points = frame.next_camera, frame.points_enu_m
        for k in rng.choice(len(rows), 40).tolist():
            row, column = rows[k], columns[k]
            u, v = np.array([column, row]) + frame.flow_px[row, column]
            cx, cy = second.centre_px
            local = np.array([(u - cx) / second.focal_px, (v - cy) / second.focal_px, 1.0])
            ray = second.pose.rotation_enu_from_optical @ local
            eye = second.pose.position_enu_m
            far = mujoco.mj_ray(world.model, data, eye, ray, groups, 1, -1, geom)
            off_m = np.linalg.norm(eye + far * ray - points[row, column])
            off_px.append(off_m * second.focal_px / far if far > 0 else 9.0)
            moved_px.append(np.hypot(*frame.flow_px[row, column]))
    assert np.median(moved_px) > 3.0
    assert np.mean(np.array(off_px) < 2.5) > 0.9


def test_every_kind_of_flow_occurs(frames):
    kinds = np.concatenate([frame.flow_kind.ravel() for frame in frames])
    assert set(np.unique(kinds)) <= {NO_FLOW, HIDDEN, SEEN}
    assert np.mean(kinds == SEEN) > 0.4
    assert np.mean(kinds == HIDDEN) > 0.01


def test_flow_of_a_mover_includes_its_own_motion():
    scene = load_scene("field")
    world = build_world(scene, traffic=TrafficCfg(cars=1, seed=3))
    with closing(open_camera_renderer(world, 160, 120)) as renderer:
        data, movers = world.new_data(), Movers(world)
        position, _ = movers.place(data, 8.0)
        later, _ = movers.place(data, 8.5)
        assert np.linalg.norm(later - position) > 0.3
        # Straight above, at rest: only the car moves in the image.
        eye = CameraPose(
            position_enu_m=position[0] + (0.0, 0.0, 9.0),
            rotation_enu_from_optical=rotation_of(0.3, math.pi / 2, 0.0),
        )
        pair = PosePair(now=eye, next=eye)
        frame = Labeller(world, renderer, 160, 120).take(pair, 1.2, 8.0, 0.5)
        movers.place(data, 8.5)
        view = look_at((0, 0, 5), (0, 0, 0), 1.0)
        focal_px = frame.facts["camera"]["focal_x_px"]
        view = replace(
            view,
            position_enu_m=eye.position_enu_m,
            rotation_enu_from_optical=eye.rotation_enu_from_optical,
            vertical_fov_rad=2 * math.atan(60 / focal_px),
        )
        ids_later = renderer.render_ids_from(data, view)
    is_car = (frame.instance_ids == FIRST_MOVER_ID) & (frame.flow_kind == SEEN)
    rows, columns = np.nonzero(is_car)
    assert len(rows) > 200
    u, v = np.rint(frame.flow_px[rows, columns].T + (columns, rows)).astype(int)
    assert np.median(np.hypot(*frame.flow_px[rows, columns].T)) > 4.0
    assert np.mean(ids_later[v, u] == FIRST_MOVER_ID) > 0.95
    ground = frame.flow_px[(frame.instance_ids != FIRST_MOVER_ID)]
    np.testing.assert_allclose(ground, 0.0, atol=1e-3)


def _hull(corners):
    return MultiPoint(np.array(corners)).convex_hull


def _point(values):
    return Point(values[0], values[1])


def _pixel_m(frame, rows, columns):
    """Length on the ground of a pixel: long where the ray grazes it."""
    camera = frame.camera
    rays = camera.rays()[rows, columns] @ camera.pose.rotation_enu_from_optical.T
    down = np.abs(rays[:, 2]) / np.linalg.norm(rays, axis=1)
    return frame.depth_m[rows, columns] / camera.focal_px / np.maximum(down, 0.02)
