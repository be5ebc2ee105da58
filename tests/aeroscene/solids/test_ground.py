"""The ground of a relief in cells and in patches, neither of which loses any of it."""

import numpy as np
import pytest

from aeroscene.scene import Relief
from aeroscene.solids.freespace import build_distance_field
from aeroscene.solids.ground import ground_cells, ground_patches
from aeroscene.solids.voxels import Grid
from tests.flightsim.handmade import hills, incline, relief_scene

FINE = hills(spacing_m=0.2, half_m=20.0)


@pytest.mark.parametrize(
    "relief", [hills(), incline(0.7, -0.4), FINE], ids=["hills", "slope", "fine"]
)
def test_no_ground_lies_in_a_free_cell_and_little_air_in_an_occupied_one(relief):
    grid = Grid((-18.0, -18.0, -30.0), 0.5, (72, 72, 130))
    occupied, rng = ground_cells(relief, grid), np.random.default_rng(1)
    places = rng.uniform(-18.2, 17.4, (100_000, 2))
    heights = relief.height_m(*places.T)

    def share_occupied(above_m):
        points = np.column_stack([places, heights + above_m])
        cell = np.rint((points - grid.origin_enu_m) / grid.resolution_m).astype(int)
        return occupied[tuple(cell.T)].mean()

    assert share_occupied(-1e-5) == 1.0
    assert share_occupied(-5.0) == 1.0
    most_m = grid.resolution_m * (1.0 + 0.5 * 2 * relief.steepest) + 0.5
    assert share_occupied(most_m) == 0.0


def test_the_distance_field_counts_the_ground_as_occupied():
    scene = relief_scene(hills())
    field = build_distance_field(scene, 0.5)
    relief = scene.relief
    for x, y in ((0.0, 0.0), (-12.0, 9.0), (20.0, -30.0)):
        height_m = float(relief.height_m(x, y))
        cells = [field.cell((x, y, height_m + above_m)) for above_m in (-0.4, 4.0)]
        below_m, above_m = (field.distance_m[cell] for cell in cells)
        assert below_m == 0.0
        assert 1.0 < above_m <= 3.0


@pytest.mark.parametrize("tolerance_m", [0.004, 0.05])
def test_patches_cover_the_ground_once_and_lie_near_it(tolerance_m):
    relief = hills()
    patches = ground_patches(relief, (-40.0, -40.0, 40.0, 40.0), tolerance_m)
    rng, area_m2 = np.random.default_rng(4), 0.0
    for corners, gradient, height_m, above_m in zip(
        patches.corners_enu_m,
        patches.gradient,
        patches.height_at_origin_m,
        patches.above_m,
        strict=True,
    ):
        x, y = corners.T
        area_m2 += 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))
        places = rng.dirichlet(np.ones(len(corners)), 20) @ corners
        off_m = relief.height_m(*places.T) - (height_m + places @ gradient)
        assert np.abs(off_m).max() <= tolerance_m + 1e-9
        assert off_m.max() <= above_m + 1e-9
    assert area_m2 == pytest.approx(80.0**2)


def test_a_plane_is_few_patches_and_a_twisted_cell_is_two_triangles():
    even = ground_patches(Relief((0.0, 0.0), 1.0, np.zeros((33, 33))), (0.0, 0.0, 32.0, 32.0), 0.01)
    assert len(even) == 4
    twisted = np.zeros((17, 17))
    twisted[8, 8] = 1.0
    found = ground_patches(Relief((0.0, 0.0), 1.0, twisted), (0.0, 0.0, 16.0, 16.0), 0.01)
    assert sorted({len(corners) for corners in found.corners_enu_m}) == [3, 4]
