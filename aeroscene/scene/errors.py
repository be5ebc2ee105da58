"""The error that a scene raises when it breaks a rule, and the checks that raise it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import get_args

from aeroscene.files.visible import shown


class SceneError(ValueError):
    """A scene that breaks a rule of the schema; one line says where, what and what is valid."""

    def within(self, where: str) -> SceneError:
        """Return the same error with a place in front, such as `object 12`.

        Callers add their place one by one, so that the message reads from the file down to the
        field.
        """
        return type(self)(f"{where}: {self}")


def require(*, ok: bool, field_name: str, value: object, valid: str) -> None:
    """Raise `SceneError` unless `ok`.

    Args:
        ok: The condition that a valid scene meets.
        field_name: Field as it is called in the file, for example `bbox.s`.
        value: Wrong value; long ones are cut short in the message.
        valid: Description of valid values, which ends the message.
    """
    if not ok:
        raise SceneError(f"{field_name} is {shown(value)}; valid: {valid}")


def require_finite(values: Sequence[float], count: int, field_name: str) -> None:
    """Require exactly `count` finite numbers.

    Raises:
        SceneError: If there are more or fewer, or one is infinite or not a number.
    """
    ok = len(values) == count and all(math.isfinite(v) for v in values)
    require(ok=ok, field_name=field_name, value=values, valid=f"{count} finite numbers")


def require_within(values: Sequence[float], limit: float, field_name: str) -> None:
    """Require finite numbers from -limit to limit; an integer beyond floats is outside."""
    # Python compares integers of any size with floats, so a huge one is refused rather than an
    # `OverflowError`.
    ok = all(-limit <= v <= limit for v in values)
    single = len(values) == 1
    valid = f"{'a number' if single else f'{len(values)} numbers'} from {-limit:g} to {limit:g}"
    require(ok=ok, field_name=field_name, value=values[0] if single else values, valid=valid)


def require_one_of(value: str, choices: object, field_name: str) -> None:
    """Require one of the values of the `Literal` type `choices`."""
    valid = get_args(choices)
    require(ok=value in valid, field_name=field_name, value=value, valid=", ".join(valid))
