"""The landing benchmark: the truth is exact, every measure has a row, errors wander as told."""

import math

import numpy as np
import pytest
from measuring.configs import LandBenchCfg
from measuring.land import rows
from measuring.landing_look import Wander
from measuring.landing_truth import ExactGround

from autonomy.perception import LandingNeeds
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import build_world
from scenarios.pilot.landing_watch import landing_needs
from tests.scenarios.landing_scenes import TOP_M, yard

HUMMINGBIRD = airframe_by_name("hummingbird")
NEEDS = LandingNeeds(footprint_radius_m=0.2, body_radius_m=0.4)


@pytest.fixture(scope="module")
def ground():
    return ExactGround(build_world(yard(), HUMMINGBIRD))


def judged(ground, east, north):
    return ground.judge(np.array([[east, north]]), 8.0, NEEDS)


def test_level_ground_is_safe_and_a_box_beside_it_is_not(ground):
    # A crate ends at (4.5, -1.5); the container, 2.5 m high, reaches from (6, -1.2) to (12, 1.2).
    assert judged(ground, 2.0, -6.0).is_safe[0]
    assert judged(ground, 4.5 + 0.42, -2.0).is_safe[0]
    beside = judged(ground, 4.5 + 0.37, -2.0)
    assert not beside.is_safe[0]
    assert beside.rise_m[0] == pytest.approx(1.0, abs=1e-3)


def test_a_rim_bears_the_feet_whatever_drops_off_beyond_it(ground):
    rim = judged(ground, 9.0, 1.2 - 0.22)
    assert rim.is_safe[0]
    assert rim.roughness_m[0] == pytest.approx(0.0, abs=1e-4)
    over = judged(ground, 9.0, 1.2 - 0.17)
    assert not over.is_safe[0]
    assert over.roughness_m[0] > 0.5 * TOP_M


def test_needs_without_scatter_are_those_of_the_vehicle_itself():
    bare = landing_needs(HUMMINGBIRD, 0.0)
    assert bare.footprint_radius_m == HUMMINGBIRD.leg_spread_m
    assert bare.body_radius_m == HUMMINGBIRD.collision_radius_m


def test_errors_wander_as_slowly_and_as_far_as_told():
    wander = Wander(np.array([0.09, 0.0]), 10.0, np.random.default_rng(1))
    path = []
    for _ in range(20_000):
        wander.step()
        path.append(wander.value)
    x = np.array(path)
    assert np.std(x[:, 0]) == pytest.approx(0.09, rel=0.15)
    assert np.all(x[:, 1] == 0.0)
    after = np.mean(x[:-50, 0] * x[50:, 0]) / x[:, 0].var()
    assert after == pytest.approx(math.exp(-1.0), abs=0.12)


def test_every_measure_has_a_row():
    titles = []
    cfg = LandBenchCfg(areas=2, flights=0)
    found = {row.metric: row for row in rows(cfg, lambda title, _: titles.append(title))}
    assert titles == ["scene 0", "scene 1015", "map update", "done"]
    assert found["areas looked at"].value == 2
    targets = {
        "unsafe sites, committed to at the last look": 0.5,
        "unsafe cells among those taken for safe": 2.0,
        "map update, 320 x 240, least": 8.0,
    }
    for metric, target in targets.items():
        assert found[metric].target == target
    assert found["areas with a site to land on"].value == 100.0
