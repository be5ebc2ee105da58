"""Checks of single fields of a layout: each error names field, value and valid values."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from aeroscene.files.bounds import MOST_POINTS
from aeroscene.layouts.document import LayoutError, Point2
from aeroscene.scene import Quaternion, Vector3, errors
from aeroscene.scene.box import MAX_EXTENT_M, MIN_SIZE_M

RENORMALISE = 1e-3
"""Deviation of a quaternion's norm from one up to which it is rounded, not wrong, and is
renormalised.
"""
MAX_POSITION_M = 10_000.0
_SHOWN = 60
"""Most characters of a value in an error."""


def shown(value: object) -> str:
    """Text of a value for an error: on one line and not endless."""
    return errors.shown(value, _SHOWN)


def refuse(field_name: str, value: object, valid: str) -> LayoutError:
    """Make the error for a field.

    Args:
        field_name: Name of the field in the file.
        value: Wrong value.
        valid: Description of valid values.
    """
    return LayoutError(f"{field_name} is {shown(value)}; valid: {valid}")


def mapping(value: object, field_name: str) -> Mapping[str, Any]:
    """Require a JSON object."""
    if not isinstance(value, dict):
        raise refuse(field_name, value, "a JSON object")
    return value


def need(record: Mapping[str, Any], key: str, prefix: str = "") -> Any:
    """Return the value under a key that must exist.

    Raises:
        LayoutError: If it is missing; the message lists the keys that do exist.
    """
    if key not in record:
        keys = ", ".join(map(str, list(record)[:8])) or "nothing"
        raise LayoutError(f"{prefix}{key} is missing; valid: an object with {key} (it has {keys})")
    return record[key]


def text(value: object, field_name: str, *, is_empty_valid: bool = False) -> str:
    """Require a text, by default one that is not empty."""
    if not isinstance(value, str) or not (value or is_empty_valid):
        raise refuse(field_name, value, "a text" if is_empty_valid else "a text that is not empty")
    return value


def items(value: object, field_name: str) -> Sequence[Any]:
    """Require a JSON list."""
    if not isinstance(value, list):
        raise refuse(field_name, value, "a list")
    return value


def numbers(value: object, count: int, field_name: str) -> list[float]:
    """Require a list of so many finite numbers.

    Args:
        value: Value of the field.
        count: Number of numbers.
        field_name: Name of the field in the file.

    Raises:
        LayoutError: If it is no such list; true and false are no numbers here.
    """
    valid = f"{count} finite numbers"
    if not isinstance(value, list) or len(value) != count:
        raise refuse(field_name, value, valid)
    # true and false are integers in Python.
    if not all(isinstance(v, int | float) and not isinstance(v, bool) for v in value):
        raise refuse(field_name, value, valid)
    try:
        floats = [float(v) for v in value]
    except OverflowError:
        raise refuse(field_name, value, valid) from None
    if not all(map(math.isfinite, floats)):
        raise refuse(field_name, value, valid)
    return floats


def position(value: object, field_name: str) -> Vector3:
    """Require a point within `MAX_POSITION_M` of the origin."""
    x, y, z = numbers(value, 3, field_name)
    if max(abs(x), abs(y), abs(z)) > MAX_POSITION_M:
        raise refuse(field_name, value, f"three numbers within {MAX_POSITION_M:g} m of the origin")
    return (x, y, z)


def size(value: object, field_name: str) -> Vector3:
    """Require extents of a box that has a volume, m."""
    x, y, z = numbers(value, 3, field_name)
    if min(x, y, z) < MIN_SIZE_M or max(x, y, z) > MAX_EXTENT_M:
        valid = f"three extents from {MIN_SIZE_M} to {MAX_EXTENT_M:g} m"
        raise refuse(field_name, value, valid)
    return (x, y, z)


def quaternion(value: object, field_name: str) -> Quaternion:
    """Require a unit quaternion in the order of the source; rounded ones are renormalised."""
    a, b, c, d = numbers(value, 4, field_name)
    norm = math.hypot(a, b, c, d)
    # A message must fit on a line, however large the value is.
    if abs(norm - 1.0) > RENORMALISE:
        valid = f"a quaternion of norm 1 within {RENORMALISE:g} (this one has {norm:.6g})"
        raise refuse(field_name, value, valid)
    return (a / norm, b / norm, c / norm, d / norm)


def polygon(value: object, field_name: str) -> tuple[Point2, ...]:
    """Require a simple outline of at least three corners, and return it counter-clockwise."""
    from aeroscene.scene.polygon import is_simple, signed_area

    corners: list[Point2] = []
    if len(items(value, field_name)) > MOST_POINTS:
        raise refuse(field_name, value, f"3 to {MOST_POINTS} corners")
    for index, corner in enumerate(items(value, field_name)):
        x, y = numbers(corner, 2, f"{field_name}[{index}]")
        if max(abs(x), abs(y)) > MAX_POSITION_M:
            valid = f"two numbers within {MAX_POSITION_M:g} m of the origin"
            raise refuse(f"{field_name}[{index}]", corner, valid)
        corners.append((x, y))
    if len(corners) < 3:
        raise refuse(field_name, value, "at least 3 corners")
    outline = corners if signed_area(corners) >= 0 else corners[::-1]
    if signed_area(outline) <= 0 or not is_simple(outline):
        raise refuse(field_name, value, "an outline that does not cross itself and holds an area")
    return tuple(outline)
