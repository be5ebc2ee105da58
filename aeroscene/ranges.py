"""Ranges of numbers, declared once with the option: `count: Annotated[int, Range(1, 100)]`.

The check, the message that refuses a number, and the help of the command line all follow from the
declaration, so that they cannot disagree.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from typing import Any, get_type_hints


@dataclass(frozen=True, slots=True)
class Range:
    """Finite numbers from `low` to `high`, both included unless `is_above`."""

    low: float
    high: float = math.inf
    unit: str = ""
    is_above: bool = False
    """True if `low` itself is out of the range."""
    word: str = ""
    """Word that the option accepts instead of a number."""

    def __str__(self) -> str:
        return f"{self._numbers()}, or {self.word}" if self.word else self._numbers()

    def _numbers(self) -> str:
        low = _figure(self.low)
        unit = f" {self.unit}" if self.unit else ""
        if self.high == math.inf:
            return f"above {low}{unit}" if self.is_above else f"{low}{unit} or more"
        if self.is_above:
            return f"above {low}, at most {_figure(self.high)}{unit}"
        return f"{low} to {_figure(self.high)}{unit}"

    def __contains__(self, value: float) -> bool:
        is_high_enough = self.low < value if self.is_above else self.low <= value
        return is_high_enough and value <= self.high and value != math.inf

    def fault(self, name: str, value: float) -> str | None:
        """Message that refuses a number under an option's name; None for a number in the range."""
        if value in self:
            return None
        return f"{name} {value} is out of range; valid: {self}"

    def require(self, name: str, value: float, error: Callable[[str], Exception]) -> None:
        """Raise the exception that `error` makes from a `fault`, unless the number is valid."""
        if fault := self.fault(name, value):
            raise error(fault)


SEEDS = Range(0, 2**63 - 1)
"""Seeds; recordings and tables keep them as signed 64-bit integers."""
MOST_THREADS = 1024
THREADS = Range(1, MOST_THREADS)
"""Threads of one process."""


@cache
def ranges_of(options: type) -> dict[str, Range]:
    """Ranges of the fields of a dataclass, by the names of the fields."""
    hints = get_type_hints(options, include_extras=True)
    return {
        field.name: mark
        for field in fields(options)
        for mark in getattr(hints[field.name], "__metadata__", ())
        if isinstance(mark, Range)
    }


def out_of_range(options: Any, section: str | None = None) -> Iterator[str]:
    """Yield a message for each number out of its range, in a dataclass and in those within it.

    Values that are no numbers, such as None or `max`, pass. The arguments are those of
    `require_ranges`.
    """
    ranges = ranges_of(type(options))
    for field in fields(options):
        value = getattr(options, field.name)
        if is_dataclass(value) and not isinstance(value, type):
            yield from out_of_range(value, section)
        elif field.name in ranges and isinstance(value, (int, float)):
            is_option = section is None
            name = field.name.replace("_", "-") if is_option else f"{section}{field.name}"
            fault = ranges[field.name].fault(name, value)
            if fault is not None:
                yield fault


def require_ranges(
    options: Any, error: Callable[[str], Exception], section: str | None = None
) -> None:
    """Refuse a dataclass with a number out of its range.

    Args:
        options: The dataclass.
        error: Makes the exception from a message.
        section: Prefix of the fields' names in a configuration file, such as `sampler.`; None if
            they are options of the command line, which have dashes.

    Raises:
        Exception: The exception that `error` makes for the first such number.
    """
    for fault in out_of_range(options, section):
        raise error(fault)


def _figure(value: float) -> str:
    return str(int(value)) if float(value).is_integer() else f"{value:g}"
