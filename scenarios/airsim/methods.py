"""A table of methods: each checks its arguments by the annotations of the function that answers."""

from __future__ import annotations

import inspect
import typing
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import msgspec

_MOST_TEXT = 200


class RpcError(Exception):
    """An answer that tells the client why a call is refused; one line."""


class Later:
    """An answer that comes when something is done.

    Attributes:
        value: The answer, once it is done.
        error: Line that says why there is none.
    """

    def __init__(self) -> None:
        self.is_done = False
        self.value: object = None
        self.error: str | None = None
        self._then: list[Callable[[], None]] = []

    def finish(self, value: object) -> None:
        """Answer; only the first answer counts."""
        if not self.is_done:
            self.is_done, self.value = True, value
            self._end()

    def fail(self, line: str) -> None:
        """Answer that there is none."""
        if not self.is_done:
            self.is_done, self.error = True, line
            self._end()

    def then(self, function: Callable[[], None]) -> None:
        """Call a function once the answer has come."""
        self._then.append(function)
        if self.is_done:
            self._end()

    def _end(self) -> None:
        for function in self._then:
            function()
        self._then.clear()


def all_of(answers: Sequence[Later]) -> Later:
    """An answer without a value, which comes when all have come; the first error is its own."""
    later = Later()

    def check() -> None:
        if all(answer.is_done for answer in answers):
            error = next((answer.error for answer in answers if answer.error), None)
            if error is None:
                later.finish(None)
            else:
                later.fail(error)

    for answer in answers:
        answer.then(check)
    return later


class Method:
    """One method: converts arguments to the annotated types and calls the function."""

    def __init__(self, name: str, function: Callable[..., object]) -> None:
        self._name, self._function = name, function
        hints = typing.get_type_hints(function)
        parameters = inspect.signature(function).parameters.values()
        self._types = [hints[parameter.name] for parameter in parameters]
        self._names = [parameter.name for parameter in parameters]
        self._n_least = sum(parameter.default is parameter.empty for parameter in parameters)

    def __call__(self, args: list[Any]) -> object:
        """Answer a call.

        Raises:
            RpcError: If arguments are missing, too many or of a wrong type; or as the function
                raises it.
        """
        if not self._n_least <= len(args) <= len(self._types):
            least, most = self._n_least, len(self._types)
            valid = str(most) if least == most else f"{least} to {most}"
            raise RpcError(f"{self._name} has {len(args)} arguments; valid: {valid}")
        converted: list[Any] = []
        for value, kind, name in zip(args, self._types, self._names, strict=False):
            try:
                converted.append(msgspec.convert(value, kind, strict=False))
            except (msgspec.ValidationError, RecursionError, OverflowError) as error:
                line = f"{self._name}: {name} is not valid: {error}"
                raise RpcError(line[: 2 * _MOST_TEXT]) from None
        return self._function(*converted)


class Methods:
    """All methods by their names, and reasons why others are not offered."""

    def __init__(self, refused: Mapping[str, str]) -> None:
        """Begin with none.

        Args:
            refused: Names of methods that are not offered, and why.
        """
        self._methods: dict[str, Method] = {}
        self._refused = refused

    def add(self, functions: Mapping[str, Callable[..., object]]) -> None:
        """Offer functions under names."""
        for name, function in functions.items():
            self._methods[name] = Method(name, function)

    @property
    def names(self) -> frozenset[str]:
        """Names of the methods that are offered."""
        return frozenset(self._methods)

    def dispatch(self, name: str, args: list[Any]) -> object:
        """Answer a call.

        Raises:
            RpcError: If there is no such method, or it refuses.
        """
        method = self._methods.get(name)
        if method is not None:
            return method(args)
        if name in self._refused:
            raise RpcError(f"{name} is not offered: {self._refused[name]}")
        raise RpcError(f"{name[:_MOST_TEXT]!r} is no method of AirSim's multirotor API")
