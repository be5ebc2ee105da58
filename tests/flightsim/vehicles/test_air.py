"""Aerodynamics besides the rotors' own: each model against its closed form or published numbers."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightsim.environment.effects import EffectError, Effects
from flightsim.vehicles.air.frame import frame_drag
from flightsim.vehicles.air.ground import ground_share
from flightsim.vehicles.air.inflow import ceiling_ratio, induced_ratio
from flightsim.vehicles.catalogue import AIRFRAMES

IRIS = AIRFRAMES["iris"]


def test_an_effect_is_left_out_by_its_name():
    effects = Effects.without("ground, ceiling")
    assert not effects.ground
    assert not effects.ceiling
    assert effects.inflow
    assert Effects.without("") == Effects()
    with pytest.raises(EffectError, match="'gravity' is unknown; valid: frame_drag, inflow"):
        Effects.without("gravity")


def test_the_bare_frame_is_its_box():
    x, y, z = IRIS.body_size_m
    expected = 0.5 * 1.225 * 1.05 * np.array([y * z, x * z, x * y])
    np.testing.assert_allclose(frame_drag(IRIS, has_arms=False), expected)


@pytest.mark.parametrize("name", AIRFRAMES)
def test_arms_and_legs_add_drag_along_every_axis(name):
    bare, whole = (frame_drag(AIRFRAMES[name], has_arms=has_arms) for has_arms in (False, True))
    assert np.all(whole > 1.3 * bare)


def without_legs(name, **more):
    return replace(AIRFRAMES[name], leg_length_m=0.009, leg_spread_m=1e-9, **more)


def area_m2(airframe):
    return frame_drag(airframe, has_arms=True) / (0.5 * 1.225)


def test_arms_are_round_bars_at_an_angle_to_the_flow():
    """CdA is 1.1 d l sin^3: all of it from above, from ahead by the angle of the arm."""
    area = area_m2(without_legs("iris", body_size_m=(0.0, 0.0, 0.0)))
    hubs = np.array([rotor.position_flu_m for rotor in IRIS.quadrotor.rotors])
    length_m = np.hypot(hubs[:, 0], hubs[:, 1])
    motors = 0.7 * 2.0 * 0.018 * hubs[:, 2].sum()
    assert area[2] == pytest.approx(1.1 * 0.020 * length_m.sum(), rel=1e-6)
    ahead = 1.1 * 0.020 * np.sum(length_m * np.abs(hubs[:, 1] / length_m) ** 3)
    assert area[0] == pytest.approx(ahead + motors, rel=1e-6)


def test_only_what_sticks_out_of_the_fuselage_counts():
    """The Hummingbird's arms lie along x and y: from ahead, two of them show 0.115 m each."""
    area = area_m2(without_legs("hummingbird"))
    box, arms, motors = 1.05 * 0.11 * 0.06, 1.1 * 0.020 * 2.0 * 0.115, 0.7 * 4.0 * 0.036 * 0.0095
    assert area[0] == pytest.approx(box + arms + motors, rel=1e-6)


@given(st.floats(0.0, 10.0), st.floats(0.0, 10.0))
def test_climb_and_forward_flight_obey_momentum_theory(x, y):
    """T = 2 rho A v_i U is the same as in hover, U the whole velocity through the disc."""
    f = induced_ratio(x, y**2)
    assert f * math.hypot(y, x + f) == pytest.approx(1.0, rel=2e-3)


def test_the_vortex_ring_is_blown_away_by_forward_speed():
    x = -1.2
    excess = [induced_ratio(x, y**2) - induced_ratio(0.0, y**2) for y in (0.0, 1.0, 3.0)]
    assert excess[0] > 0.9
    assert abs(excess[2]) < 0.1


@given(st.floats(-20.0, -2.0, exclude_max=True))
def test_the_windmill_brake_obeys_momentum_theory(x):
    """The wake goes up: -(x + f) f = 1."""
    f = induced_ratio(x, 0.0)
    assert -(x + f) * f == pytest.approx(1.0, rel=1e-6)


def test_the_vortex_ring_has_the_published_velocities():
    """Leishman's figure: f is 1 in hover, about 1.8 at x = -1, 2.1 at its worst, then falls."""
    assert induced_ratio(-1e-12, 0.0) == pytest.approx(1.0)
    assert induced_ratio(-1.0, 0.0) == pytest.approx(1.816, abs=1e-3)
    worst = max((induced_ratio(x, 0.0), x) for x in np.linspace(-2.0, 0.0, 401))
    assert worst[0] == pytest.approx(2.09, abs=0.02)
    assert worst[1] == pytest.approx(-1.45, abs=0.06)
    assert induced_ratio(-2.0 + 1e-9, 0.0) == pytest.approx(induced_ratio(-2.0, 0.0), abs=0.04)


def test_far_rotors_leave_cheeseman_and_bennett():
    """One rotor alone: T / T_open = 1 / (1 - (R / 4z)^2), 1.067 at z = R."""
    for z in (0.5, 1.0, 2.0):
        assert 1.0 / (1.0 - ground_share(z, 1.0, 1e9, 1e9)) == pytest.approx(
            1.0 / (1.0 - (1.0 / (4.0 * z)) ** 2)
        )


def test_neighbours_and_body_add_to_the_ground_effect():
    """A quadrotor feels it higher than one rotor: some 4% at 4 R, where Cheeseman has 0.4%."""
    radius, neighbour, opposite = 0.128, 0.35, 0.5
    assert ground_share(4.0 * radius, radius, neighbour, opposite) == pytest.approx(
        0.037, abs=0.005
    )
    assert ground_share(radius, radius, neighbour, opposite) == pytest.approx(0.14, abs=0.01)
    heights = np.linspace(0.08, 1.5, 60)
    shares = [ground_share(z, radius, neighbour, opposite) for z in heights]
    assert np.all(np.diff(shares) < 0.0)
    assert shares[-1] < 0.01


def test_a_ceiling_lessens_the_induced_velocity():
    """At a gap of R / 4, T = 2 rho A v_i^2 (1 + 16 / 32)."""
    assert ceiling_ratio(0.25, 1.0) == pytest.approx(math.sqrt(2.0 / 3.0))
    assert ceiling_ratio(math.inf, 1.0) == 1.0
    assert ceiling_ratio(4.0, 1.0) > 0.999
