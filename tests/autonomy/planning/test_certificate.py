"""The certificate believes no trajectory that touches something or breaks a limit."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given

from autonomy.model.flatness import effort, hover_drag_per_s
from autonomy.planning import CertificateError, FlightLimits, Obstacles, certify
from autonomy.planning.demand import limit_peaks
from autonomy.planning.legs import plan_leg
from autonomy.planning.trajectory import Trajectory, YawProfile, coefficients_from_nodes
from tests.autonomy.planning_worlds import quadrotor, random_boxes, seeds

LIMITS = FlightLimits()
RADIUS = 0.4
STILL = YawProfile(step_s=0.1, yaw_rad=np.zeros(1))


def bent(rng, n=3):
    """A slow smooth curve through random points."""
    nodes = np.zeros((n + 1, 3, 3))
    nodes[:, 0] = rng.uniform(-8, 8, (n + 1, 3))
    nodes[1:-1, 1] = rng.normal(0, 0.5, (n - 1, 3))
    durations = np.full(n, 30.0)
    return Trajectory(
        durations_s=durations, coefficients=coefficients_from_nodes(nodes, durations), yaw=STILL
    )


@given(seeds)
def test_no_plan_that_collides_anywhere_is_ever_passed(seed):
    rng = np.random.default_rng(seed)
    trajectory, boxes = bent(rng), random_boxes(rng, 6)
    dense = trajectory.positions(np.linspace(0, trajectory.duration_s, 20_000))
    true_clearance = boxes.signed_distance(dense)[0].min() - RADIUS
    try:
        proof = certify(trajectory, boxes, RADIUS, LIMITS, quadrotor())
    except CertificateError:
        proof = None
    # It may refuse what passes by a hair, no more than the spacing of samples.
    assert true_clearance < 0.05 if proof is None else 0 < proof.min_clearance_m <= true_clearance


def test_a_plate_thinner_than_the_spacing_of_samples_is_found():
    way = plan_leg((0, 0, 5), (10, 0, 5), 0.0, LIMITS, quadrotor())
    plate = Obstacles.boxes(
        np.array([[5.013, 0.0, 5.0]]), np.array([[1.0, 0, 0, 0]]), np.array([[0.001, 2.0, 2.0]])
    )
    with pytest.raises(CertificateError, match=r"obstacle 0 at \(5\.0, 0\.0, 5\.0\)"):
        certify(way, plate, 0.02, LIMITS, quadrotor())


@pytest.mark.parametrize(
    ("name", "limits"),
    [
        ("horizontal speed", {"speed_horizontal_mps": 2.0}),
        ("vertical speed", {"speed_vertical_mps": 0.5}),
        ("horizontal acceleration", {"acceleration_mps2": 0.5}),
        ("thrust over mass", {"thrust_fraction": 0.4}),
        ("tilt", {"tilt_rad": 0.05}),
        ("body rate", {"body_rate_radps": 0.05}),
    ],
)
def test_each_limit_is_checked_and_named(name, limits):
    way = plan_leg((0, 0, 5), (20, 0, 9), 0.0, LIMITS, quadrotor())
    nothing = random_boxes(np.random.default_rng(0), 0)
    certify(way, nothing, RADIUS, LIMITS, quadrotor())
    with pytest.raises(CertificateError, match=f"^{name} reaches"):
        certify(way, nothing, RADIUS, dataclasses.replace(LIMITS, **limits), quadrotor())


def test_drag_counts_towards_the_tilt():
    way = plan_leg((0, 0, 5), (40, 0, 5), 0.0, LIMITS, quadrotor())
    nothing = random_boxes(np.random.default_rng(0), 0)
    proof = certify(way, nothing, RADIUS, LIMITS, quadrotor())
    times = np.linspace(0, way.duration_s, 4000)
    v, a = way.derivatives(times, 1)[:, 0], way.derivatives(times, 2)[:, 0]
    without = np.arctan2(np.abs(a), 9.81).max()
    drag = hover_drag_per_s(quadrotor())
    assert proof.max_tilt_rad == pytest.approx(np.arctan2(a + drag * v, 9.81).max(), rel=0.02)
    assert proof.max_tilt_rad > without + 0.02


@given(seeds)
def test_no_sample_exceeds_what_was_proved(seed):
    rng = np.random.default_rng(seed)
    nodes = rng.normal(0, 2.0, (4, 3, 3))
    durations = rng.uniform(0.8, 3.0, 3)
    coefficients = coefficients_from_nodes(nodes, durations)
    curve = Trajectory(durations_s=durations, coefficients=coefficients, yaw=STILL)
    proved = limit_peaks(curve, quadrotor())
    times = np.linspace(0, curve.duration_s, 7001)
    v, a, j = (curve.derivatives(times, order) for order in (1, 2, 3))
    asked = effort(v.T, a.T, j.T, quadrotor())
    for name, values in (
        ("max_speed_horizontal_mps", np.hypot(v[:, 0], v[:, 1])),
        ("max_acceleration_mps2", np.hypot(a[:, 0], a[:, 1])),
        ("max_specific_thrust_mps2", asked.specific_thrust_mps2),
    ):
        assert values.max() <= proved[name] + 1e-9
        assert proved[name] <= values.max() * 1.05 + 0.05


def test_a_curve_of_no_numbers_and_a_hasty_turn_are_refused():
    way = plan_leg((0, 0, 5), (10, 0, 5), 0.0, LIMITS, quadrotor())
    nothing = random_boxes(np.random.default_rng(0), 0)
    broken = dataclasses.replace(way, coefficients=way.coefficients * np.nan)
    with pytest.raises(CertificateError, match="not finite"):
        certify(broken, nothing, RADIUS, LIMITS, quadrotor())
    hasty = dataclasses.replace(way, yaw=YawProfile(step_s=0.1, yaw_rad=np.array([0.0, 1.0])))
    with pytest.raises(CertificateError, match=r"^yaw rate reaches 10"):
        certify(hasty, nothing, RADIUS, LIMITS, quadrotor())
