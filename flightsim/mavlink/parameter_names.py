"""The autopilot's parameters under the names and in the units of another flight stack.

Clients of ArduPilot know its names and read back what they set. Several of their values may be one
of ours: two numbers for the same action, or a 0 that stands for another parameter's value. So the
value that a client set is kept beside ours, and reported as long as ours has not changed.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Collection, Iterator

from flightsim.autopilot.parameters import (
    Parameters,
    ParameterValueError,
    ReadOnlyParameterError,
    UnknownParameterError,
)
from flightsim.mavlink.personalities import Alias, Personality
from flightsim.mavlink.view import VehicleView


class AliasedParameters:
    """Parameters for which a flight stack has a name, in the order of their names.

    A value that a client sets is reported as it was set, even if several of its values are one of
    ours.
    """

    def __init__(self, view: VehicleView, personality: Personality) -> None:
        self._parameters: Parameters = view.autopilot.parameters
        self._view = view
        self._aliases = {alias.name: alias for alias in personality.aliases}
        self._settings = {setting.name: setting for setting in personality.settings}
        self._names = tuple(sorted((*self._aliases, *self._settings)))
        self._chosen: dict[str, int] = {}
        # What clients see of our value, by name: (theirs, ours).
        self._told: dict[str, tuple[float, float]] = {
            alias.name: (alias.default, self._parameters[alias.ours])
            for alias in personality.aliases
            if alias.default is not None and self._is_default(alias)
        }

    def __len__(self) -> int:
        return len(self._names)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __getitem__(self, name: str) -> float:
        """Value in the flight stack's unit; the nearest choice below if it lacks our value."""
        if (setting := self._settings.get(name)) is not None:
            present = setting.read(self._view)
            chosen = self._chosen.get(name, present)
            # The choice of a client is reported as long as it still means the present state.
            return chosen if setting.choices[chosen] == setting.choices[present] else present
        alias = self._alias(name)
        ours = self._parameters[alias.ours]
        told, of = self._told.get(name, (math.nan, math.nan))
        # Ours has not changed since the client set it: report its own number.
        if ours == of:
            return told
        if alias.codes:
            return next((code for code, value in alias.codes.items() if value == ours), 0)
        named = {value: number for number, value in alias.special.items()}
        value = named.get(ours, ours / alias.scale)
        return round(value) if alias.is_integer else value

    def is_integer(self, name: str) -> bool:
        """Return true if the parameter is a whole number.

        Raises:
            UnknownParameterError: If there is none of this name.
        """
        return name in self._settings or self._alias(name).is_integer

    def index(self, name: str) -> int:
        """Return the index of a parameter, from 0.

        Raises:
            UnknownParameterError: If there is none of this name.
        """
        return self._names.index(name if name in self._settings else self._alias(name).name)

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

    def set(self, name: str, value: float) -> float:
        """Change a parameter and return its value as stored.

        Raises:
            UnknownParameterError: If there is none of this name.
            ParameterValueError: If the value is NaN, out of range or no choice.
            ReadOnlyParameterError: If it is read-only and the value would change it.
        """
        if (setting := self._settings.get(name)) is not None:
            _check_choice(name, value, setting.choices)
            self._chosen[name] = int(value)
            setting.write(self._view, int(value))
            return self[name]
        alias = self._alias(name)
        self._check(alias, value)
        # As the wire holds it, so that a client reads back what it wrote.
        stored = float(int(value)) if alias.is_integer else _float32(value)
        try:
            ours = self._parameters.set(alias.ours, self._ours_of(alias, stored))
        except ReadOnlyParameterError as error:
            raise ReadOnlyParameterError(f"{name} is read-only and stays {self[name]:g}") from error
        self._told[name] = (stored, ours)
        self._follow(alias)
        return self[name]

    def _follow(self, changed: Alias) -> None:
        """Change the parameters along whose 0 stands for the changed one."""
        for alias in self._aliases.values():
            if alias.zero_means == changed.name and self[alias.name] == 0:
                ours = self._parameters.set(alias.ours, self._parameters[changed.ours])
                self._told[alias.name] = (0.0, ours)

    def _ours_of(self, alias: Alias, value: float) -> float:
        if alias.zero_means and value == 0:
            return self._parameters[self._aliases[alias.zero_means].ours]
        return alias.ours_of(value)

    def _check(self, alias: Alias, value: float) -> None:
        """Refuse a value that the flight stack does not allow, in its own words and unit."""
        if alias.codes:
            _check_choice(alias.name, value, alias.codes)
            return
        least, most = self._range(alias)
        is_whole = not alias.is_integer or (math.isfinite(value) and value == int(value))
        if value in alias.special or (is_whole and least <= _float32(value) <= most):
            return
        kind = "whole numbers" if alias.is_integer else "numbers"
        # Special values below the range are valid too, such as -1 for "off".
        others = "".join(f" and {number:g}" for number in alias.special if number < least)
        unit = f" {alias.unit}" if alias.unit else ""
        raise ParameterValueError(
            f"{alias.name} = {value:g} is refused: valid are {kind} from {least:g} to {most:g}"
            f"{unit}{others}"
        )

    def _range(self, alias: Alias) -> tuple[float, float]:
        """Return the valid range in the flight stack's unit, as 32 bits hold it."""
        if alias.valid is not None:
            least, most = alias.valid
        else:
            spec = self._parameters.spec(alias.ours)
            least, most = spec.minimum / alias.scale, spec.maximum / alias.scale
        return _float32(least), _float32(most)

    def _is_default(self, alias: Alias) -> bool:
        """Return true if the vehicle starts with the flight stack's default."""
        assert alias.default is not None, alias.name
        # Ours is rounded to 32 bits.
        return math.isclose(
            self._parameters[alias.ours], self._ours_of(alias, alias.default), rel_tol=1e-6
        )

    def _alias(self, name: str) -> Alias:
        alias = self._aliases.get(name)
        if alias is None:
            raise UnknownParameterError(f"parameter {name[:32]!r} does not exist")
        return alias


def _check_choice(name: str, value: float, choices: Collection[int]) -> None:
    if value not in choices:
        valid = ", ".join(map(str, choices))
        raise ParameterValueError(f"{name} = {value:g} is no choice; valid are {valid}")


def _float32(value: float) -> float:
    """Return the number as 32 bits hold it; one that they cannot hold stays as it is."""
    try:
        return struct.unpack("<f", struct.pack("<f", value))[0]
    except OverflowError:
        return value
