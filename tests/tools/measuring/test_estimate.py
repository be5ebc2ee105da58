"""`tools/bench.py estimate` in small, and the statistics that it rests on."""

from collections import deque

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from measuring.configs import EstimateBenchCfg
from measuring.consistency import attitude_error, band, nees
from measuring.estimate import CASES, largest_jump, rows
from measuring.filter_step import run_filter
from scipy.spatial.transform import Rotation

from flightsim.plant import Plant, PlantCfg
from flightsim.plant.record import HISTORY_DTYPE
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from scenarios.bench.manoeuvres import curves, fly, meadow


def test_every_case_block_and_limit_is_reported():
    cfg = EstimateBenchCfg(count=1, vehicle="hummingbird", seed=5, seconds=2.0)
    said = []
    found = {row.metric: row for row in rows(cfg, lambda *progress: said.append(progress))}
    assert len(said) == len(CASES) + 3
    for case in CASES:
        for block in ("position", "velocity", "attitude"):
            assert found[f"{case.title}: NEES of {block}, not above"].better == "lower"
            assert found[f"{case.title}: NEES of {block}, not below"].better == "higher"
            assert found[f"{case.title}: error of {block}, RMS"].value > 0
    jump = found["through a door: largest jump of the estimate"]
    assert jump.target == 0.1
    assert 0.0 < jump.value < 0.1
    assert 20 < found["through a door: time without fix"].value < 90
    for metric in ("mean at the sensors' rates", "with every measurement"):
        assert any(metric in name and row.target == 20.0 for name, row in found.items())


def test_the_band_is_that_of_the_chi_square_law():
    # Bar-Shalom et al. 2001, tables: 300 degrees of freedom
    limits = band(100)
    assert limits.low == pytest.approx(2.54, abs=0.01)
    assert limits.high == pytest.approx(3.50, abs=0.01)


@given(
    hnp.arrays(float, 3, elements=st.floats(-3.0, 3.0)),
    hnp.arrays(float, 3, elements=st.floats(-1.0, 1.0)),
    st.sampled_from([1.0, -1.0]),
)
def test_attitude_error_turns_the_estimate_into_the_truth(attitude, error, sign):
    estimate = Rotation.from_rotvec(attitude)
    true = Rotation.from_rotvec(error) * estimate
    found = attitude_error(
        sign * true.as_quat(scalar_first=True), estimate.as_quat(scalar_first=True)
    )
    np.testing.assert_allclose(found, error, atol=1e-9)


def test_a_jump_is_what_velocity_does_not_explain():
    history = np.zeros(6, HISTORY_DTYPE)
    history["time_us"] = np.arange(6) * 4000
    history["velocity_est_enu_mps"][:, 0] = 5.0
    history["position_est_enu_m"][:, 0] = 5.0 * 0.004 * np.arange(6)
    assert largest_jump(history) == pytest.approx(0.0, abs=1e-12)
    history["position_est_enu_m"][3:, 1] += 0.07
    assert largest_jump(history) == pytest.approx(0.07)


def test_the_filter_that_is_timed_goes_on_filtering():
    plant = Plant(
        build_world(meadow(has_room=False), AIRFRAMES["iris"]), PlantCfg(seed=0, aiding="auto")
    )
    deque(fly(plant, curves(np.random.default_rng(0)), 1.0), maxlen=0)
    assert all(value < 30.0 for value in nees(plant).values())
    filters = np.array([plant.filter])
    before = filters[0]["n_innovations"].copy()
    run_filter(filters, 100, True)
    assert np.all(np.isfinite(filters[0]["covariance"]))
    seen = filters[0]["n_innovations"] - before
    kinds = (
        3,
        3,
        1,
        1,
        3,
        1,
        0,
        0,
        0.4,
        0,
    )  # scalars a step, of `MEASUREMENTS`: nothing is refused
    np.testing.assert_array_equal(seen, 100 * np.array(kinds))
