"""Quaternion kernels against scipy, and the axioms of rotations."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from autonomy.rotation import (
    matrix_from_quat,
    quat_from_rotation_vector,
    quat_multiply,
    quat_normalise,
    rotation_vector_from_quat,
    wrap_angle,
    yaw_from_quat,
)

components = st.floats(-1.0, 1.0, allow_subnormal=False)
# near-singular ones are in: zero, tiny, and up to just below half a turn
lengths = st.one_of(st.just(0.0), st.floats(1e-12, 1e-3), st.floats(1e-3, math.pi - 1e-6))


@st.composite
def rotation_vectors(draw):
    axis = draw(hnp.arrays(float, 3, elements=components))
    norm = np.linalg.norm(axis)
    axis = np.array([0.0, 0.0, 1.0]) if norm < 1e-3 else axis / norm
    return draw(lengths) * axis


def quat_of(vector):
    q = np.empty(4)
    quat_from_rotation_vector(*vector, q)
    return q


def matrix_of(q):
    R = np.empty((3, 3))
    matrix_from_quat(q, R)
    return R


@given(rotation_vectors())
def test_exponential_and_logarithm_are_inverse(vector):
    back = np.empty(3)
    rotation_vector_from_quat(quat_of(vector), back)
    np.testing.assert_allclose(back, vector, atol=1e-9)


@given(rotation_vectors())
def test_logarithm_does_not_see_the_sign_of_the_quaternion(vector):
    back = np.empty(3)
    rotation_vector_from_quat(-quat_of(vector), back)
    np.testing.assert_allclose(back, vector, atol=1e-9)


@given(rotation_vectors())
def test_matrix_agrees_with_scipy_and_is_orthonormal(vector):
    R = matrix_of(quat_of(vector))
    np.testing.assert_allclose(R, Rotation.from_rotvec(vector).as_matrix(), atol=1e-12)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)


@given(rotation_vectors(), rotation_vectors())
def test_product_of_quaternions_is_product_of_matrices(a, b):
    product = quat_of(a)
    quat_multiply(product, quat_of(b), product)  # in place
    np.testing.assert_allclose(
        matrix_of(product), matrix_of(quat_of(a)) @ matrix_of(quat_of(b)), atol=1e-12
    )


@given(st.floats(-math.pi, math.pi), st.floats(-1.4, 1.4), st.floats(-3.1, 3.1))
def test_yaw_is_that_of_the_euler_angles(yaw, pitch, roll):
    q = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_quat(scalar_first=True)
    assert abs(wrap_angle(yaw_from_quat(q) - yaw)) < 1e-9


@given(hnp.arrays(float, 4, elements=st.floats(0.1, 3.0)))
def test_normalised_quaternion_has_unit_length(q):
    quat_normalise(q)
    assert math.isclose(np.linalg.norm(q), 1.0, rel_tol=1e-12)


@given(st.floats(-50.0, 50.0))
def test_wrapped_angle_is_the_same_direction_within_a_turn(angle):
    wrapped = wrap_angle(angle)
    assert -math.pi <= wrapped <= math.pi
    assert math.isclose(math.cos(wrapped), math.cos(angle), abs_tol=1e-9)
    assert math.isclose(math.sin(wrapped), math.sin(angle), abs_tol=1e-9)
