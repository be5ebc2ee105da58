"""Hostile MessagePack-RPC: calls with wild arguments, and bytes that are no calls at all."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence

import msgspec

_WORDS = ("", "0", "front_center", "Drone1", "SimpleFlight", ".*", "(a*)*b", "\0", "x" * 300, "π")
_NUMBERS = (0, 1, -1, 7, 1 << 31, (1 << 64) - 1, -(1 << 63), 0.5, 1e308, math.inf, math.nan, -0.0)
_VECTOR, _QUATERNION = ("x_val", "y_val", "z_val"), ("w_val", "x_val", "y_val", "z_val")
_DEEPEST = 4


class RpcTraffic:
    """Messages of a hostile client, one after another."""

    def __init__(self, seed: int, methods: Sequence[str]) -> None:
        """Draw from a seed; `methods` are the names that a server knows."""
        self._random = random.Random(seed)
        self._methods = list(methods)

    def message(self) -> bytes:
        """The next one; about a third of them is broken, so that the server hangs up."""
        draw = self._random.random()
        if draw < 0.68:
            return self._call()
        breaks: tuple[Callable[[], bytes], ...] = (
            self._noise,
            self._cut,
            self._flipped,
            self._deep,
            self._announced,
            self._other,
        )
        return self._random.choice(breaks)()

    def _call(self) -> bytes:
        name = self._random.choice(self._methods) if self._random.random() < 0.95 else self._text()
        args = [self._value(0) for _ in range(self._random.randrange(9))]
        if self._random.random() < 0.1:
            return msgspec.msgpack.encode([2, name, args])
        return msgspec.msgpack.encode([0, self._random.randrange(1 << 32), name, args])

    def _noise(self) -> bytes:
        return self._random.randbytes(self._random.randrange(1, 200))

    def _cut(self) -> bytes:
        whole = self._call()
        return whole[: self._random.randrange(len(whole))]

    def _flipped(self) -> bytes:
        whole = bytearray(self._call())
        for _ in range(self._random.randrange(1, 4)):
            whole[self._random.randrange(len(whole))] = self._random.randrange(256)
        return bytes(whole)

    def _deep(self) -> bytes:
        return self._random.choice((b"\x91", b"\x81\x01")) * self._random.randrange(5, 2000)

    def _announced(self) -> bytes:
        """Headers of lengths that never come."""
        head = self._random.choice((0xC6, 0xC9, 0xDB, 0xDD, 0xDF))
        return bytes([0x94, 0, 1, head]) + self._random.randbytes(4)

    def _other(self) -> bytes:
        """Whole MessagePack that is no request."""
        return msgspec.msgpack.encode(self._value(0))

    def _value(self, depth: int) -> object:
        kinds: list[Callable[[], object]] = [
            lambda: self._random.choice(_NUMBERS),
            lambda: self._random.uniform(-100.0, 100.0),
            lambda: self._random.random() < 0.5,
            self._text,
            lambda: None,
            lambda: self._random.randbytes(self._random.randrange(20)),
            lambda: self._fields(_VECTOR),
            lambda: {"position": self._fields(_VECTOR), "orientation": self._fields(_QUATERNION)},
            lambda: {"is_rate": self._random.random() < 0.5, "yaw_or_rate": self._number()},
        ]
        if depth < _DEEPEST:
            kinds += [
                lambda: [self._value(depth + 1) for _ in range(self._random.randrange(5))],
                lambda: {self._text(): self._value(depth + 1) for _ in range(2)},
            ]
        return self._random.choice(kinds)()

    def _fields(self, names: Sequence[str]) -> dict[str, float]:
        return {name: self._number() for name in names}

    def _number(self) -> float:
        if self._random.random() < 0.3:
            return float(self._random.choice(_NUMBERS))
        return self._random.uniform(-30.0, 30.0)

    def _text(self) -> str:
        return self._random.choice(_WORDS)
