from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from aeroscene.feasibility.least_change import least_change

seeds = st.integers(0, 2**32 - 1)


@given(seeds)
def test_agrees_with_a_general_solver(seed):
    rng = np.random.default_rng(seed)
    demands = rng.normal(size=(4, 5))
    bounds = demands @ rng.normal(size=5)
    weights = rng.uniform(0.5, 2.0, size=5)
    x = least_change(demands, bounds, weights, 20_000)
    expected = minimize(
        lambda v: 0.5 * weights @ v**2,
        np.zeros(5),
        jac=lambda v: weights * v,
        constraints={"type": "ineq", "fun": lambda v: demands @ v - bounds},
        method="SLSQP",
        options={"ftol": 1e-12, "maxiter": 500},
    )
    assert (demands @ x >= bounds - 0.05).all()
    assert 0.5 * weights @ x**2 <= expected.fun + 1e-3


def test_changes_nothing_where_all_demands_are_met():
    demands = np.array([[1.0, 0.0], [0.0, -1.0]])
    assert not least_change(demands, np.array([-0.1, 0.0]), np.ones(2), 100).any()


def test_contradicting_demands_drive_nothing_away():
    demands = np.array([[1.0], [-1.0]])
    for sweeps in (100, 1000, 10_000):
        x = least_change(demands, np.array([1.0, 1.0]), np.ones(1), sweeps)
        assert abs(x[0]) <= 1.0
