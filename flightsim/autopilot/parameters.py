"""Parameters of the autopilot: PX4's names, typed and bounded, in a stable order.

Values are those of the wire: 32-bit integers and 32-bit floats. Rounding them at once means that a
client reads back exactly the number that acts. The error for a refused value names the valid ones.
The table is `parameters.csv`.
"""

from __future__ import annotations

import csv
import math
import struct
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from importlib.resources import files
from typing import Literal

ParameterListener = Callable[["ParameterSpec", float], None]

_INT32_MIN, _INT32_MAX = -(2**31), 2**31 - 1
_FLOAT32_MAX = 3.4028234663852886e38


class ParameterError(ValueError):
    """A parameter was requested or set wrongly."""


class UnknownParameterError(ParameterError, KeyError):
    """No parameter has this name or index."""

    def __str__(self) -> str:
        # KeyError would show the text in quotes.
        return str(self.args[0])


class ParameterValueError(ParameterError):
    """The value is not a number, out of range or not whole."""


class ReadOnlyParameterError(ParameterError):
    """The parameter describes simulated hardware."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ParameterSpec:
    """Fixed properties of a parameter.

    Attributes:
        minimum, maximum: Valid range, both ends included.
        unit: Unit for people; empty if it has none.
        is_read_only: True if it describes simulated hardware.
    """

    name: str
    type: Literal["int", "float"]
    default: float
    minimum: float
    maximum: float
    unit: str
    is_read_only: bool
    description: str


def _float32(value: float) -> float:
    return struct.unpack("<f", struct.pack("<f", value))[0]


def _spec_from_row(row: dict[str, str]) -> ParameterSpec:
    is_float = row["type"] == "float"
    lowest, highest = (-_FLOAT32_MAX, _FLOAT32_MAX) if is_float else (_INT32_MIN, _INT32_MAX)
    number = (lambda text: _float32(float(text))) if is_float else int
    return ParameterSpec(
        name=row["name"],
        type="float" if is_float else "int",
        default=number(row["default"]),
        minimum=number(row["min"]) if row["min"] else lowest,
        maximum=number(row["max"]) if row["max"] else highest,
        unit=row["unit"],
        is_read_only=row["read_only"] == "1",
        description=row["description"],
    )


def _read_table() -> tuple[ParameterSpec, ...]:
    text = files("flightsim.autopilot").joinpath("parameters.csv").read_text(encoding="utf-8")
    return tuple(_spec_from_row(row) for row in csv.DictReader(text.splitlines()))


PARAMETER_SPECS = _read_table()
"""All parameters, sorted by name; the position is the parameter's index."""


