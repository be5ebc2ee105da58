"""Help texts of options, taken from the docstrings of their fields.

A docstring below a field is read by people in the source and by users in `--help`, so each option
is explained once. tyro can read these docstrings too, but keeps their line breaks; see `flow_help`.
"""

from __future__ import annotations

import ast
import dataclasses
import inspect
import textwrap
from itertools import pairwise
from types import MappingProxyType
from typing import Any, get_args, get_type_hints

from aeroscene.ranges import ranges_of


def flow_help(options: Any) -> None:
    """Give all fields of options a help text whose lines break where the terminal ends.

    tyro decides on line breaks before it removes the indentation of a field's docstring, and so it
    keeps every line break of the source. It prefers a help text in the field's metadata, which this
    function sets. The text of a number ends with its range.

    Args:
        options: A dataclass, or a union of them; fields that are dataclasses are included.
    """
    if not (isinstance(options, type) and dataclasses.is_dataclass(options)):
        # A union of commands, or `Annotated` around a type; a plain type has no parts.
        for part in get_args(options):
            flow_help(part)
        return
    docstrings: dict[str, str] = {}
    # Bases first, so that a subclass's docstring of an inherited field wins.
    for base in reversed(options.__mro__):
        if dataclasses.is_dataclass(base):
            docstrings |= _field_docstrings(base)
    ranges = ranges_of(options)
    for field in dataclasses.fields(options):
        if text := docstrings.get(field.name):
            valid = f" Valid: {ranges[field.name]}." if field.name in ranges else ""
            said = f"{' '.join(text.split())}{valid}"
            field.metadata = MappingProxyType({**field.metadata, "help": said})
    for part in get_type_hints(options, include_extras=True).values():
        flow_help(part)


def _field_docstrings(options: type) -> dict[str, str]:
    """Return the docstrings below the fields of a class, by the names of the fields."""
    # Python keeps no docstrings of fields at run time, so they are read from the source.
    (tree,) = ast.parse(textwrap.dedent(inspect.getsource(options))).body
    assert isinstance(tree, ast.ClassDef)
    docstrings: dict[str, str] = {}
    for field, below in pairwise(tree.body):
        match field, below:
            case (
                ast.AnnAssign(target=ast.Name(id=name)),
                ast.Expr(value=ast.Constant(value=str(text))),
            ):
                docstrings[name] = text
            case _:
                pass
    return docstrings
