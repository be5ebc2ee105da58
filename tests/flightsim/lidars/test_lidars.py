"""Lidars: their files, their patterns, and what they measure of a known world."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from autonomy.types import ControlLevel, Setpoint
from flightsim.lidars import LIDARS, Lidar, LidarError, lidar_by_name
from flightsim.plant import Plant, PlantCfg
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene, solid

VLP16, MID40 = LIDARS["vlp16"], LIDARS["mid40"]
WALL_X_M = 6.0
WALL = solid("box", (WALL_X_M + 0.5, 0.0, 4.0), (1.0, 40.0, 8.0))


@pytest.fixture
def plant():
    world = build_world(empty_scene(), AIRFRAMES["iris"], extra=[WALL])
    return Plant(world, PlantCfg(seed=2, aiding="vio"))


def scan_of(plant, cfg):
    lidar = Lidar(plant, cfg)
    for _ in range(10):
        plant.advance()
        if lidar.update() is not None:
            return lidar.latest
    pytest.fail("no scan in 0.2 s")


def angles_deg(directions):
    x, y, z = directions.T
    return np.degrees(np.arctan2(y, x)), np.degrees(np.arcsin(z))


def test_the_spinning_one_fires_sixteen_beams_around_clockwise():
    azimuth, elevation = angles_deg(VLP16.pattern.directions_flu(np.arange(28_800)))
    assert VLP16.pattern.shots_per_scan == 28_800
    np.testing.assert_allclose(np.unique(elevation.round(6)), np.arange(-15.0, 16.0, 2.0))
    assert elevation[:3] == pytest.approx((-15.0, 1.0, -13.0))
    columns = azimuth.reshape(-1, 16)
    assert columns[:3, 0] == pytest.approx((0.0, -0.2, -0.4), abs=1e-9)
    # 16 firings of 2.304 us at ten turns a second.
    assert columns[5, 0] - columns[5, 15] == pytest.approx(15 / 16 * 0.1327, abs=1e-3)


def test_the_rosette_fills_its_cone_and_does_not_repeat():
    pattern = MID40.pattern
    shots = np.arange(2 * pattern.shots_per_scan)
    directions = pattern.directions_flu(shots)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0)
    away_deg = np.degrees(np.arccos(directions[:, 0]))
    assert away_deg.max() == pytest.approx(19.2, abs=0.1)
    assert away_deg.min() < 1.0
    first, second = np.split(directions, 2)
    assert np.abs(first - second).max() > 0.1
    # The same in whole seconds of both prisms' turns: 7294 and 4664 in a minute.
    later = pattern.directions_flu(shots[:10] + 60 * 100_000)
    np.testing.assert_allclose(later, directions[:10], atol=1e-6)


def test_a_scan_is_the_wall_and_the_ground_where_they_are(plant):
    cfg = replace(VLP16, noise_m=0.0)
    scan = scan_of(plant, cfg)
    x, y, z = plant.truth.position_enu_m
    points = scan.points_flu_m + (x, y, z)  # at rest, level, nose to the east
    is_ground = abs(points[:, 2]) < 0.02
    is_wall = abs(points[:, 0] - WALL_X_M) < 0.02
    assert np.all(is_ground | is_wall)
    assert is_ground.sum() > 1000
    assert is_wall.sum() > 1000
    assert scan.time_us == 100_000
    assert scan.offset_us[0] == pytest.approx(-100_000.0, abs=10.0)
    assert np.isinf(scan.range_m).sum() > 5000  # the sky
    assert len(scan.points_lidar_m) == np.isfinite(scan.range_m).sum()


def test_noise_is_as_configured_and_follows_from_the_seed(plant):
    exact, noisy = scan_of(plant, replace(VLP16, noise_m=0.0)), None
    again = Plant(plant.world, PlantCfg(seed=2, aiding="vio"))
    noisy = scan_of(again, VLP16)
    is_met = np.isfinite(exact.range_m)
    errors_m = noisy.range_m[is_met] - exact.range_m[is_met]
    assert np.std(errors_m) == pytest.approx(VLP16.noise_m, rel=0.05)
    third = Plant(plant.world, PlantCfg(seed=2, aiding="vio"))
    np.testing.assert_array_equal(scan_of(third, VLP16).range_m, noisy.range_m)


def test_what_is_too_near_or_too_far_is_not_measured(plant):
    scan = scan_of(plant, replace(VLP16, range_m=(3.0, 7.0), noise_m=0.0))
    met_m = scan.range_m[np.isfinite(scan.range_m)]
    assert met_m.min() >= 3.0
    assert met_m.max() <= 7.0


def test_the_mount_and_the_motion_are_in_the_points(plant):
    plant.align()
    lidar = Lidar(plant, replace(MID40, noise_m=0.0))
    poses, scan = {}, None
    for tick in range(300):
        goal = (-8.0 if tick > 240 else 0.0, 0.0, 3.0)  # at last backwards
        plant.apply(Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=goal, yaw_rad=0.0))
        plant.advance()
        poses[plant.time_us] = plant.truth
        scan = lidar.update() or scan

    def wall_error_m(points_flu_m, time_us):
        """Distance from the wall of what is seen of it from a pose."""
        state = poses[time_us]
        turn = Rotation.from_quat(state.quat_wxyz, scalar_first=True)
        points = turn.apply(points_flu_m) + state.position_enu_m
        return np.median(abs(points[points[:, 2] > 0.5, 0] - WALL_X_M))

    end_us = max(poses)
    assert scan.time_us == end_us
    assert wall_error_m(scan.points_flu_m[-100:], end_us) < 0.02
    assert wall_error_m(scan.points_flu_m[:100], end_us - 100_000) < 0.02
    assert wall_error_m(scan.points_flu_m[:100], end_us) > 0.1


def test_a_csv_file_is_fired_line_by_line(tmp_path, plant):
    path = tmp_path / "cross.csv"
    path.write_text("azimuth_deg,elevation_deg\n0,0\n90,0\n0,-90\n0,45\n")
    cfg = replace(lidar_by_name(str(path)), noise_m=0.0)
    scan = scan_of(plant, cfg)
    x, _, z = plant.truth.position_enu_m
    up_m = math.sqrt(2.0) * (WALL_X_M - x)
    assert scan.range_m == pytest.approx((WALL_X_M - x, math.inf, z + 0.1, up_m), abs=0.01)


HEAD = 'title = "mine"\nscan_hz = 10\nrange_m = [0.1, 30]\nnoise_m = 0.01\n'
SPINNING = "[spinning]\nbeams = 2\nelevations_deg = [-5, 5]\nstep_deg = 1\n"


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (HEAD, "spinning is missing; valid: one of [spinning], [rosette] and angles"),
        (HEAD + 'angles = "a.csv"\n' + SPINNING, "angles stands beside spinning; valid: one of"),
        (HEAD.replace("10\n", "0\n") + SPINNING, "scan_hz is 0; valid: 0.1 to 50 Hz"),
        (HEAD.replace("0.1, 30", "30, 1") + SPINNING, "valid: the least distance first"),
        (HEAD + "sweep = 1\n" + SPINNING, "sweep is unknown; valid: "),
        (HEAD + SPINNING.replace("= 1\n", "= 7\n"), "step_deg is 7; valid: a divisor of 360"),
        (HEAD + SPINNING.replace("[-5, 5]", "[-5]"), "valid: 2 numbers from -90 to 90 degrees"),
        (HEAD + SPINNING + "column_s = 1\n", "column_s is 1; valid: 0 to 0.000278 s"),
        (HEAD + 'angles = "none.csv"\n', "No such file or directory; valid: a file"),
        ("title = ", "is no TOML"),
        (HEAD + "[mount]\npitch_down_deg = 100\n" + SPINNING, "mount.pitch_down_deg is 100; valid"),
        (HEAD + SPINNING + "spin = 1\n", "spinning.spin is unknown; valid: beams"),
        (
            HEAD + "[rosette]\nprisms_rpm = [1, 2]\ndeflections_deg = [9, 90]\nshots_hz = 100\n",
            "rosette.deflections_deg is [9, 90]; valid: 2 numbers from 0 to 45 degrees",
        ),
    ],
)
def test_a_bad_file_is_refused_in_one_line(tmp_path, text, line):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(LidarError) as error:
        lidar_by_name(str(path))
    assert line in str(error.value)
    assert str(error.value).startswith(f"lidar '{tmp_path}")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("azimuth,elevation\n0,0\n", "line 1 is 'azimuth,elevation'; valid: azimuth_deg,elevation"),
        ("azimuth_deg,elevation_deg\n0,0\n0,91\n", "line 3 is '0,91'; valid: azimuth of -360"),
        ("azimuth_deg,elevation_deg\n0\n", "line 2 is '0'; valid"),
        ("", "line 1 is ''"),
    ],
)
def test_bad_angles_are_refused_in_one_line(tmp_path, text, line):
    path = tmp_path / "mine.csv"
    path.write_text(text)
    with pytest.raises(LidarError) as error:
        lidar_by_name(str(path))
    assert line in str(error.value)


def test_an_unknown_lidar_is_answered_with_the_valid_ones():
    with pytest.raises(LidarError, match=r"valid: vlp16, mid40, or a file FILE.toml or FILE.csv"):
        lidar_by_name("vlp")
