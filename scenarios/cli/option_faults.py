"""Faults of options that no command can work with, found before anything heavy is loaded."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any, get_type_hints

from aeroscene.ranges import out_of_range
from scenarios.cli.outputs import OutFile, OutFolder


def option_faults(options: Any) -> Iterator[str]:
    """Yield a line for each number out of its range, and each output that cannot be written.

    Args:
        options: A dataclass of options; those within its fields are checked too.
    """
    yield from out_of_range(options)
    yield from _unwritable(options)


@cache
def outputs_of(options: type) -> dict[str, OutFile | OutFolder]:
    """Return the fields of a dataclass of options that are marked as outputs, with their marks."""
    hints = get_type_hints(options, include_extras=True)
    return {
        field.name: mark
        for field in fields(options)
        for mark in getattr(hints[field.name], "__metadata__", ())
        if isinstance(mark, OutFile | OutFolder)
    }


def _unwritable(options: Any) -> Iterator[str]:
    marks = outputs_of(type(options))
    for field in fields(options):
        value = getattr(options, field.name)
        if is_dataclass(value) and not isinstance(value, type):
            yield from _unwritable(value)
        elif field.name in marks and isinstance(value, Path):
            fault = marks[field.name].fault(field.name.replace("_", "-"), value)
            if fault is not None:
                yield fault