class Parameters:
    """Current values, read like a dictionary: `parameters["MIS_TAKEOFF_ALT"]`."""

    def __init__(
        self, ranges: Mapping[str, tuple[float, float]] | None = None, **airframe_values: float
    ) -> None:
        """Start with the defaults, except for values of the airframe.

        Args:
            ranges: Least and greatest values that another flight stack allows, by name; they widen
                the ranges of the table.
            airframe_values: Values that replace defaults; read-only parameters may be among them.

        Raises:
            ParameterError: If one of them is unknown or out of range.
        """
        self._specs = {spec.name: spec for spec in PARAMETER_SPECS}
        for name, valid in (ranges or {}).items():
            self._specs[name] = _widened(self.spec(name), *valid)
        self._names = tuple(self._specs)
        self._index = {name: index for index, name in enumerate(self._names)}
        self._values = {name: spec.default for name, spec in self._specs.items()}
        self._listeners: list[ParameterListener] = []
        for name, value in airframe_values.items():
            self._values[name] = _validated(self.spec(name), value)
        # Resetting leads here, not to the table: a vehicle keeps the values of its airframe.
        self._initial = dict(self._values)

    def __getitem__(self, name: str) -> float:
        """Return the value of a parameter; an `int` for integer parameters."""
        return self._values[name]

    def __len__(self) -> int:
        return len(self._names)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __contains__(self, name: object) -> bool:
        return name in self._index

    def index(self, name: str) -> int:
        """Return the index of a parameter, from 0.

        Raises:
            UnknownParameterError: If there is none of this name.
        """
        self.spec(name)
        return self._index[name]

    def name_at(self, index: int) -> str:
        """Return the name of the parameter with this index.

        Raises:
            UnknownParameterError: If there is none.
        """
        if not 0 <= index < len(self._names):
            raise UnknownParameterError(
                f"parameter index {index} does not exist; valid are 0 to {len(self._names) - 1}"
            )
        return self._names[index]

    def spec(self, name: str) -> ParameterSpec:
        """Return the fixed properties of a parameter.

        Raises:
            UnknownParameterError: If there is none of this name.
        """
        spec = self._specs.get(name)
        if spec is None:
            raise UnknownParameterError(f"parameter {name[:32]!r} does not exist")
        return spec

    def is_integer(self, name: str) -> bool:
        """Return true if the parameter is a whole number.

        Raises:
            UnknownParameterError: If there is none of this name.
        """
        return self.spec(name).type == "int"

    def set(self, name: str, value: float) -> float:
        """Change a parameter and return the value as stored (rounded to 32 bits).

        Raises:
            UnknownParameterError: If there is none of this name.
            ParameterValueError: If the value is NaN, out of range or not whole.
            ReadOnlyParameterError: If it is read-only and the value would change it.
        """
        spec = self.spec(name)
        stored = _validated(spec, value)
        # Setting a read-only parameter to its own value succeeds: clients restore whole files.
        if stored == self._values[name]:
            return stored
        if spec.is_read_only:
            raise ReadOnlyParameterError(
                f"{name} is read-only and stays {self._values[name]:g}: {spec.description}"
            )
        self._values[name] = stored
        for listener in self._listeners:
            listener(spec, stored)
        return stored

    def reset(self, *names: str) -> None:
        """Restore the initial values of the named parameters, or of all.

        Args:
            names: Names of the parameters; none means all.

        Raises:
            UnknownParameterError: If one of the names does not exist; the names before it are
                restored.
        """
        for name in names or self._names:
            self.spec(name)
            if self._values[name] != self._initial[name]:
                self.set(name, self._initial[name])

    def add_listener(self, listener: ParameterListener) -> None:
        """Call `listener(spec, value)` after each change of a value, in the order of adding."""
        self._listeners.append(listener)


def _widened(spec: ParameterSpec, least: float, most: float) -> ParameterSpec:
    return replace(spec, minimum=min(spec.minimum, least), maximum=max(spec.maximum, most))


def _validated(spec: ParameterSpec, value: float) -> float:
    if not math.isfinite(value):
        raise ParameterValueError(f"{spec.name} = {value} is not a number; {_valid_range(spec)}")
    # A limit of 0.1 in 32 bits may lie just beyond the 0.1 in 64 bits that a client sends.
    if not spec.minimum <= value <= spec.maximum and not (
        spec.type == "float" and spec.minimum <= _clamped_float32(value) <= spec.maximum
    ):
        raise ParameterValueError(f"{spec.name} = {value:g} is out of range; {_valid_range(spec)}")
    if spec.type == "float":
        return _float32(value)
    if value != int(value):
        raise ParameterValueError(f"{spec.name} = {value:g} is not whole; {_valid_range(spec)}")
    return int(value)


def _clamped_float32(value: float) -> float:
    return _float32(max(-_FLOAT32_MAX, min(_FLOAT32_MAX, value)))


def _valid_range(spec: ParameterSpec) -> str:
    kind = "whole numbers" if spec.type == "int" else "numbers"
    unit = f" {spec.unit}" if spec.unit else ""
    return f"valid are {kind} from {spec.minimum:g} to {spec.maximum:g}{unit}"
