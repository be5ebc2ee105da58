import math
from collections import Counter

import cv2
import numpy as np
import pytest
import rerun as rr
import shapely
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from aeroscene.solids.shapes import MATERIALS
from flightsim.stored_depth import depth_to_uint16
from scenarios.recording.frames import encode_png
from scenarios.recording.legend import AREA_ROWS, FLIGHT_ROWS
from scenarios.recording.scene import (
    DRONE_CLASS_RGB,
    PERCHING_RGB,
    hull_triangles,
    log_scene,
    polygon_triangles,
)
from tests.flightsim.handmade import hills, relief_scene
from tests.scenarios.recording.conftest import Contents

BATCHES = {
    "box": "Boxes3D:half_sizes",
    "cylinder": "Cylinders3D:lengths",
    "ellipsoid": "Ellipsoids3D:half_sizes",
}


def _instances(contents, kind):
    suffix = f"/{kind}"
    return sum(
        len(value)
        for entity in contents.entities()
        if entity.startswith("/world/scene/") and entity.endswith(suffix)
        for value in contents.column(entity[1:], BATCHES[kind])[1]
    )


def test_the_legend_shows_the_colours_of_areas_and_trajectories(contents):
    rows = (*AREA_ROWS, *FLIGHT_ROWS)
    # An image that never changes has no times, and one row.
    ((blob,),) = contents.column("run/legend", "EncodedImage:blob")[1]
    legend = cv2.imdecode(np.asarray(blob, np.uint8), cv2.IMREAD_COLOR_RGB)
    height_px = legend.shape[0] / len(rows)
    for number, (rgb, _) in enumerate(rows):
        middle = legend[round((number + 0.5) * height_px), 16].astype(int)
        assert np.abs(middle - rgb).max() < 12
    assert {rgb for rgb, _ in AREA_ROWS} == {*DRONE_CLASS_RGB.values(), PERCHING_RGB}


@pytest.mark.parametrize("kind", BATCHES)
def test_every_primitive_is_drawn_once(flight, contents, kind):
    expected = Counter(primitive.kind for primitive in flight.primitives)[kind]
    assert expected > 0
    assert _instances(contents, kind) == expected


def test_hulls_are_drawn_with_all_their_corners(flight, contents):
    drawn = [
        np.array(value)
        for entity in contents.entities()
        if entity.startswith("/world/scene/") and entity.endswith("/mesh")
        for value in contents.column(entity[1:], "Mesh3D:vertex_positions")[1]
    ]
    points = np.concatenate(drawn)
    hulls = [p for p in flight.primitives if p.kind == "mesh"]
    assert hulls
    for hull in hulls[:5]:
        rotation = Rotation.from_quat(hull.quat_wxyz, scalar_first=True)
        corners = rotation.apply(np.array(hull.vertices_m)) + np.array(hull.position_enu_m)
        gaps = np.linalg.norm(points[:, None] - corners[None], axis=2).min(axis=0)
        assert gaps.max() < 1e-3


def test_a_box_has_its_place_size_and_colour(flight, contents):
    box = next(p for p in flight.primitives if p.kind == "box")
    for entity in contents.entities():
        if not (entity.startswith("/world/scene/") and entity.endswith("/box")):
            continue
        (centres,) = contents.column(entity[1:], "Boxes3D:centers")[1] or [[]]
        if not len(centres):
            (centres,) = contents.column(entity[1:], "InstancePoses3D:translations")[1]
        gaps = np.linalg.norm(np.array(centres) - np.array(box.position_enu_m), axis=1)
        if gaps.min() < 1e-4:
            i = int(gaps.argmin())
            (halves,) = contents.column(entity[1:], "Boxes3D:half_sizes")[1]
            np.testing.assert_allclose(halves[i], np.array(box.size_m) / 2, rtol=1e-5)
            (colours,) = contents.column(entity[1:], "Boxes3D:colors")[1]
            red = colours[i] >> 24
            assert red == round(255 * MATERIALS[box.material].rgba[0])
            return
    pytest.fail("the box is not in the recording")


