"""Random worlds of boxes, for tests of the planner."""

import numpy as np
from hypothesis import strategies as st
from scipy import ndimage

from autonomy.model import QuadrotorParams, RotorParams
from autonomy.planning import DistanceField, MovingObstacles, Obstacles
from autonomy.planning.obstacles import join, rotation_matrices

GROUND = Obstacles.boxes(
    np.array([[0.0, 0.0, -1.0]]), np.array([[1.0, 0.0, 0.0, 0.0]]), np.array([[200.0, 200.0, 2.0]])
)

seeds = st.integers(0, 2**32 - 1)


def quadrotor():
    """Quadrotor similar to an Iris: hovers at 40% of its thrust."""
    rotor = RotorParams(
        position_flu_m=(0.2, 0.2, 0.0),
        spin=1,
        thrust_constant=9.4e-6,
        torque_per_thrust_m=0.06,
        time_constant_up_s=0.0125,
        time_constant_down_s=0.025,
        max_speed_radps=1000.0,
        drag_coefficient=1e-4,
        rolling_moment_coefficient=1e-6,
    )
    return QuadrotorParams(
        mass_kg=1.5, inertia_flu_kgm2=(0.03, 0.03, 0.05), rotors=(rotor, rotor, rotor, rotor)
    )


def random_quats(rng, n, *, upright=False):
    if upright:
        half = rng.uniform(0, np.pi, n)
        return np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=1)
    q = rng.normal(size=(n, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def random_boxes(rng, n, *, extent=10.0, upright=False):
    return Obstacles.boxes(
        rng.uniform(-extent, extent, (n, 3)),
        random_quats(rng, n, upright=upright),
        rng.uniform(0.3, 4.0, (n, 3)),
    )


def town(rng, n=8, half_extent=14.0):
    """Upright blocks on the ground, free near two opposite corners."""
    center = rng.uniform(-half_extent + 5, half_extent - 5, (n, 3))
    size = np.column_stack([rng.uniform(2, 6, (n, 2)), rng.uniform(3, 9, n)])
    center[:, 2] = size[:, 2] / 2
    blocks = Obstacles.boxes(center, random_quats(rng, n, upright=True), size)
    return join([blocks, GROUND])


def field_of(obstacles, half_extent=14.0, height=12.0, resolution=0.5):
    """Distance field of a world, from voxels that the solids touch."""
    axes = [np.arange(-half_extent, half_extent, resolution)] * 2
    axes.append(np.arange(0.0, height, resolution))
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    distance, _ = obstacles.signed_distance(grid.reshape(-1, 3))
    occupied = distance.reshape(grid.shape[:3]) < resolution * 0.87
    distance_m = ndimage.distance_transform_edt(~occupied) * resolution
    return DistanceField(
        origin_enu_m=tuple(grid[0, 0, 0].tolist()),
        resolution_m=resolution,
        distance_m=distance_m.astype(np.float32),
    )


def points_in_boxes(rng, boxes, n):
    """Random points on and in the boxes, including surfaces and corners."""
    which = rng.integers(0, len(boxes), n)
    share = np.clip(rng.uniform(-0.7, 0.7, (n, 3)), -0.5, 0.5)
    rotation = rotation_matrices(boxes.quat_wxyz)[which]
    return boxes.center_enu_m[which] + np.einsum(
        "nij,nj->ni", rotation, share * boxes.size_m[which]
    )


def ball(position, velocity, radius=0.4, **options):
    """One mover that is a ball."""
    return MovingObstacles.balls([position], [velocity], [radius], **options)
