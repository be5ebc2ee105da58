"""The distance field: its cells, and what lies outside them."""

import numpy as np
import pytest

from autonomy.planning import DistanceField


def ramp():
    x, y, z = np.meshgrid(np.arange(6), np.arange(5), np.arange(4), indexing="ij")
    return DistanceField(
        origin_enu_m=(-1.0, 2.0, 0.5), resolution_m=0.5, distance_m=(x + 2.0 * y + 3.0 * z) * 0.5
    )


def test_cells_and_centres_are_inverse():
    field = ramp()
    cells = np.array([[0, 0, 0], [5, 4, 3], [2, 1, 0]])
    np.testing.assert_array_equal(field.cells(field.centres(cells)), cells)


def test_points_outside_the_grid_are_in_no_cell():
    field = ramp()
    outside = np.array([[-1.3, 2.0, 0.5], [1.8, 4.0, 2.0], [0.0, 3.0, 9.0]])
    assert not field.contains(outside).any()


def test_a_field_without_cells_or_size_is_refused():
    with pytest.raises(ValueError, match="resolution_m 0"):
        DistanceField(origin_enu_m=(0, 0, 0), resolution_m=0, distance_m=np.ones((2, 2, 2)))
    with pytest.raises(ValueError, match="three axes"):
        DistanceField(origin_enu_m=(0, 0, 0), resolution_m=1, distance_m=np.ones((2, 2)))
