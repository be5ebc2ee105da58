"""Checked access to a TOML table: each error names file, field, value and valid values.

Readers ask for one field after another. Fields that nobody asked for are unknown, so that a typing
error in a name is found without a schema.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, NoReturn

from aeroscene.files.visible import is_visible, shown


class Fields:
    """A table whose fields are asked for one by one."""

    def __init__(
        self, plain: dict[str, Any], file: str, path: str = "", *, error: type[ValueError]
    ) -> None:
        """Prepare to read a table.

        Args:
            plain: The table.
            file: Kind and name of the file, for messages.
            path: Place of the table in the file, such as `body`; empty for the whole file.
            error: Type of the errors that are raised.
        """
        self._plain, self._file, self._path, self._error = plain, file, path, error
        self._others: dict[str, Any] = {}
        """Fields that a merged table takes from another one, found at the fallback's place."""
        self._fallback = path
        self._asked: list[str] = []

    def fail(self, field: str, fault: str) -> NoReturn:
        """Refuse a field.

        Args:
            field: Name of the field.
            fault: What is wrong, and what would be valid.

        Raises:
            ValueError: Always, of the type that was given.
        """
        # A field of a merged table is named where it really stands.
        path = self._path if field in self._plain else self._fallback
        where = f"{path}.{field}".strip(".")
        raise self._error(f"{self._file}: {where} {fault}")

    def has(self, field: str) -> bool:
        """Return true if a field is given."""
        self._asked.append(field)
        return field in self._plain or field in self._others

    def check_all_known(self) -> None:
        """Refuse fields that nobody asked for.

        Raises:
            ValueError: If there is one; the message lists the known ones.
        """
        valid = list(dict.fromkeys(self._asked))
        for field in self._plain:
            if field not in valid:
                self.fail(field, f"is unknown; valid: {', '.join(valid)}")

    @property
    def names(self) -> list[str]:
        """Names of all fields, where these are for the author to choose."""
        return list(self._plain)

    @property
    def unknown(self) -> list[str]:
        """Paths of the fields that nobody has asked for, for readers that let them pass."""
        unasked = (field for field in self._plain if field not in self._asked)
        return [f"{self._path}.{field}".strip(".") for field in unasked]

    def text(self, field: str, *, most: int = 80) -> str:
        """Return a line of text of at most `most` characters."""
        value = self._required(field, "a line of text")
        is_line = isinstance(value, str) and value.strip() and is_visible(value)
        if not is_line or len(value) > most:
            self.fail(field, f"is {shown(value)}; valid: 1 to {most} characters of one line")
        return value

    def word(self, field: str, valid: Sequence[str]) -> str:
        """Return one of several words."""
        names = " or ".join(valid)
        value = self._required(field, names)
        if value not in valid:
            self.fail(field, f"is {shown(value)}; valid: {names}")
        return value

    def number(
        self, field: str, low: float, high: float, unit: str = "", default: float | None = None
    ) -> float:
        """Return a number.

        Args:
            field: Name of the field.
            low: Least valid number.
            high: Greatest valid number.
            unit: Unit, for messages.
            default: Number if the field is missing; None requires it.
        """
        valid = f"{low:g} to {high:g} {unit}".rstrip()
        if default is not None and not self.has(field):
            return default
        value = self._required(field, valid)
        if not _is_number(value) or not low <= value <= high:
            self.fail(field, f"is {shown(value)}; valid: {valid}")
        return float(value)

    def count(self, field: str, low: int, high: int) -> int:
        """Return a whole number within bounds, both of them valid."""
        value = self._required(field, f"{low} to {high}")
        # In Python true is an int as well.
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            self.fail(field, f"is {shown(value)}; valid: a whole number from {low} to {high}")
        return value

    def flag(self, field: str, *, default: bool) -> bool:
        """Return true or false."""
        value = self._required(field, "") if self.has(field) else default
        if not isinstance(value, bool):
            self.fail(field, f"is {shown(value)}; valid: true or false")
        return value

    def vector(
        self,
        field: str,
        n: int,
        low: float,
        high: float,
        unit: str = "",
        default: tuple[float, ...] | None = None,
    ) -> tuple[float, ...]:
        """Return n numbers within bounds, both of them valid.

        Args:
            field: Name of the field.
            n: Number of numbers.
            low: Least valid number.
            high: Greatest valid number.
            unit: Unit, for messages.
            default: Numbers if the field is missing; None requires it.
        """
        valid = f"{n} numbers from {low:g} to {high:g} {unit}".rstrip()
        if default is not None and not self.has(field):
            return default
        value = self._required(field, valid)
        is_row = isinstance(value, list) and len(value) == n and all(map(_is_number, value))
        if not is_row or not all(low <= each <= high for each in value):
            self.fail(field, f"is {shown(value)}; valid: {valid}")
        return tuple(map(float, value))

    def rows(
        self, field: str, n: int, count: tuple[int, int], low: float, high: float, unit: str = ""
    ) -> list[tuple[float, ...]]:
        """Return rows of n numbers within bounds.

        Args:
            field: Name of the field.
            n: Numbers in each row.
            count: Least and greatest number of rows.
            low: Least valid number.
            high: Greatest valid number.
            unit: Unit, for messages.
        """
        least, most = count
        valid = f"{least} to {most} rows of {n} numbers from {low:g} to {high:g} {unit}".rstrip()
        value = self._required(field, valid)
        if not isinstance(value, list) or not least <= len(value) <= most:
            self.fail(field, f"is {shown(value)}; valid: {valid}")
        for row in value:
            is_row = isinstance(row, list) and len(row) == n and all(map(_is_number, row))
            if not is_row or not all(low <= each <= high for each in row):
                self.fail(field, f"has the row {shown(row)}; valid: {valid}")
        return [tuple(map(float, row)) for row in value]

    def table(self, field: str) -> Fields:
        """Return a table within; an empty one if it is not given."""
        value = self._plain.get(field, {})
        self._asked.append(field)
        if not isinstance(value, dict):
            self.fail(field, f"is {shown(value)}; valid: a table, [{field}]")
        return self._within(value, f"{self._path}.{field}".strip("."))

    def tables(self, field: str) -> Iterator[Fields]:
        """Return the tables of a list, which count from 1 in messages."""
        value = self._required(field, f"tables, each below [[{field}]]")
        if not isinstance(value, list) or not all(isinstance(each, dict) for each in value):
            self.fail(field, f"is {shown(value)}; valid: tables, each below [[{field}]]")
        for number, plain in enumerate(value, start=1):
            yield self._within(plain, f"{field}[{number}]")

    def merged_under(self, other: Fields) -> Fields:
        """Return the same table, with missing fields taken from another one."""
        merged = self._within(self._plain, self._path)
        merged._others, merged._fallback = other._plain, other._path
        return merged

    def know_as(self, merged: Fields) -> None:
        """Count the fields that were asked of a merged table as asked of this one."""
        self._asked += merged._asked

    def _within(self, plain: dict[str, Any], path: str) -> Fields:
        return Fields(plain, self._file, path, error=self._error)

    def _required(self, field: str, valid: str) -> Any:
        if not self.has(field):
            self.fail(field, f"is missing; valid: {valid}")
        return self._plain.get(field, self._others.get(field))


def _is_number(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return not isinstance(value, float) or math.isfinite(value)
