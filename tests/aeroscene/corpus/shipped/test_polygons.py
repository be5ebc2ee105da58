import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aeroscene.corpus.shipped.columns import ColumnReader, ColumnWriter
from aeroscene.corpus.shipped.polygons import read_vertices, write_vertices
from tests.aeroscene.corpus.shipped.scenes import regular


class Told(ColumnWriter):
    """Remembers what it is given."""

    def __init__(self):
        super().__init__()
        self.columns = []

    def add(self, numbers):
        self.columns.append(numbers)
        super().add(numbers)


@given(st.data(), st.integers(3, 13), st.integers(0, 6))
def test_any_border_comes_back(data, sides, count):
    integers = st.integers(-(2**62), 2**62)
    vertices = data.draw(arrays(np.int64, (count, sides, 3), elements=integers))
    radii = data.draw(arrays(np.int64, count, elements=integers))
    writer = ColumnWriter()
    write_vertices(vertices, radii, writer)
    assert (read_vertices(sides, radii, ColumnReader(writer.to_bytes())) == vertices).all()


@given(st.floats(0.2, 3.2))
def test_a_regular_twelve_gon_is_its_radius_and_units_of_rounding(radius):
    corners = np.array(regular(12, radius, math.pi / 12)) * 1e4
    vertices = np.zeros((1, 12, 3), np.int64)
    vertices[0, :, :2] = np.rint(corners)
    told = Told()
    write_vertices(vertices, np.rint(corners[:1, 0]).astype(np.int64), told)
    assert max(abs(int(column[0])) for column in told.columns) <= 2


def test_a_rectangle_is_one_corner():
    vertices = np.array([[[-500, -300, 0], [500, -300, 0], [500, 300, 0], [-500, 300, 0]]])
    told = Told()
    write_vertices(vertices, np.array([300]), told)
    assert sum(bool(column.any()) for column in told.columns) == 2
