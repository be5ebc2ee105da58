"""Values at the extremes of every type of field, and messages made of them."""

from __future__ import annotations

import math
import random
import re
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from flightsim.mavlink.dialect import LAYOUTS, dialect

_T = TypeVar("_T")

# Zero and small numbers, degrees out of range, ends of integer types, not-a-number, the largest and
# smallest floats, and 21196, by which arming is forced.
FLOATS = (
    *(0.0, -0.0, 1.0, -1.0, 2.0, 3.0, 0.5, 47.4, 8.5, 90.1, 180.1, 255.0, 256.0, 65535.0, 65536.5),
    *(math.nan, math.inf, -math.inf, 1e30, -1e30, 5e9, -5e9, 2147483648.0, -2147483649.0, 1e-40),
    *(3.4028234663852886e38, -3.4028234663852886e38, 20000.0, 21196.0, 1e6),
)
_TEXTS = (
    *(b"", b"\xff" * 250, b"A" * 250, b"%s%n/../"),
    # Names of parameters are the texts that are looked up.
    *(b"_HASH_CHECK", b"SYS_AUTOSTART", b"MPC_XY_CRUISE"),
)
_BITS = {"b": 8, "h": 16, "i": 32, "q": 64}
_V2_IDS = 256
"""Least number of a message that MAVLink 1 cannot carry."""
VEHICLE = (1, 1)  # system and component
# Mostly a ground station; the vehicle itself, everybody and nobody too.
_SENDERS = ((255, 190), (255, 190), (254, 1), (1, 191), (0, 0), (1, 1), (255, 255))


def chance(rng: random.Random, share: float) -> bool:
    """Return true in a share of the calls."""
    return rng.random() < share


@dataclass(frozen=True)
class Field:
    """A field of a message: its name, the letter of its type and how many values it has."""

    name: str
    letter: str
    count: int


class MessageType:
    """A message type with its fields in wire order, and how to draw each."""

    def __init__(self, message_class: Any) -> None:
        self.name: str = message_class.msgname
        self.layout = LAYOUTS[self.name]
        self._struct: struct.Struct = message_class.unpacker
        # A struct format: byte order first, then a count and a letter for each field.
        parts = re.findall(r"(\d*)(\D)", self._struct.format[1:])
        names: Sequence[str] = message_class.ordered_fieldnames
        self.fields = [
            Field(name, letter, int(count or 1))
            for name, (count, letter) in zip(names, parts, strict=True)
        ]
        self._drawers = [(field.name, _drawer(field)) for field in self.fields]
        self.addressed = {
            name: number
            for name, number in zip(("target_system", "target_component"), VEHICLE, strict=True)
            if name in names
        }
        """Fields that name the receiver, with the vehicle's numbers."""

    def payload(self, rng: random.Random, given: dict[str, Any]) -> bytes:
        """Pack a payload of drawn values, but for the given ones.

        Args:
            rng: Draws.
            given: Values by the names of fields; a list for an array.

        Raises:
            struct.error: If a given value does not fit its field.
        """
        values: list[Any] = []
        for name, draw in self._drawers:
            if name in given:
                value = given[name]
                values += value if isinstance(value, (list, tuple)) else [value]
            else:
                values += draw(rng)
        return self._struct.pack(*values)


def pick(rng: random.Random, options: Sequence[_T]) -> _T:
    """Pick one of some options; `Random.choice` takes twice as long."""
    return options[int(rng.random() * len(options))]


def _drawer(field: Field) -> Callable[[random.Random], Sequence[Any]]:
    """Function that draws the values of a field, mostly at the extremes of its type."""
    letter, count = field.letter, field.count
    if letter == "s":
        return lambda rng: (pick(rng, _TEXTS) if rng.random() < 0.7 else rng.randbytes(count),)
    if letter in "bB" and count > 1:
        return _byte_drawer(letter, count)
    number = _float_drawer if letter in "fd" else _whole_drawer(letter)
    if count == 1:
        return lambda rng: (number(rng),)

    # Half of the arrays have one value throughout.
    def array(rng: random.Random) -> Sequence[Any]:
        if rng.random() < 0.5:
            return (number(rng),) * count
        return [number(rng) for _ in range(count)]

    return array


def _float_drawer(rng: random.Random) -> float:
    return FLOATS[int(rng.random() * len(FLOATS))]


def _extremes(letter: str) -> tuple[int, int, tuple[int, ...]]:
    """Bits and least number of a type, and its extremes."""
    bits, is_signed = _BITS[letter.lower()], letter.islower()
    low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if is_signed else (0, (1 << bits) - 1)
    # 190 is the component of a ground station.
    return bits, low, (low, high, 0, 1, 2, 3, 5, high - 1, min(high, 190))


def _whole_drawer(letter: str) -> Callable[[random.Random], int]:
    bits, low, extremes = _extremes(letter)
    n = len(extremes)

    def number(rng: random.Random) -> int:
        if rng.random() < 0.3:
            return low + rng.getrandbits(bits)
        return extremes[int(rng.random() * n)]

    return number


def _byte_drawer(letter: str, count: int) -> Callable[[random.Random], Sequence[int]]:
    """Drawer of an array of bytes: one extreme throughout, any bytes, or extremes among them."""
    _, low, extremes = _extremes(letter)
    # One table does all bytes at once: a third stay what they are, the others become extremes.
    mixed = bytes(
        byte if byte % 3 == 0 else (extremes[byte % len(extremes)] - low) for byte in range(256)
    )

    def array(rng: random.Random) -> Sequence[int]:
        draw = rng.random()
        if draw < 0.5:
            return (pick(rng, extremes),) * count
        data = rng.randbytes(count)
        data = data.translate(mixed) if draw < 0.8 else data
        return [low + byte for byte in data] if low else data

    return array


TYPES = {c.msgname: MessageType(c) for c in dialect.mavlink_map.values()}


def frame(rng: random.Random, name: str, /, **given: Any) -> bytes:
    """Draw a frame of a message.

    In four of five draws it is addressed to the vehicle. One in ten of those that MAVLink 1 can
    carry has that version.

    Args:
        rng: Draws.
        name: Name of the message.
        given: Values of fields that are not drawn.
    """
    kind = TYPES[name]
    if rng.random() < 0.8:
        given = kind.addressed | given
    payload = kind.payload(rng, given)
    is_version_1 = kind.layout.message_id < _V2_IDS and chance(rng, 0.1)
    build = kind.layout.frame_v1 if is_version_1 else kind.layout.frame_v2
    return build(payload, rng.getrandbits(8), *pick(rng, _SENDERS))
