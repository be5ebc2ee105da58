import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from flightsim.looks.shadows import cast, casters
from flightsim.looks.weather.sun import AFTERNOON_SUN

UP = np.array([[0.0, 0.0, 1.0]])
EAST_PER_DROP, NORTH_PER_DROP = (AFTERNOON_SUN[k] / -AFTERNOON_SUN[2] for k in range(2))
LENGTH = st.floats(0.5, 6.0)


def block(middle_m, size_m):
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return np.array(middle_m) + signs * np.array(size_m) / 2


def level_square(half_m, z_m):
    ring = [(-half_m, -half_m), (half_m, -half_m), (half_m, half_m), (-half_m, half_m)]
    return np.array([(x, y, z_m) for x, y in ring])


def shadow_on(square, *solids, sun=AFTERNOON_SUN):
    return cast(casters(list(solids), sun), square, np.zeros(4, dtype=int), UP)


def as_polygons(shadows):
    return shapely.polygons(shadows.corners_enu_m[..., :2])


@given(LENGTH, LENGTH, LENGTH, st.floats(0.0, 3.0))
def test_shadow_of_a_block_is_the_hull_of_its_foot_and_its_shifted_top(x, y, height, ground_m):
    solid = block((0, 0, ground_m + height / 2), (x, y, height))
    found = as_polygons(shadow_on(level_square(40.0, ground_m), solid))
    shift = np.array([EAST_PER_DROP, NORTH_PER_DROP]) * height
    foot = solid[:4:2, :2], solid[4::2, :2]
    points = np.concatenate([*foot, *(part + shift for part in foot)])
    expected = shapely.convex_hull(shapely.multipoints(points))
    united = shapely.union_all(found)
    assert united.symmetric_difference(expected).area < 0.02 * expected.area
    # The triangles cover it once.
    assert shapely.area(found).sum() == pytest.approx(united.area, rel=1e-6)


@given(LENGTH, st.floats(1.0, 3.0))
def test_what_is_below_a_plane_throws_nothing_on_it(size, drop_m):
    solid = block((0, 0, 3.0 - drop_m - size / 2), (size, size, size))
    assert len(shadow_on(level_square(10.0, 3.0), solid).face) == 0


def test_only_the_part_above_the_plane_throws_a_shadow():
    through = block((0, 0, 2.0), (1.0, 1.0, 6.0))
    above = block((0, 0, 4.0), (1.0, 1.0, 2.0))
    square = level_square(20.0, 3.0)
    one, other = (shapely.union_all(as_polygons(shadow_on(square, s))) for s in (through, above))
    assert one.symmetric_difference(other).area < 1e-6


@pytest.mark.parametrize("ground_m", [0.0, 5.0])
def test_face_under_a_roof_is_wholly_in_shadow(ground_m):
    roof = block((0, 0, ground_m + 3.0), (60.0, 60.0, 0.3))
    shadows = shadow_on(level_square(3.0, ground_m), roof)
    assert shadows.is_whole.tolist() == [True]
    assert len(shadows.face) == 0


def test_triangles_lie_just_above_their_face_and_look_outward():
    shadows = shadow_on(level_square(20.0, 0.0), block((0, 0, 1.0), (2.0, 2.0, 2.0)))
    corners = shadows.corners_enu_m
    assert np.abs(corners[..., 2] - 0.004).max() < 1e-9
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (across[:, 2] > 0).all()


def test_wall_takes_the_shadow_of_what_stands_before_it():
    # A wall in the plane x = 0 that looks west, where the sun is.
    ring = np.array([(0, 5, 0), (0, -5, 0), (0, -5, 4), (0, 5, 4)], dtype=float)
    west = np.array([[-1.0, 0.0, 0.0]])
    before, behind = block((-2, 0, 2), (0.5, 2, 4)), block((2, 0, 2), (0.5, 2, 4))
    corner = np.zeros(4, dtype=int)
    assert len(cast(casters([before], AFTERNOON_SUN), ring, corner, west).face) > 0
    assert len(cast(casters([behind], AFTERNOON_SUN), ring, corner, west).face) == 0


def test_under_a_sun_in_the_zenith_a_shadow_is_the_outline():
    solid = block((0, 0, 2.0), (2.0, 1.0, 1.0))
    found = shapely.union_all(as_polygons(shadow_on(level_square(9.0, 0.0), solid, sun=(0, 0, -1))))
    assert found.bounds == pytest.approx((-1.0, -0.5, 1.0, 0.5))
