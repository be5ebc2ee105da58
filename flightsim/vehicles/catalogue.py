"""Airframes by name: those that ship, and files of your own."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

from flightsim.vehicles.airframe import Airframe, AirframeError
from flightsim.vehicles.definition import read_airframe

_SHIPPED = Path(__file__).parent / "shipped"
_SUFFIX = ".toml"
# Named here, so that a list of names for `--help` reads no files.
_NAMES = ("iris", "iris-rotors", "hummingbird", "crazyflie", "typhoon")


class _Shipped(Mapping[str, Airframe]):
    """Airframes that ship, each read when it is first asked for."""

    def __getitem__(self, name: str) -> Airframe:
        if name not in _NAMES:
            raise KeyError(name)
        return _read(name)

    def __iter__(self) -> Iterator[str]:
        return iter(_NAMES)

    def __len__(self) -> int:
        return len(_NAMES)


@cache
def _read(name: str) -> Airframe:
    return read_airframe(_SHIPPED / f"{name}{_SUFFIX}")


AIRFRAMES: Mapping[str, Airframe] = _Shipped()
"""Airframes that ship."""


def airframe_by_name(name: str) -> Airframe:
    """Return the airframe that ships under a name, or the one of a TOML file.

    Args:
        name: `iris` or another name of `AIRFRAMES`, or the path of a file whose name ends in .toml.

    Raises:
        AirframeError: If there is none, listing the valid names, or the file describes none.
    """
    if name in AIRFRAMES:
        return AIRFRAMES[name]
    if name.endswith(_SUFFIX):
        path = os.path.expanduser(name)  # noqa: PTH111 - pathlib's raises without a home folder
        return replace(read_airframe(Path(path)), handle=name)
    valid = ", ".join(AIRFRAMES)
    raise AirframeError(f"vehicle {name!r} is unknown; valid: {valid}, or a file FILE{_SUFFIX}")
