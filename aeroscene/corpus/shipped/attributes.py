"""Attributes of objects as columns: a palette of key sets, then the values key by key."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from aeroscene.corpus.shipped.columns import ColumnReader, ColumnWriter
from aeroscene.corpus.shipped.decimals import join_doubles, split_doubles
from aeroscene.scene import AttributeValue

_DIGITS = 4

Attributes = dict[str, AttributeValue]
_KeySet = tuple[tuple[str, str], ...]
"""Keys in their order, each with its type."""


def write_attributes(rows: Sequence[Attributes], writer: ColumnWriter) -> None:
    """Append the attributes of objects.

    Args:
        rows: Rows of each object; likeliest smallest where like stands beside like.
        writer: Takes the columns; `scene.SceneObject` bounds numbers to what it can hold.
    """
    key_sets: list[_KeySet] = [
        tuple((name, type(value).__name__) for name, value in row.items()) for row in rows
    ]
    palette = list(dict.fromkeys(key_sets))
    number = {key_set: index for index, key_set in enumerate(palette)}
    writer.add_plain(palette)
    writer.add(np.array([number[key_set] for key_set in key_sets], np.int64))
    for name, kind in _columns(palette):
        values = [
            row[name] for row, keys in zip(rows, key_sets, strict=True) if (name, kind) in keys
        ]
        _WRITE[kind](writer, name, values)


def read_attributes(reader: ColumnReader) -> list[Attributes]:
    """The attributes of objects, in the order in which they were written."""
    palette = reader.take_plain(list[_KeySet])
    key_sets = [palette[number] for number in reader.take().tolist()]
    columns = {key: iter(_READ[key[1]](reader)) for key in _columns(palette)}
    return [{key[0]: next(columns[key]) for key in key_set} for key_set in key_sets]


def _columns(palette: Sequence[_KeySet]) -> list[tuple[str, str]]:
    """Every key with its type, in the order of first appearance."""
    return list(dict.fromkeys(key for key_set in palette for key in key_set))


def _write_words(writer: ColumnWriter, _: str, values: list[Any]) -> None:
    palette = list(dict.fromkeys(values))
    number = {word: index for index, word in enumerate(palette)}
    writer.add_plain(palette)
    writer.add(np.array([number[word] for word in values], np.int64))


def _read_words(reader: ColumnReader) -> list[str]:
    palette = reader.take_plain(list[str])
    return [palette[number] for number in reader.take().tolist()]


def _write_floats(writer: ColumnWriter, _: str, values: list[Any]) -> None:
    writer.add_decimals(split_doubles(np.array(values, np.float64), _DIGITS))


def _read_floats(reader: ColumnReader) -> list[float]:
    return join_doubles(reader.take_decimals(), _DIGITS).tolist()


def _write_integers(writer: ColumnWriter, _: str, values: list[Any]) -> None:
    writer.add(np.array(values, np.int64))


def _read_integers(reader: ColumnReader) -> list[int]:
    return reader.take().tolist()


def _read_booleans(reader: ColumnReader) -> list[bool]:
    return [bool(number) for number in reader.take().tolist()]


_WRITE: dict[str, Callable[[ColumnWriter, str, list[Any]], None]] = {
    "str": _write_words,
    "float": _write_floats,
    "int": _write_integers,
    "bool": _write_integers,
}
_READ: dict[str, Callable[[ColumnReader], list[Any]]] = {
    "str": _read_words,
    "float": _read_floats,
    "int": _read_integers,
    "bool": _read_booleans,
}