def test_landing_areas_are_outlined_by_drone_class(flight, contents):
    expected = Counter(area.drone_class for area in flight.scene.landing_areas)
    assert expected
    for drone_class in DRONE_CLASS_RGB:
        entity = f"world/landing_areas/{drone_class}/outline"
        strips = contents.column(entity, "LineStrips3D:strips")[1]
        assert sum(len(strip) for strip in strips) == expected[drone_class]


def test_perching_areas_are_outlined_apart_from_landing_areas(flight, contents):
    assert flight.scene.perching_areas
    entity = "world/perching_areas/outline"
    strips = contents.column(entity, "LineStrips3D:strips")[1]
    assert sum(len(strip) for strip in strips) == len(flight.scene.perching_areas)
    assert PERCHING_RGB not in DRONE_CLASS_RGB.values()


@given(
    st.lists(st.floats(0.3, 3.0), min_size=3, max_size=12),
    st.floats(-0.3, 0.3),
)
def test_filled_polygons_have_their_area_and_lie_in_their_plane(radii_m, slope):
    angles = np.arange(len(radii_m)) * 2 * math.pi / len(radii_m)
    x, y = np.array(radii_m) * np.cos(angles), np.array(radii_m) * np.sin(angles)
    polygon = np.stack([x, y, slope * x], axis=1)
    triangles = polygon_triangles(polygon)
    edges = triangles[:, 1:, :2] - triangles[:, :1, :2]
    area = 0.5 * np.abs(np.linalg.det(edges)).sum()
    assert area == pytest.approx(shapely.Polygon(polygon[:, :2]).area, rel=1e-6)
    np.testing.assert_allclose(triangles[..., 2], slope * triangles[..., 0], atol=1e-9)


@given(st.tuples(*[st.floats(0.1, 5.0)] * 3))
def test_hull_triangles_close_a_box_and_face_outwards(size_m):
    signs = np.array([(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)])
    triangles = hull_triangles(signs * np.array(size_m) / 2)
    # Divergence theorem: the signed volume is positive only if every face looks outwards.
    volumes = np.einsum("ni,ni->n", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2])) / 6
    assert (volumes > 0).all()
    assert volumes.sum() == pytest.approx(math.prod(size_m), rel=1e-6)


@given(st.lists(st.floats(0.0, 200.0), min_size=1, max_size=50))
def test_depth_keeps_millimetres_up_to_its_limit_and_zero_beyond(depths_m):
    depth_m = np.array([[*depths_m, math.inf, math.nan]], np.float32)
    stored = depth_to_uint16(depth_m)[0]
    for value, kept in zip(depth_m[0], stored, strict=True):
        if value * 1000 <= 65535:
            assert abs(kept / 1000 - value) <= 5.01e-4 + 1e-6 * value
        else:
            assert kept == 0


def test_png_of_depth_loses_nothing():
    depth = np.random.default_rng(0).integers(0, 65535, (24, 32), dtype=np.uint16)
    decoded = cv2.imdecode(np.frombuffer(encode_png(depth), np.uint8), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(decoded, depth)


def test_the_ground_of_a_relief_is_drawn_at_its_height(tmp_path):
    scene, path = relief_scene(hills()), tmp_path / "hills.rrd"
    with rr.RecordingStream("hills") as stream:
        stream.save(path)
        log_scene(stream, scene, ())
    contents, drawn = Contents(path), []
    for entity in contents.entities():
        if entity.startswith("/world/ground/"):
            drawn += contents.column(entity[1:], "Mesh3D:vertex_positions")[1]
    points = np.concatenate([np.array(value, dtype=float) for value in drawn])
    relief = scene.relief
    assert len(points) > relief.heights_m.size
    off_m = points[:, 2] - relief.height_m(points[:, 0], points[:, 1])
    np.testing.assert_allclose(off_m, -0.02, atol=1e-3)
