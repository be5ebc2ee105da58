"""Distances to solids are exact outside, never too large, and their planes separate."""

import numpy as np
import pytest
from hypothesis import given
from scipy.optimize import nnls

from autonomy.planning.obstacles import Obstacles, Shape, join, rotation_matrices
from autonomy.planning.solids import plane_between, plane_to_segment, support
from tests.autonomy.planning_worlds import points_in_boxes, random_boxes, random_quats, seeds

PRISM = np.array(
    [[-2.0, -1.0, -0.5], [2.0, -1.0, -0.5], [-2.0, 1.0, -0.5], [2.0, 1.0, -0.5]]
    + [[-2.0, 0.0, 0.5], [2.0, 0.0, 0.5]]
)
"""Corners of a gable roof."""
S = 0.5**0.5
PRISM_FACES = np.array(
    [[1, 0, 0, 2], [-1, 0, 0, 2], [0, 0, -1, 0.5], [0, S, S, 0.5 * S], [0, -S, S, 0.5 * S]]
)


def one(shape, size, quat=(1.0, 0.0, 0.0, 0.0), center=(0.0, 0.0, 0.0)):
    is_hull = shape is Shape.HULL
    return Obstacles(
        center_enu_m=np.array([center], dtype=float),
        quat_wxyz=np.array([quat], dtype=float),
        size_m=np.array([size], dtype=float),
        shape=np.array([int(shape)]),
        faces=PRISM_FACES if is_hull else np.zeros((0, 4)),
        faces_end=np.array([len(PRISM_FACES) if is_hull else 0]),
    )


def surface_points(shape, size, rng, n):
    """Points on the surface of a solid, or in it, that hold all its extreme points closely."""
    half = np.array(size) / 2
    if shape is Shape.BOX:
        return np.clip(rng.uniform(-1.5, 1.5, (n, 3)), -1, 1) * half
    if shape is Shape.ELLIPSOID:
        direction = rng.normal(size=(n, 3))
        return direction / np.linalg.norm(direction, axis=1, keepdims=True) * half
    if shape is Shape.CYLINDER:
        angle = rng.uniform(0, 2 * np.pi, n)
        radius = half[0] * np.minimum(rng.uniform(0, 1.5, n), 1)
        height = np.clip(rng.uniform(-1.5, 1.5, n), -1, 1) * half[2]
        return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])
    return rng.dirichlet(np.full(len(PRISM), 0.2), n) @ PRISM


SOLIDS = [
    (Shape.BOX, (1.0, 2.0, 0.4)),
    (Shape.CYLINDER, (1.5, 1.5, 0.6)),
    (Shape.ELLIPSOID, (3.0, 1.0, 1.8)),
    (Shape.HULL, (4.0, 2.0, 1.0)),
]


@pytest.mark.parametrize(("shape", "size"), SOLIDS)
def test_distance_is_that_to_the_nearest_of_many_surface_points(shape, size):
    rng = np.random.default_rng(5)
    quat = tuple(random_quats(rng, 1)[0].tolist())
    solid = one(shape, size, quat, (1.0, -2.0, 0.5))
    local = surface_points(shape, size, rng, 60_000)
    world = local @ rotation_matrices(np.array([quat]))[0].T + [1.0, -2.0, 0.5]
    for point in rng.uniform(-5, 5, (20, 3)):
        distance = solid.signed_distance(point[None])[0][0]
        sampled = np.linalg.norm(world - point, axis=1).min()
        if distance > 0:
            assert distance <= sampled + 1e-6
            assert sampled - distance < 0.05
        else:
            assert sampled < 2.0


def test_distance_to_a_roof_is_exact_also_beside_its_edges():
    rng = np.random.default_rng(1)
    points = rng.uniform(-6, 6, (200, 3))
    distance, _ = one(Shape.HULL, (4.0, 2.0, 1.0)).signed_distance(points)
    for point, d in zip(points, distance, strict=True):
        weights, _ = nnls(np.vstack([PRISM.T, np.full(len(PRISM), 1e3)]), np.append(point, 1e3))
        exact = np.linalg.norm(PRISM.T @ weights - point)
        assert d <= 0 or d == pytest.approx(exact, abs=2e-3)


@given(seeds)
def test_planes_touch_the_solid_and_leave_the_point_on_the_other_side(seed):
    rng = np.random.default_rng(seed)
    shape, size = SOLIDS[seed % 4]
    quat = tuple(random_quats(rng, 1)[0].tolist())
    solid = one(shape, size, quat)
    point = rng.uniform(-5, 5, 3)
    distance, *normal, offset = plane_between(*point, 0, solid.solids)
    world = surface_points(shape, size, rng, 300) @ rotation_matrices(np.array([quat]))[0].T
    assert np.linalg.norm(normal) == pytest.approx(1.0)
    assert np.all(world @ normal <= offset + 1e-9)
    assert np.all(world @ normal <= support(*normal, 0, solid.solids) + 1e-9)
    if distance > 0:
        assert point @ normal - offset == pytest.approx(distance, abs=1e-6)


@given(seeds)
def test_the_plane_nearest_to_a_segment_has_all_of_it_on_one_side(seed):
    rng = np.random.default_rng(seed)
    shape, size = SOLIDS[seed % 4]
    solid = one(shape, size, tuple(random_quats(rng, 1)[0].tolist()))
    p, q = rng.uniform(-8, 8, (2, 3))
    distance, *normal, offset = plane_to_segment(p, q, 0, solid.solids)
    along = p + np.linspace(0, 1, 50)[:, None] * (q - p)
    assert distance <= solid.signed_distance(along)[0].min() + 1e-6
    if distance > 0.05:
        assert np.all(along @ normal - offset >= distance - 1e-2)


@given(seeds)
def test_distance_is_negative_inside_and_changes_no_faster_than_the_point_moves(seed):
    rng = np.random.default_rng(seed)
    boxes = random_boxes(rng, 5)
    inside = points_in_boxes(rng, boxes, 20)
    assert np.all(boxes.signed_distance(inside)[0] <= 1e-9)
    a = rng.uniform(-12, 12, (50, 3))
    b = a + rng.normal(0, 1, a.shape)
    change = np.abs(boxes.signed_distance(a)[0] - boxes.signed_distance(b)[0])
    assert np.all(change <= np.linalg.norm(a - b, axis=1) + 1e-9)


def test_the_nearest_of_many_is_named_and_an_empty_world_is_far_away():
    boxes = random_boxes(np.random.default_rng(3), 30)
    distance, nearest = boxes.signed_distance(np.zeros((1, 3)))
    each = [
        Obstacles.boxes(c[None], q[None], s[None]).signed_distance(np.zeros((1, 3)))[0][0]
        for c, q, s in zip(boxes.center_enu_m, boxes.quat_wxyz, boxes.size_m, strict=True)
    ]
    assert nearest[0] == np.argmin(each)
    assert distance[0] == min(each)
    nothing = Obstacles.boxes(np.zeros((0, 3)), np.zeros((0, 4)), np.zeros((0, 3)))
    assert nothing.signed_distance(np.zeros((1, 3))) == (np.inf, -1)


def test_joined_groups_keep_their_faces():
    roof, box = one(Shape.HULL, (4.0, 2.0, 1.0)), one(Shape.BOX, (1.0, 1.0, 1.0), center=(9, 0, 0))
    both = join([box, roof, roof])
    points = np.random.default_rng(0).uniform(-5, 12, (40, 3))
    expected = np.minimum(box.signed_distance(points)[0], roof.signed_distance(points)[0])
    np.testing.assert_array_equal(both.signed_distance(points)[0], expected)
