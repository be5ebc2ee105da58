"""`bench control`: the curve it flies, the trials it draws, and its rows on a small scale."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.types import OFF
from flightsim.plant import Plant, PlantCfg
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from scenarios.bench.configs import ControlBenchCfg
from scenarios.bench.control import rows
from scenarios.bench.figure_eight import SETTLED_S, FigureEight, come_back, take_off
from scenarios.bench.recovery import recover
from tests.flightsim.handmade import empty_scene


@pytest.fixture(scope="module")
def world():
    return build_world(empty_scene(), AIRFRAMES["hummingbird"])


def eight(peak=7.0):
    return FigureEight(centre_enu_m=(1.0, 2.0, 30.0), peak_acceleration_mps2=peak)


@given(st.floats(2.0, 40.0))
def test_the_eight_peaks_at_the_acceleration_and_speed_it_says(peak):
    curve = eight(peak)
    t = SETTLED_S + np.linspace(0.0, curve.lap_s, 2000)
    _, v, a, _ = curve.derivatives_enu(t)
    assert np.linalg.norm(a, axis=1).max() == pytest.approx(peak, rel=1e-3)
    assert np.linalg.norm(v, axis=1).max() == pytest.approx(curve.peak_speed_mps, rel=1e-3)


@given(st.floats(0.01, 20.0))
def test_each_derivative_is_that_of_the_one_before(t):
    if abs(t - SETTLED_S) < 1e-3:
        return
    h = 1e-4
    before, at, after = eight().derivatives_enu(np.array([t - h, t, t + h])).swapaxes(0, 1)
    np.testing.assert_allclose((after[:3] - before[:3]) / (2.0 * h), at[1:], atol=1e-4)


def test_it_begins_at_rest_in_its_centre():
    p, v, a, _ = eight().derivatives_enu(np.zeros(1))[:, 0]
    np.testing.assert_allclose(p, (1.0, 2.0, 30.0))
    np.testing.assert_allclose((v, a), 0.0, atol=1e-12)


def test_a_controller_that_knows_the_truth_does_not_follow_the_estimate(world):
    plant = Plant(world, PlantCfg(seed=3, gnss="standard", state="truth"))
    hover = take_off(plant)
    track = come_back(plant, hover, 3.0)
    assert np.linalg.norm(track.error_true_m[-1]) < 0.01
    assert np.linalg.norm(track.error_est_m[-1]) > 0.1


@pytest.mark.parametrize("name", ["iris", "hummingbird"])
def test_every_random_attitude_and_rate_is_recovered_from(name):
    world, rng = build_world(empty_scene(), AIRFRAMES[name]), np.random.default_rng(7)
    trials = [recover(world, 0, rng) for _ in range(25)]
    assert all(trial.is_recovered for trial in trials)
    assert max(trial.start_tilt_rad for trial in trials) > math.radians(150.0)


def test_a_vehicle_with_its_rotors_off_is_not_recovered(world):
    assert not recover(world, 0, np.random.default_rng(7), order=OFF).is_recovered


def test_the_same_generator_throws_the_same_way_again(world):
    first, again = (recover(world, 1, np.random.default_rng(5)) for _ in range(2))
    assert first == again


def test_rows_meet_their_targets_and_say_how_far_they_are():
    titles = []
    cfg = ControlBenchCfg(count=3, flights=1, seed=2, vehicles=("hummingbird",))
    measured = list(rows(cfg, lambda title, _: titles.append(title)))
    assert titles[-1] == "done"
    assert all(row.is_met for row in measured)
    value = {row.metric: row.value for row in measured}
    weight_share = 100.0 * AIRFRAMES["hummingbird"].quadrotor.hover_thrust_fraction
    assert value["hummingbird, hover throttle"] == pytest.approx(weight_share, rel=0.01)
    step = "hummingbird, step of 15 degrees of roll: "
    assert 0.1 < value[f"{step}rise from 10 to 90 %"] < 0.25
    assert value[f"{step}overshoot"] < 5.0
    assert value["hummingbird, step of 2 m aside: within 5 cm after"] < 4.0
    assert sum(row.target is not None for row in measured) == 6
