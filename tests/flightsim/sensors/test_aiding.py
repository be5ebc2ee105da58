"""Odometry, motion capture and rooms without satellites: errors as their data say."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from flightsim.environment.constellation import GPS
from flightsim.environment.effects import ALL_EFFECTS
from flightsim.environment.rooms import ROOM_COLUMNS, indoor_rooms, is_in_room
from flightsim.plant.sky import new_sky
from flightsim.sensors.gnss import GNSS, RTK, follow_gnss, hears_satellites, sample_gnss
from flightsim.sensors.mocap import MOCAP, MocapCfg, sample_mocap
from flightsim.sensors.sensor import SensorStart
from flightsim.sensors.vio import VIO, VioCfg, sample_vio
from scenarios.bench.manoeuvres import meadow

HZ = 250
LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
OPEN_SKY = new_sky((GPS,), 47.4, np.random.default_rng(0), ALL_EFFECTS)[0]


def odometry(rng, way_m, n_frames=100):
    """Error of the position that odometry reports after a straight way, and of its heading."""
    r = VIO.new(VioCfg(), SensorStart(tick_hz=HZ))[0]
    position = np.zeros(3)
    for k in range(1, n_frames + 1):
        position = np.array([way_m * k / n_frames, 0.0, 0.0])
        sample_vio(r, 10 * k, position, LEVEL, rng.standard_normal(VIO.n_normals))
    return r["position_vio_m"] - position, r["yaw_vio_rad"]


def test_odometry_drifts_by_half_a_percent_of_forty_metres():
    rng = np.random.default_rng(1)
    errors, headings = zip(*(odometry(rng, 40.0) for _ in range(400)), strict=True)
    along, across, up = np.std(errors, axis=0)
    walk = VioCfg().position_walk[0] * math.sqrt(40.0)
    assert along == pytest.approx(math.hypot(walk, 0.01), rel=0.1)
    assert across > 1.3 * walk  # what the heading does to a straight way comes on top
    assert up == pytest.approx(0.02 * math.sqrt(40.0), rel=0.1)
    assert 0.004 < math.sqrt(along**2 + across**2 + up**2) / 40.0 < 0.02
    expected = math.hypot(VioCfg().yaw_walk * math.sqrt(40.0), VioCfg().yaw_noise_rad)
    assert np.std(headings) == pytest.approx(expected, rel=0.1)


def test_odometry_does_not_drift_at_rest():
    error, heading = odometry(np.random.default_rng(2), 0.0)
    assert np.abs(error).max() < 0.05
    assert abs(heading) < 0.02


@given(st.floats(-3.0, 3.0), st.floats(-10.0, 10.0), st.floats(-10.0, 10.0))
def test_the_frame_of_odometry_begins_at_the_start(yaw, x, y):
    start, attitude = np.array([x, y, 2.0]), Rotation.from_euler("z", yaw)
    quat = attitude.as_quat(scalar_first=True)
    r = VIO.new(VioCfg(), SensorStart(tick_hz=HZ, position_enu_m=start, quat_wxyz=quat))[0]
    step = attitude.apply([3.0, 1.0, 0.5])
    sample_vio(r, 10, start + step, quat, np.zeros(VIO.n_normals))
    np.testing.assert_allclose(r["position_vio_m"], (3.0, 1.0, 0.5), atol=1e-9)
    assert r["yaw_vio_rad"] == pytest.approx(0.0, abs=1e-9)


def test_motion_capture_is_a_millimetre_off():
    r = MOCAP.new(MocapCfg(), SensorStart(tick_hz=HZ))[0]
    samples = []
    for row in np.random.default_rng(3).standard_normal((1000, MOCAP.n_normals)):
        sample_mocap(r, 2, np.array([1.0, 2.0, 3.0]), LEVEL, row)
        samples.append([*r["position_enu_m"], r["yaw_rad"]])
    np.testing.assert_allclose(np.mean(samples, axis=0), (1.0, 2.0, 3.0, 0.0), atol=2e-4)
    np.testing.assert_allclose(np.std(samples, axis=0), [1e-3] * 3 + [3e-3], rtol=0.1)


@given(st.floats(-math.pi, math.pi), st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
def test_a_turned_room_is_where_its_box_is(yaw, along, across):
    """Half extents 4 m by 2 m by 1.5 m about (10, -5, 2); points are fractions of them."""
    row = (10.0, -5.0, 2.0, math.cos(yaw), math.sin(yaw), 4.0, 2.0, 1.5)
    rooms = np.array([row])
    assert len(row) == len(ROOM_COLUMNS)
    offset = Rotation.from_euler("z", yaw).apply([4.0 * along, 2.0 * across, 0.0])
    is_inside = abs(along) < 1.0 and abs(across) < 1.0
    if min(abs(abs(along) - 1.0), abs(abs(across) - 1.0)) > 1e-6:
        assert is_in_room(rooms, np.array([10.0, -5.0, 2.0]) + offset) == is_inside
    assert not is_in_room(rooms, np.array([10.0, -5.0, 3.6]))
    assert not is_in_room(np.zeros((0, 8)), np.zeros(3))


def test_a_receiver_loses_its_fix_in_a_room_and_finds_it_slowly():
    rooms = indoor_rooms(meadow(has_room=True))
    assert rooms.shape == (1, 8)
    inside, outside = np.array([18.0, 0.0, 3.0]), np.array([0.0, 0.0, 3.0])
    r = GNSS.new(RTK, SensorStart(tick_hz=HZ))[0]
    assert hears_satellites(r, OPEN_SKY, rooms, outside)
    sample_gnss(r, 100, np.zeros(9))
    assert r["present_sigma_m"][0] == pytest.approx(0.01)
    assert not hears_satellites(r, OPEN_SKY, rooms, inside)
    first, sigmas = None, []
    for tick in range(1, 12 * HZ):
        follow_gnss(r, tick, outside, np.zeros(3))
        if tick % 25 == 0 and hears_satellites(r, OPEN_SKY, rooms, outside):
            first = first or tick
            sample_gnss(r, tick, np.zeros(9))
            sigmas.append(r["present_sigma_m"][0])
    assert first == HZ * RTK.reacquire_s
    assert sigmas[0] > 1.0
    assert np.all(np.diff(sigmas) < 0.0)
    assert sigmas[-1] < 0.012
