import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightsim.looks.tessellation import box, capsule, cylinder, ellipsoid, hull

LENGTH = st.floats(0.05, 20.0)
PRISM = np.array([(-2, -1, 0), (2, -1, 0), (2, 1, 0), (-2, 1, 0), (-2, 0, 1), (2, 0, 1)], float)


def volume_m3(surface):
    a, b, c = (surface.corners_m()[:, k] for k in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6


def area_vectors(surface):
    a, b, c = (surface.corners_m()[:, k] for k in range(3))
    return np.cross(b - a, c - a) / 2


def check(surface, full_m3, least_share):
    """Closed, outward, of unit normals, and as large as the solid it stands for."""
    areas = area_vectors(surface)
    scale = np.abs(areas).sum()
    np.testing.assert_allclose(areas.sum(axis=0), 0.0, atol=1e-9 * scale)
    assert least_share * full_m3 * (1 - 1e-9) <= volume_m3(surface) <= full_m3 * (1 + 1e-9)
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=1), 1.0, atol=1e-9)
    corner_normals = surface.normals[surface.triangles].mean(axis=1)
    assert (np.einsum("ij,ij->i", corner_normals, areas) > 0).all()


@given(LENGTH, LENGTH, LENGTH)
def test_box_is_a_box_with_metres_of_texture(x, y, z):
    surface = box(np.array([x, y, z]))
    check(surface, x * y * z, 1.0)
    triangles = surface.triangles
    for k in range(3):
        i, j = triangles[:, k], triangles[:, (k + 1) % 3]
        on_solid = np.linalg.norm(surface.vertices_m[i] - surface.vertices_m[j], axis=1)
        on_texture = np.linalg.norm(surface.texture_m[i] - surface.texture_m[j], axis=1)
        np.testing.assert_allclose(on_texture, on_solid, rtol=1e-9)


def test_texture_of_a_wall_stands_upright_on_all_four_sides():
    surface = box(np.array([6.0, 4.0, 3.0]))
    sides = np.abs(surface.normals[:, 2]) < 0.5
    np.testing.assert_allclose(
        surface.texture_m[sides, 1], surface.vertices_m[sides, 2] + 1.5, atol=1e-12
    )


RATIO = st.floats(0.4, 2.5)


@given(LENGTH, RATIO, RATIO, st.integers(6, 30), st.integers(4, 20))
def test_ellipsoid_approaches_its_volume_from_within(x, y_ratio, z_ratio, slices, stacks):
    y, z = x * y_ratio, x * z_ratio
    share = 1 - 12 / slices**2 - 7 / stacks**2
    check(ellipsoid(np.array([x, y, z]), slices, stacks), math.pi / 6 * x * y * z, share)


@given(LENGTH, LENGTH, st.integers(3, 40))
def test_cylinder_is_the_prism_over_its_polygon(radius, length, slices):
    polygon_m2 = slices / 2 * math.sin(2 * math.pi / slices) * radius**2
    check(cylinder(radius, length, slices), polygon_m2 * length, 1.0)


@given(LENGTH, LENGTH, st.integers(6, 30), st.integers(4, 20))
def test_capsule_approaches_its_volume_from_within(radius, half_length, slices, stacks):
    full = math.pi * radius**2 * (2 * half_length + 4 / 3 * radius)
    check(capsule(radius, half_length, slices, stacks), full, 1 - 12 / slices**2 - 8 / stacks**2)


def test_hull_of_a_roof_has_sharp_edges_and_level_texture():
    surface = hull(PRISM)
    check(surface, 4.0, 1.0)
    slope = surface.normals[:, 2] > 0.5
    assert slope.sum() == 8
    levels = surface.vertices_m[slope, 2]
    assert np.ptp(surface.texture_m[slope & (surface.vertices_m[:, 2] == 0), 1]) == pytest.approx(
        0.0, abs=1e-9
    )
    assert set(levels.tolist()) == {0.0, 1.0}
