"""The autopilot's parameters under the names and in the units of another flight stack."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from flightsim.autopilot.parameters import (
    ParameterError,
    Parameters,
    ParameterValueError,
    ReadOnlyParameterError,
    UnknownParameterError,
)
from flightsim.mavlink.personalities import Alias


class AliasedParameters:
    """Those parameters for which a flight stack has a name, in the order of its table."""

    def __init__(self, parameters: Parameters, aliases: Sequence[Alias]) -> None:
        self._parameters = parameters
        self._aliases = {alias.name: alias for alias in aliases}
        self._names = tuple(self._aliases)

    def __len__(self) -> int:
        return len(self._names)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __getitem__(self, name: str) -> float:
        """Value in the flight stack's unit; the nearest choice below for one that it lacks."""
        alias = self._alias(name)
        ours = self._parameters[alias.ours]
        if alias.codes:
            return next((code for code, value in alias.codes.items() if value == ours), 0)
        value = ours / alias.scale
        return round(value) if alias.is_integer else value

    def is_integer(self, name: str) -> bool:
        """Whether the parameter is a whole number.

        Raises:
            UnknownParameterError: If there is none of this name.
        """
        return self._alias(name).is_integer

    def index(self, name: str) -> int:
        """Index of a parameter.

        Raises:
            UnknownParameterError: If there is none of this name.
        """
        return self._names.index(self._alias(name).name)

    def name_at(self, index: int) -> str:
        """Name of the parameter with this index.

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
        alias = self._alias(name)
        if alias.codes and value not in alias.codes:
            valid = ", ".join(map(str, alias.codes))
            raise ParameterValueError(f"{name} = {value:g} is no choice; valid are {valid}")
        ours = alias.codes[int(value)] if alias.codes else value * alias.scale
        try:
            self._parameters.set(alias.ours, ours)
        except ReadOnlyParameterError as error:
            raise ReadOnlyParameterError(f"{name} is read-only: {error}") from error
        except ParameterError as error:
            raise ParameterValueError(f"{name} = {value:g} is refused: {error}") from error
        return self[name]

    def _alias(self, name: str) -> Alias:
        alias = self._aliases.get(name)
        if alias is None:
            raise UnknownParameterError(f"parameter {name[:32]!r} does not exist")
        return alias
