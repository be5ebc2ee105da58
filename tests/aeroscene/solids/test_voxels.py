from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.scene.box import quat_from_yaw
from aeroscene.solids.shapes import Primitive
from aeroscene.solids.voxels import Grid, voxelise
from tests.aeroscene.sampling_solids import bounds, holds

GRID = Grid((-2.875, -2.875, -2.875), 0.25, (24, 24, 24))
WEDGE = (
    (-1.0, -0.5, -0.4),
    (1.0, -0.5, -0.4),
    (-1.0, 0.5, -0.4),
    (1.0, 0.5, -0.4),
    (0.0, 0.0, 0.4),
)


@st.composite
def primitives(draw, kinds=("box", "cylinder", "ellipsoid", "mesh")) -> Primitive:
    kind = draw(st.sampled_from(kinds))
    sizes = st.floats(0.05, 2.5)
    size = (draw(sizes), draw(sizes), draw(sizes))
    if kind == "cylinder":
        size = (size[0], size[0], size[2])
    if draw(st.booleans()):
        quat = quat_from_yaw(draw(st.sampled_from([0.0, math.pi / 2, 0.4, -2.0])))
    else:
        raw = np.array([draw(st.floats(-1, 1)) for _ in range(4)])
        raw[0] += 0.001
        w, x, y, z = (raw / np.linalg.norm(raw)).tolist()
        quat = (w, x, y, z)
    places = st.floats(-1.2, 1.2)
    return Primitive(
        kind=kind,
        position_enu_m=(draw(places), draw(places), draw(places)),
        quat_wxyz=quat,
        size_m=(2.0, 1.0, 0.8) if kind == "mesh" else size,
        material="wood",
        object_id=0,
        collides=True,
        vertices_m=WEDGE if kind == "mesh" else (),
    )


def cells_of(points: np.ndarray) -> tuple[np.ndarray, ...]:
    index = np.rint((points - GRID.origin_enu_m) / GRID.resolution_m).astype(int)
    return tuple(index.T)


@given(primitives())
def test_no_point_of_a_solid_lies_in_a_free_cell(primitive):
    occupied = voxelise([primitive], GRID)
    low, high = bounds(primitive)
    points = np.random.default_rng(1).uniform(low, high, (3000, 3))
    points = points[holds(primitive, points)]
    assert occupied[cells_of(points)].all()


@given(primitives())
def test_an_occupied_cell_is_never_far_from_the_solid(primitive):
    occupied = np.argwhere(voxelise([primitive], GRID))
    centres = occupied * GRID.resolution_m + GRID.origin_enu_m
    assert len(occupied)
    # Half a cell's diagonal and what the enlarged faces add at sharp corners.
    assert holds(primitive, centres, grow_m=0.45).all()


@given(primitives(kinds=("box",)))
def test_bounds_hold_the_box_tightly(primitive):
    low, high = bounds(primitive)
    points = np.random.default_rng(2).uniform(low - 0.2, high + 0.2, (4000, 3))
    inside = points[holds(primitive, points)]
    assert np.all(inside >= low - 1e-9)
    assert np.all(inside <= high + 1e-9)


def test_faces_on_cell_borders_occupy_one_side_only():
    slab = Primitive(
        kind="box",
        position_enu_m=(0.0, 0.0, 0.25),
        quat_wxyz=(1.0, 0.0, 0.0, 0.0),
        size_m=(1.0, 0.5, 0.5),
        material="wood",
        object_id=0,
        collides=True,
    )
    assert voxelise([slab], GRID).sum() == 4 * 2 * 2


@pytest.mark.parametrize("collides", [True, False])
def test_only_what_collides_leaves_a_trace(collides):
    far = Primitive(
        kind="cylinder",
        position_enu_m=(0.0, 0.0, 0.0),
        quat_wxyz=(1.0, 0.0, 0.0, 0.0),
        size_m=(1.0, 1.0, 1.0),
        material="wood",
        object_id=0,
        collides=collides,
    )
    assert voxelise([far], GRID).any() == collides


def test_a_solid_outside_the_grid_is_left_out():
    far = Primitive(
        kind="box",
        position_enu_m=(50.0, 0.0, 0.0),
        quat_wxyz=(1.0, 0.0, 0.0, 0.0),
        size_m=(1.0, 1.0, 1.0),
        material="wood",
        object_id=0,
        collides=True,
    )
    assert not voxelise([far], GRID).any()
