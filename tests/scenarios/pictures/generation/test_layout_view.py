import numpy as np
import pytest

from scenarios.pictures.generation.layout_view import PAPER_RGB, Layout, draw_layout

WIDTH, HALF_M = 100, 50.0


def picture(center, size=(10.0, 10.0, 1.0), yaw=0.0, *, is_coarse=False):
    layout = Layout(
        center_enu_m=np.array([center], dtype=float),
        heading=np.array([[np.cos(yaw), np.sin(yaw)]]),
        size_m=np.array([size]),
        is_coarse=np.array([is_coarse]),
    )
    return draw_layout(layout, WIDTH, HALF_M).astype(int)


def drawn(image):
    """Rows and columns that are not paper."""
    return np.argwhere(np.abs(image - PAPER_RGB).sum(axis=2) > 12)


def test_north_is_up_and_east_is_right():
    rows, columns = drawn(picture((30.0, 20.0, 0.0))).T
    assert rows.mean() == pytest.approx(29.5, abs=1)
    assert columns.mean() == pytest.approx(79.5, abs=1)


def test_box_has_its_size_and_heading():
    long = (40.0, 4.0, 1.0)
    for yaw, wide, high in ((0.0, 40, 4), (np.pi / 2, 4, 40), (np.pi / 4, 31, 31)):
        rows, columns = drawn(picture((0.0, 0.0, 0.0), long, yaw)).T
        assert np.ptp(columns) == pytest.approx(wide, abs=3)
        assert np.ptp(rows) == pytest.approx(high, abs=3)
    # Counter-clockwise: the east end of a box turned by 45 degrees lies in the north.
    rows, columns = drawn(picture((0.0, 0.0, 0.0), long, np.pi / 4)).T
    assert np.corrcoef(rows, columns)[0, 1] < -0.8


def test_coarse_and_fine_differ_in_colour():
    coarse = picture((0.0, 0.0, 0.0), is_coarse=True)[50, 50]
    fine = picture((0.0, 0.0, 0.0))[50, 50]
    assert coarse[2] > coarse[0]
    assert fine[0] > fine[2]


def test_fine_objects_are_seen_on_coarse_ones_whatever_their_height():
    layout = Layout(
        center_enu_m=np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 9.0]]),
        heading=np.array([[1.0, 0.0], [1.0, 0.0]]),
        size_m=np.array([[10.0, 10.0, 1.0], [60.0, 60.0, 9.0]]),
        is_coarse=np.array([False, True]),
    )
    middle = draw_layout(layout, WIDTH, HALF_M)[50, 50].astype(int)
    assert middle[0] > middle[2]


@pytest.mark.parametrize("center", [(1e3, 0, 0), (1e9, -1e9, 0), (49.0, 49.0, 0.0)])
def test_noise_far_outside_does_no_harm(center):
    assert picture(center).shape == (WIDTH, WIDTH, 3)


def test_empty_layout_is_paper():
    empty = Layout(np.zeros((0, 3)), np.zeros((0, 2)), np.zeros((0, 3)), np.zeros(0, bool))
    assert (draw_layout(empty, WIDTH, HALF_M) == PAPER_RGB).all()
