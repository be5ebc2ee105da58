"""Flatness with rotor drag: the forces add up, and numbers and expressions agree."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.model.flatness import drag_constant, effort, hover_drag_per_s
from autonomy.model.quadrotor import GRAVITY_MPS2
from tests.autonomy.planning_worlds import quadrotor, seeds

UP = np.array([0.0, 0.0, GRAVITY_MPS2])


def motion(seed):
    rng = np.random.default_rng(seed)
    return rng.uniform(-6, 6, 3), rng.uniform(-5, 5, 3), rng.uniform(-10, 10, 3)


def axis(v, a, asked):
    h = a + UP + asked.drag_per_s * v
    return h / np.linalg.norm(h)


@given(seeds)
def test_thrust_drag_and_weight_make_the_acceleration(seed):
    v, a, j = motion(seed)
    asked = effort(v, a, j, quadrotor())
    z = axis(v, a, asked)
    drag = asked.drag_per_s * (v - (v @ z) * z)
    np.testing.assert_allclose(asked.specific_thrust_mps2 * z - drag - UP, a, atol=2e-3)
    assert asked.cos_tilt == pytest.approx(z[2], abs=1e-6)
    # Rotors that share the thrust turn at this speed, and drag by it.
    q = quadrotor()
    speed = np.sqrt(asked.specific_thrust_mps2 * q.mass_kg / (4 * q.rotors[0].thrust_constant))
    drag_per_s = 4 * q.rotors[0].drag_coefficient * speed / q.mass_kg
    assert asked.drag_per_s == pytest.approx(drag_per_s, rel=1e-6)


def test_hover_asks_for_the_weight_and_no_turn():
    zero = np.zeros(3)
    asked = effort(zero, zero, zero, quadrotor())
    assert asked.specific_thrust_mps2 == pytest.approx(GRAVITY_MPS2, rel=1e-6)
    assert asked.cos_tilt == pytest.approx(1.0)
    assert asked.tilt_rate_radps == pytest.approx(0.0, abs=2e-4)
    assert hover_drag_per_s(quadrotor()) == pytest.approx(asked.drag_per_s, rel=1e-6)
    assert drag_constant(quadrotor()) > 0


@given(seeds)
def test_the_tilt_rate_is_how_fast_the_thrust_axis_turns(seed):
    v, a, j = motion(seed)
    step = 1e-4

    def axis_at(t):
        velocity, acceleration = v + a * t + j * t * t / 2, a + j * t
        return axis(velocity, acceleration, effort(velocity, acceleration, j, quadrotor()))

    turned = np.linalg.norm(axis_at(step) - axis_at(-step)) / (2 * step)
    assert effort(v, a, j, quadrotor()).tilt_rate_radps == pytest.approx(turned, rel=0.03, abs=0.01)


@given(st.lists(seeds, min_size=1, max_size=4))
def test_casadi_numbers_and_arrays_agree(seed_list):
    batch = np.array([motion(seed) for seed in seed_list])
    together = effort(*(batch[:, order].T for order in range(3)), quadrotor())
    symbols = [ca.SX.sym(name, 3) for name in "vaj"]
    asked = effort(*(ca.vertsplit(symbol) for symbol in symbols), quadrotor())
    names = ("specific_thrust_mps2", "cos_tilt", "tilt_rate_radps", "force_mps2", "drag_per_s")
    function = ca.Function("effort", symbols, [getattr(asked, name) for name in names])
    for index, (v, a, j) in enumerate(batch):
        one = effort(v, a, j, quadrotor())
        for name, symbolic in zip(names, function(v, a, j), strict=True):
            expected = getattr(one, name)
            assert float(symbolic) == pytest.approx(expected, rel=1e-9, abs=1e-12)
            assert getattr(together, name)[index] == pytest.approx(expected, rel=1e-9, abs=1e-12)
