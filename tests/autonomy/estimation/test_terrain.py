"""Terrain height is a state of its own: a roof's edge never reaches the altitude."""

import math

import numpy as np
import pytest

from autonomy.estimation.terrain import fuse_range
from tests.autonomy.sample_filters import moving_filter


def hovering(height_m=10.0):
    f = moving_filter(np.array([2.0, 0.0, 0.0]))
    f["position_enu_m"] = (0.0, 0.0, height_m)
    return f


def test_first_range_sets_the_height_below():
    f = hovering()
    assert math.isnan(f["terrain_height_m"])
    fuse_range(f, 4.0, 0.02)
    assert f["terrain_height_m"] == pytest.approx(6.0)


def test_noise_is_averaged_and_the_deviation_known():
    f = hovering()
    rng = np.random.default_rng(0)
    for _ in range(200):
        fuse_range(f, 10.0 + 0.05 * rng.normal(), 0.02)
    assert f["terrain_height_m"] == pytest.approx(0.0, abs=0.04)
    assert 0.0 < f["terrain_variance_m2"] < 0.05**2


def test_an_edge_starts_the_terrain_again_and_leaves_the_altitude():
    f = hovering()
    for _ in range(50):
        fuse_range(f, 4.0, 0.02)
    altitude = f["position_enu_m"][2]
    fuse_range(f, 10.0, 0.02)
    assert f["terrain_height_m"] == pytest.approx(6.0)  # one outlier is refused
    for _ in range(3):
        fuse_range(f, 10.0, 0.02)
    assert f["terrain_height_m"] == pytest.approx(0.0, abs=0.05)
    assert f["position_enu_m"][2] == altitude


@pytest.mark.parametrize("reading", [math.inf, math.nan])
def test_no_echo_keeps_the_height(reading):
    f = hovering()
    fuse_range(f, 4.0, 0.02)
    fuse_range(f, reading, 0.02)
    assert f["terrain_height_m"] == pytest.approx(6.0)


def test_a_tilted_ray_is_projected_and_a_steep_one_ignored():
    f = hovering()
    f["quat_wxyz"] = (math.cos(0.25), math.sin(0.25), 0.0, 0.0)
    fuse_range(f, 10.0 / math.cos(0.5), 0.02)
    assert f["terrain_height_m"] == pytest.approx(0.0, abs=1e-9)
    f["quat_wxyz"] = (math.cos(0.6), math.sin(0.6), 0.0, 0.0)
    for _ in range(10):
        fuse_range(f, 3.0, 0.02)
    assert f["terrain_height_m"] == pytest.approx(0.0, abs=1e-9)
