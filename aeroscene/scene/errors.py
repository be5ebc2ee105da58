"""What a scene breaks a rule by, and the checks that say so in one line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import get_args

from aeroscene.files.visible import shown


class SceneError(ValueError):
    """A scene that breaks a rule of the schema; one line saying where, what and what is valid."""

    def within(self, where: str) -> SceneError:
        """The same error with the place that contains it in front."""
        return type(self)(f"{where}: {self}")


def require(*, ok: bool, field_name: str, value: object, valid: str) -> None:
    """Raise `SceneError` that names field, value and what would be valid, unless `ok`."""
    if not ok:
        raise SceneError(f"{field_name} is {shown(value)}; valid: {valid}")


def require_finite(values: Sequence[float], count: int, field_name: str) -> None:
    """Require `count` finite numbers."""
    ok = len(values) == count and all(math.isfinite(v) for v in values)
    require(ok=ok, field_name=field_name, value=values, valid=f"{count} finite numbers")


def require_within(values: Sequence[float], limit: float, field_name: str) -> None:
    """Require finite numbers from -limit to limit; an integer beyond floats is outside."""
    ok = all(-limit <= v <= limit for v in values)
    single = len(values) == 1
    valid = f"{'a number' if single else f'{len(values)} numbers'} from {-limit:g} to {limit:g}"
    require(ok=ok, field_name=field_name, value=values[0] if single else values, valid=valid)


def require_one_of(value: str, choices: object, field_name: str) -> None:
    """Require one of the values of a `Literal` type."""
    valid = get_args(choices)
    require(ok=value in valid, field_name=field_name, value=value, valid=", ".join(valid))
