"""Tables of results in Parquet files, which may be anybody's, read within bounds.

A few kilobytes of Parquet can unpack to gigabytes: runs of one value are stored once, and a text
that a million rows share is stored once too. Rows, numbers and characters are therefore counted
before any column is unpacked.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from aeroscene.files import open_regular

_MOST_ROWS = 100_000
"""Most rows of a table; a campaign writes 5,000 into each."""
_MOST_VALUES = 32_000_000
"""Most numbers and texts of a table; one of ours with its tracks has some 5 million."""
_MOST_TEXT_BYTES = 64 << 20
"""Most bytes of text in all rows of a column."""


class TableFileError(ValueError):
    """A file that is no table of results; the message says why."""


def read_table_file(
    path: Path, names: Sequence[str], schema: pa.Schema, where: pc.Expression | None = None
) -> pa.Table:
    """Return some columns of a table.

    Args:
        path: The file.
        names: Columns to read. The first one is the key, which must be there without a gap.
        schema: Types of all columns.
        where: Condition that rows have to meet.

    Returns:
        The columns; null if the file has none of that name, because it is older.

    Raises:
        TableFileError: If it is damaged, too large, or no table of results.
    """
    texts = [field.name for field in schema if field.type == pa.string()]
    try:
        with open_regular(path) as opened:
            facts = pq.read_metadata(opened)
            there = set(facts.schema.to_arrow_schema().names)
            # From the metadata alone, before anything is unpacked.
            _require_bounds(facts, there, names[0])
            shared = [name for name in texts if name in there]
            # Texts as dictionaries: a text that many rows share stays one text until it is counted.
            file = pq.ParquetFile(opened, metadata=facts, read_dictionary=shared, pre_buffer=False)
            # A condition may be of any column but the tracks.
            asked = {*names, *(() if where is None else _plain(schema))}
            read = [name for name in schema.names if name in asked]
            found = file.read([name for name in read if name in there], use_threads=False)
        columns = [
            _unpacked(found[name], schema.field(name))
            if name in there
            else pa.nulls(len(found), schema.field(name).type)
            for name in read
        ]
        table = pa.table(columns, schema=pa.schema([schema.field(name) for name in read]))
    except TableFileError:
        raise
    except (pa.ArrowException, OSError, ValueError, KeyError) as error:
        raise TableFileError(str(error).split("\n", 1)[0]) from None
    if table[names[0]].null_count:
        raise TableFileError(f"it has rows without {names[0]!r}")
    return (table if where is None else table.filter(where)).select(list(names))


def _plain(schema: pa.Schema) -> list[str]:
    """Return the names of the columns with one value a row."""
    return [field.name for field in schema if not pa.types.is_list(field.type)]


def _require_bounds(facts: pq.FileMetaData, there: set[str], key: str) -> None:
    if key not in there:
        raise TableFileError(f"it has no column {key!r}")
    if facts.num_rows > _MOST_ROWS:
        raise TableFileError(f"it has {facts.num_rows} rows, at most {_MOST_ROWS} are valid")
    groups = (facts.row_group(number) for number in range(facts.num_row_groups))
    n_values = sum(
        group.column(number).num_values for group in groups for number in range(group.num_columns)
    )
    if n_values > _MOST_VALUES:
        raise TableFileError(f"it has {n_values} values, at most {_MOST_VALUES} are valid")


def _unpacked(column: pa.ChunkedArray, field: pa.Field) -> pa.ChunkedArray:
    """Return a column in the type of the schema; texts are counted before they are copied out."""
    if pa.types.is_dictionary(column.type):
        n_bytes = 0
        for chunk in column.chunks:
            lengths = pc.call_function("binary_length", [chunk.dictionary]).take(chunk.indices)
            n_bytes += pc.call_function("sum", [lengths.cast(pa.int64())]).as_py() or 0
        if n_bytes > _MOST_TEXT_BYTES:
            most = _MOST_TEXT_BYTES >> 20
            raise TableFileError(f"column {field.name!r} holds more than {most} MiB of text")
    return column.cast(field.type)
