import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.corpus.shipped.columns import ColumnReader, ColumnWriter

integers = st.integers(-(2**63), 2**63 - 1)


@given(st.lists(st.lists(integers, max_size=12), max_size=4))
def test_columns_come_back_in_their_order(columns):
    writer = ColumnWriter()
    for column in columns:
        writer.add(np.array(column, np.int64))
    reader = ColumnReader(writer.to_bytes())
    assert [reader.take().tolist() for _ in columns] == columns


@given(st.lists(st.integers(-1000, 1000), min_size=1), st.integers(1, 2**40))
def test_multiples_come_back(quotients, divisor):
    column = np.array(quotients, np.int64) * divisor
    writer = ColumnWriter()
    writer.add(column)
    assert ColumnReader(writer.to_bytes()).take().tolist() == column.tolist()


@given(st.lists(st.text()), st.dictionaries(st.text(), st.integers(0, 9)))
def test_plain_things_stand_between_columns(texts, numbers):
    writer = ColumnWriter()
    writer.add_plain(texts)
    writer.add(np.arange(3))
    writer.add_plain(numbers)
    reader = ColumnReader(writer.to_bytes())
    assert reader.take_plain(list[str]) == texts
    assert reader.take().tolist() == [0, 1, 2]
    assert reader.take_plain(dict[str, int]) == numbers


@pytest.mark.parametrize(("bound", "n_bytes"), [(1, 0), (100, 1), (30_000, 2), (2**40, 6)])
def test_small_numbers_take_few_bytes(bound, n_bytes):
    numbers = np.random.default_rng(0).integers(-bound + 1, bound, 4000)
    writer = ColumnWriter()
    writer.add(numbers)
    entropy_bytes = 4000 * np.log2(2 * bound - 1) / 8
    assert len(writer.to_bytes()) <= 1.1 * entropy_bytes + 100
    assert len(writer.to_bytes()) <= 4000 * n_bytes + 100
