"""Landing perception on frames that the real camera took of a real scene."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
import shapely

from aeroscene.areas.landing import derive_interaction_areas
from aeroscene.scene import OrientedBox, Scene, SceneObject
from aeroscene.scene.catalogue import category_id
from autonomy.perception import (
    DepthImage,
    ElevationMap,
    LandingNeeds,
    assess,
    camera_pose,
    choose_site,
)
from flightsim.cameras import open_camera_renderer
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world

HUMMINGBIRD = AIRFRAMES["hummingbird"]
SCATTER_M = 0.1
NEEDS = LandingNeeds(
    footprint_radius_m=HUMMINGBIRD.leg_spread_m + SCATTER_M,
    body_radius_m=HUMMINGBIRD.collision_radius_m + SCATTER_M,
)
HOVER_M = 4.0


# Category, centre and extents: one of each kind of thing to land on, well apart.
THINGS = (
    ("lawn", (0.0, 0.0, 0.03), (30.0, 30.0, 0.06)),
    ("sidewalk", (0.0, 18.0, 0.075), (30.0, 3.0, 0.15)),
    ("landing_pad", (-9.0, -9.0, 0.11), (2.6, 2.6, 0.1)),
    ("building", (9.0, -9.0, 3.06), (8.0, 8.0, 6.0)),
    ("roof", (9.0, -9.0, 6.31), (8.0, 8.0, 0.5)),
    ("car", (-9.0, 0.0, 0.81), (4.4, 1.8, 1.5)),
    ("crate", (-9.0, 8.0, 0.56), (1.2, 1.2, 1.0)),
    ("kiosk", (9.0, 9.0, 1.56), (3.0, 3.0, 3.0)),
)


@pytest.fixture(scope="module")
def scene():
    objects = tuple(
        SceneObject(
            id=number,
            scene_id="things",
            parent_id=None,
            category_id=category_id(name),
            bbox=OrientedBox(p, (1.0, 0.0, 0.0, 0.0), s),
            domain="outdoor",
            attributes={"form": "flat"} if name == "roof" else {},
        )
        for number, (name, p, s) in enumerate(THINGS)
    )
    bare = Scene(
        scene_id="things",
        domain="outdoor",
        seed=0,
        extent_min_enu_m=(-25.0, -25.0, 0.0),
        extent_max_enu_m=(25.0, 25.0, 20.0),
        start_position_enu_m=(0.0, -8.0, 0.06),
        start_yaw_rad=0.0,
        latitude_deg=47.4,
        longitude_deg=8.5,
        altitude_m=488.0,
        objects=objects,
    )
    return replace(bare, interaction_areas=derive_interaction_areas(bare))


@pytest.fixture(scope="module")
def world(scene):
    return build_world(scene, HUMMINGBIRD)


@pytest.fixture(scope="module")
def renderer(world):
    opened = open_camera_renderer(world, 320, 240)
    yield opened
    opened.close()


@pytest.fixture(scope="module")
def bearers(scene):
    """The first open-air area on each kind of thing."""
    found = {}
    for area in scene.landing_areas:
        if area.object_id is not None and area.clearance_m > HOVER_M + 0.6:
            found.setdefault(scene.object_by_id[area.object_id].category, area)
    return found


def attitude(roll_rad=0.0, pitch_rad=0.0, yaw_rad=0.0):
    quat = np.empty(4)
    mujoco.mju_euler2Quat(quat, np.array([yaw_rad, pitch_rad, roll_rad]), "ZYX")
    return quat


def frame_from(renderer, world, position_enu_m, quat_wxyz, camera="down"):
    data = world.new_data()
    data.qpos[:7] = (*position_enu_m, *quat_wxyz)
    mujoco.mj_forward(world.model, data)
    return renderer.render(data, camera, 0)


def image_of(frame, position_enu_m, quat_wxyz):
    """The frame as the pilot has it: placed by the pose that the vehicle believes to have."""
    mount = next(mount for mount in HUMMINGBIRD.cameras if mount.name == frame.camera)
    eye, rotation = camera_pose(
        tuple(position_enu_m), tuple(quat_wxyz), mount.position_flu_m, mount.pitch_down_rad
    )
    return DepthImage(
        depth_m=frame.depth_m,
        fx=frame.fx,
        fy=frame.fy,
        cx=frame.cx,
        cy=frame.cy,
        position_enu_m=eye,
        rotation_enu_from_optical=rotation,
    )


@pytest.mark.parametrize("camera", ["forward", "down"])
def test_camera_pose_is_that_of_the_simulated_camera(renderer, world, camera):
    position, quat = (1.0, -2.0, 20.0), attitude(0.2, -0.3, 2.5)
    frame = frame_from(renderer, world, position, quat, camera)
    image = image_of(frame, position, quat)
    np.testing.assert_allclose(image.position_enu_m, frame.position_enu_m, atol=1e-9)
    np.testing.assert_allclose(
        image.rotation_enu_from_optical, frame.rotation_enu_from_optical, atol=1e-9
    )


def test_points_lie_on_the_surface_below(renderer, world, bearers):
    area = bearers["kiosk"]
    position = np.add(area.centroid, (0.1, -0.2, 3.0))
    quat = attitude(0.05, -0.04, 1.0)
    points = image_of(frame_from(renderer, world, position, quat), position, quat).points_enu_m()
    on_roof = np.hypot(*(points[:, :2] - area.centroid[:2]).T) < area.radius - 0.05
    assert np.count_nonzero(on_roof) > 1000
    np.testing.assert_allclose(points[on_roof, 2], area.centroid[2], atol=1e-3)


@pytest.mark.parametrize("bearer", ["landing_pad", "roof", "car", "crate", "sidewalk", "lawn"])
def test_a_site_is_found_on_the_annotated_area(renderer, world, bearers, bearer):
    area = bearers[bearer]
    rng = np.random.default_rng(11)
    elevation = ElevationMap(area.centroid, half_extent_m=2.5)
    error_m = np.array([0.05, -0.05, 0.15])
    for _ in range(4):
        position = np.add(area.centroid, (0.0, 0.0, HOVER_M)) + rng.normal(0.0, 0.1, 3)
        roll, pitch, off_roll, off_pitch = rng.normal(0.0, np.radians([3.0, 3.0, 0.5, 0.5]))
        frame = frame_from(renderer, world, position, attitude(roll, pitch, 0.7))
        believed = attitude(roll + off_roll, pitch + off_pitch, 0.7)
        elevation.add(image_of(frame, position + error_m + rng.normal(0.0, 0.03, 3), believed))
    landing = assess(elevation, NEEDS, elevation.cells_within(area.polygon))
    site = choose_site(landing, elevation, NEEDS, area.centroid)
    assert site is not None
    outline = shapely.Polygon([vertex[:2] for vertex in area.polygon])
    # Where it really is: without the error of the estimate, the feet on the surface.
    true = np.array(site.position_enu_m) - error_m
    assert shapely.Point(true[:2]).distance(outline.exterior) > HUMMINGBIRD.leg_spread_m
    assert outline.contains(shapely.Point(true[:2]))
    assert true[2] == pytest.approx(area.centroid[2], abs=0.06)
    assert math.degrees(site.slope_rad) < 1.5
