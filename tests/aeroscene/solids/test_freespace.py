from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from aeroscene.solids.freespace import (
    NoFreeSpaceError,
    VoxelField,
    build_distance_field,
    distance_to_occupied,
    reachable,
)
from aeroscene.solids.shapes import scene_primitives
from tests.aeroscene.sampling_solids import any_holds


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.02), st.sampled_from([0.25, 0.2, 0.5]))
def test_distance_is_exactly_that_to_the_nearest_occupied_cell(seed, share, resolution_m):
    occupied = np.random.default_rng(seed).random((14, 11, 17)) < share
    found = distance_to_occupied(occupied, resolution_m, cap_m=2.0)
    cells = np.argwhere(occupied)
    centres = np.argwhere(np.ones_like(occupied))
    if len(cells):
        gaps = np.maximum(np.abs(centres[:, None] - cells[None]) - 0.5, 0.0)
        nearest = resolution_m * np.sqrt((gaps**2).sum(axis=-1)).min(axis=1)
        nearest[occupied.ravel()] = 0.0
    else:
        nearest = np.full(len(centres), np.inf)
    assert np.allclose(found.ravel(), np.minimum(nearest, 2.0), atol=1e-5)


def test_field_covers_the_flight_volume_and_treats_the_ground_as_solid(scene_42):
    field = build_distance_field(scene_42)
    low, high = np.asarray(scene_42.extent_min_enu_m), np.asarray(scene_42.extent_max_enu_m)
    first = np.asarray(field.centre((0, 0, 0)))
    last = np.asarray(field.centre(tuple(np.array(field.distance_m.shape) - 1)))
    assert np.allclose(first - (0.125, 0.125, -0.125), low)
    assert np.all(last + 0.125 >= high - 1e-6)
    assert np.all(field.distance_m[:, :, 0] == 0.0)
    assert field.distance_m.dtype == np.float32


def test_distance_never_exceeds_the_true_clearance(scene_42):
    field = build_distance_field(scene_42)
    primitives = scene_primitives(scene_42)
    rng = np.random.default_rng(5)
    cells = rng.integers(0, np.minimum(field.distance_m.shape, (10_000, 10_000, 28)), (400, 3))
    for cell in cells:
        distance_m = field.distance_m[tuple(cell)]
        if distance_m == 0.0:
            continue
        ball = rng.normal(size=(6, 3))
        ball *= 0.999 * distance_m / np.linalg.norm(ball, axis=1, keepdims=True)
        near = [
            p
            for p in primitives
            if np.linalg.norm(np.subtract(p.position_enu_m, field.centre(tuple(cell))))
            < distance_m + 0.5 * np.linalg.norm(p.size_m)
        ]
        assert not any_holds(near, np.asarray(field.centre(tuple(cell))) + ball).any()


def wall_with_hole(hole_cells: int) -> VoxelField:
    occupied = np.zeros((41, 21, 21), dtype=bool)
    occupied[20] = True
    start = 10 - hole_cells // 2
    occupied[20, start : start + hole_cells, start : start + hole_cells] = False
    occupied[:, :, 0] = True
    return VoxelField(
        origin_enu_m=(0.0, 0.0, 0.0),
        resolution_m=0.25,
        distance_m=distance_to_occupied(occupied, 0.25),
    )


@pytest.mark.parametrize(("radius_m", "passes"), [(0.3, True), (0.6, True), (0.7, False)])
def test_a_ball_floods_through_a_hole_that_it_fits(radius_m, passes):
    flood = reachable(wall_with_hole(5), (2.0, 2.5, 2.5), radius_m)
    assert flood[8, 10, 10]
    assert flood[32, 10, 10] == passes
    assert not flood[20, 2, 2]


def test_the_flood_starts_above_the_surface_on_which_the_vehicle_stands(scene_42):
    field = build_distance_field(scene_42)
    flood = reachable(field, scene_42.start_position_enu_m, 0.45)
    i, j, k = field.cell(scene_42.start_position_enu_m)
    assert not flood[i, j, k]
    assert flood[i, j, k + 6]


def test_a_start_without_space_is_named():
    field = wall_with_hole(5)
    with pytest.raises(NoFreeSpaceError, match=r"start \(5.0, 0.5, 0.5\) has no free ball"):
        reachable(field, (5.0, 0.5, 0.5), 0.5)


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.floats(0.1, 0.7), st.booleans())
def test_a_flood_is_the_connected_component_of_its_start(seed, share, is_open_above):
    free = np.random.default_rng(seed).random((9, 8, 12)) > share
    free[4, 4, 5:7] = True
    free[:, :, -1] |= is_open_above
    field = VoxelField(
        origin_enu_m=(0.0, 0.0, 0.0), resolution_m=1.0, distance_m=free.astype(np.float32)
    )
    labels, _ = ndimage.label(free)
    found = reachable(field, (4.0, 4.0, 5.0), 0.5)
    assert np.array_equal(found, labels == labels[4, 4, 5])
    assert reachable(field, (4.0, 4.0, 5.0), 0.5) is found
    for i, j, k in np.argwhere(free)[::20].tolist():
        again = reachable(field, (i, j, k), 0.5)
        assert np.array_equal(again, labels == labels[i, j, k])
        assert (again is found) == bool(found[i, j, k])


def test_a_lower_cap_changes_no_distance_below_it(scene_42):
    wide, narrow = build_distance_field(scene_42), build_distance_field(scene_42, cap_m=1.1)
    assert np.array_equal(np.minimum(wide.distance_m, np.float32(1.1)), narrow.distance_m)
