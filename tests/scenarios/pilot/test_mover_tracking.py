"""Movers of the simulator, seen by a simulated depth camera, followed from its images alone."""

from contextlib import closing

import numpy as np
import pytest

from autonomy.perception import DepthImage, MoverTracker
from flightsim.cameras import depth_noise, open_camera_renderer
from flightsim.environment.movers import MovingObstacle
from flightsim.plant import Plant, PlantCfg
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from scenarios.mission.obstacles import scene_obstacles
from tests.flightsim.handmade import empty_scene
from tests.scenarios.mover_draws import draw, follow

IRIS = AIRFRAMES["iris"]
PERSON = MovingObstacle(kind="person", path_enu_m=((6, -6, 0), (6, 6, 0)), speed_mps=1.5, phase=0.1)
DRONE = MovingObstacle(kind="drone", path_enu_m=((5, 8, 0.9), (5, -8, 0.9)), speed_mps=2.5)


@pytest.mark.parametrize(
    ("mover", "camera"), [(PERSON, "exact"), (PERSON, "d435"), (DRONE, "d435")]
)
def test_a_mover_of_the_simulator_is_where_the_tracker_has_it(mover, camera):
    scene = empty_scene()
    world = build_world(scene, IRIS, traffic=[mover])
    plant, hovering = Plant(world, PlantCfg(seed=3)), world.new_data()
    hovering.qpos[2] = 2.0
    noise, obstacles = depth_noise(camera, 3, scene.scene_id), scene_obstacles(scene, ())
    tracker, off_m, off_mps = MoverTracker(), [], []
    with closing(open_camera_renderer(world, 320, 240)) as renderer:
        for _ in range(25):
            for _ in range(10):
                plant.advance()
            hovering.mocap_pos[:] = plant.data.mocap_pos
            hovering.mocap_quat[:] = plant.data.mocap_quat
            frame, time_s = (
                renderer.render_depth(hovering, "forward", plant.time_us),
                plant.time_us * 1e-6,
            )
            image = posed(frame if noise is None else noise.frame(frame))
            tracker.update(time_s, image, lambda points: obstacles.signed_distance(points)[0])
            moving, truth = tracker.moving(time_s), plant.obstacles_true
            assert len(moving) <= 1
            if len(moving) and tracker.tracks[0].n_hits >= 5:
                off_m.append(moving.position_enu_m[0] - truth.position_enu_m[0])
                off_mps.append(moving.velocity_enu_mps[0] - truth.velocity_enu_mps[0])
    assert len(off_m) >= 8
    assert np.median(np.linalg.norm(off_m, axis=1)) < 0.3
    assert np.median(np.linalg.norm(off_mps, axis=1)) < 0.4


def followed(kind, camera, draws):
    """Errors on drawn paths, each a seed and whether the vehicle passes by without turning."""
    looks = [draw(kind, camera, seed, gazes=gazes) for seed, gazes in draws]
    rows = np.concatenate([follow(images) for images in looks])
    assert np.isfinite(rows[:, 0]).mean() > 0.9
    return rows[np.isfinite(rows[:, 0])]


@pytest.mark.parametrize(
    ("camera", "most_m", "most_mps"), [("exact", 0.3, 0.55), ("d435", 0.5, 0.85)]
)
def test_velocities_of_cars_that_cross_the_view_do_not_lag(camera, most_m, most_mps):
    rows = followed("car", camera, [(seed, True) for seed in range(208, 216)])
    assert np.median(rows[:, 0]) < most_m
    assert np.median(rows[:, 1]) < most_mps


@pytest.mark.parametrize("camera", ["exact", "d435"])
def test_people_who_stop_are_seen_to_stop(camera):
    draws = [(seed, gazes) for seed in (0, 1, 5) for gazes in (False, True)]
    rows = followed("person", camera, draws)
    assert np.median(rows[:, 1]) < 0.25
    standing = rows[rows[:, 2] < 0.05]
    assert len(standing) > 10
    assert np.median(standing[:, 3]) < 0.05


def posed(frame):
    return DepthImage(
        depth_m=frame.depth_m,
        fx=frame.fx,
        fy=frame.fy,
        cx=frame.cx,
        cy=frame.cy,
        position_enu_m=frame.position_enu_m,
        rotation_enu_from_optical=frame.rotation_enu_from_optical,
    )
