"""Layouts of rotors: which can be flown, and how they share a demand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from autonomy.model.dynamics import thrust_torque_matrix
from autonomy.model.layout import LayoutError, check_layout, inverse_allocation
from tests.autonomy.sample_quadrotors import IRIS, PLUS, ring


@pytest.mark.parametrize("vehicle", [IRIS, PLUS, ring(5), ring(6), ring(8), ring(12)])
def test_allocation_meets_each_demand_alone(vehicle):
    check_layout(vehicle)
    made = thrust_torque_matrix(vehicle) @ inverse_allocation(vehicle)
    np.testing.assert_allclose(made, np.eye(4), atol=1e-12)


def test_six_rotors_share_with_the_least_squares_of_thrusts():
    vehicle = ring(6)
    thrusts = inverse_allocation(vehicle) @ (12.0, 0.3, 0.0, 0.0)
    # Any other way of meeting the demand differs by what the matrix does not see.
    unseen = np.linalg.svd(thrust_torque_matrix(vehicle))[2][4:]
    np.testing.assert_allclose(unseen @ thrusts, 0.0, atol=1e-12)


def test_a_canted_rotor_lifts_less_and_turns_about_what_its_axis_leaves():
    tilt = math.radians(20.0)
    axis = (0.0, math.sin(tilt), math.cos(tilt))
    rotors = (replace(IRIS.rotors[0], axis_flu=axis, spin=1), *IRIS.rotors[1:])
    column = thrust_torque_matrix(replace(IRIS, rotors=rotors))[:, 0]
    lever_m = np.cross(rotors[0].position_flu_m, axis)
    np.testing.assert_allclose(column[1:], lever_m - 0.06 * np.array(axis))
    assert column[0] == math.cos(tilt)


def one_spin(vehicle):
    return replace(vehicle, rotors=tuple(replace(r, spin=1) for r in vehicle.rotors))


def on_one_line(vehicle):
    rotors = enumerate(vehicle.rotors)
    return replace(
        vehicle,
        rotors=tuple(replace(r, position_flu_m=(0.2 * (k - 2.4), 0.0, 0.0)) for k, r in rotors),
    )


def moved(vehicle, ahead_m):
    return replace(
        vehicle,
        rotors=tuple(
            replace(r, position_flu_m=(r.position_flu_m[0] + ahead_m, *r.position_flu_m[1:]))
            for r in vehicle.rotors
        ),
    )


def leaning(vehicle):
    axis = (math.sin(0.1), 0.0, math.cos(0.1))
    return replace(vehicle, rotors=tuple(replace(r, axis_flu=axis) for r in vehicle.rotors))


@pytest.mark.parametrize(
    ("vehicle", "fault"),
    [
        (replace(IRIS, rotors=IRIS.rotors[:3]), "3 rotors do not control .*; valid: 4 to 12"),
        (one_spin(IRIS), "no control of yaw of its own; valid: rotors of both spins"),
        (on_one_line(ring(6)), "no control of roll of its own"),
        (
            moved(IRIS, 0.125),
            "rotor 1 would carry .* of the weight in level hover; valid: at least",
        ),
        (
            replace(IRIS, mass_kg=2.4),
            "rotor 1 needs .* N in hover, of at most 7.07 N; valid: at mo",
        ),
        (leaning(ring(6)), "push sideways with .* of the weight in level hover; valid: axes that"),
    ],
)
def test_rotors_that_cannot_fly_are_refused_in_one_line(vehicle, fault):
    with pytest.raises(LayoutError, match=fault) as caught:
        check_layout(vehicle)
    assert "\n" not in str(caught.value)
