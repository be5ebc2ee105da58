from hypothesis import given
from hypothesis import strategies as st

from aeroscene.corpus.shipped.attributes import (
    read_attributes,
    write_attributes,
)
from aeroscene.corpus.shipped.columns import ColumnReader, ColumnWriter
from tests.aeroscene.corpus.shipped.scenes import attributes


def there_and_back(rows):
    writer = ColumnWriter()
    write_attributes(rows, writer)
    return read_attributes(ColumnReader(writer.to_bytes()))


@given(st.lists(attributes, max_size=8))
def test_attributes_come_back_with_their_types_and_in_their_order(rows):
    found = there_and_back(rows)
    assert [list(map(repr, row.items())) for row in found] == [
        list(map(repr, row.items())) for row in rows
    ]


def test_one_key_may_hold_values_of_several_types():
    rows = [{"a": 1}, {"a": True}, {"a": 1.0}, {"a": "1"}, {"a": 2, "b": "x"}, {"b": "y", "a": 3}]
    found = there_and_back(rows)
    assert list(map(repr, found)) == list(map(repr, rows))
