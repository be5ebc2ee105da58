"""Find where one MessagePack object ends in a stream of bytes, within bounds.

msgspec decodes whole objects, and a socket delivers pieces of them. Walking over the headers finds
the end of an object before anything is built from it. A sender therefore cannot make the server
allocate more than the bounds allow: a header that announces a million elements costs nothing.

Source: github.com/msgpack/msgpack, spec.md.
"""

from __future__ import annotations

MOST_BYTES = 1 << 20
"""Longest object. The largest honest call is a path of some thousand points."""
MOST_ITEMS = 100_000
"""Most headers in one object."""
MOST_DEPTH = 12
"""Deepest nesting; a call with a list of poses has seven levels."""

_FIXED = {
    **dict.fromkeys((0xC0, 0xC2, 0xC3), 0),
    0xCA: 4,
    0xCB: 8,
    0xCC: 1,
    0xCD: 2,
    0xCE: 4,
    0xCF: 8,
    0xD0: 1,
    0xD1: 2,
    0xD2: 4,
    0xD3: 8,
    0xD4: 2,
    0xD5: 3,
    0xD6: 5,
    0xD7: 9,
    0xD8: 17,
}
"""Bytes that follow the header of an object of fixed length."""
_SIZED = {
    0xC4: (1, 0),
    0xC5: (2, 0),
    0xC6: (4, 0),
    0xC7: (1, 1),
    0xC8: (2, 1),
    0xC9: (4, 1),
    0xD9: (1, 0),
    0xDA: (2, 0),
    0xDB: (4, 0),
}
"""Bytes of the length of binaries, extensions and strings, and bytes besides that length."""
_CONTAINERS = {0xDC: (2, 1), 0xDD: (4, 1), 0xDE: (2, 2), 0xDF: (4, 2)}
"""Bytes of the length of arrays and maps, and objects in each element."""


class FramingError(ValueError):
    """The bytes are no MessagePack, or exceed a bound; the stream cannot be continued."""


class Splitter:
    """Collects bytes and hands out whole objects."""

    def __init__(self) -> None:
        self._data = bytearray()
        self._start()

    def _start(self) -> None:
        self._at = self._n_items = 0
        self._open = [1]
        """Objects still missing in each container around the present place."""

    @property
    def n_waiting(self) -> int:
        """Bytes that are held because their object is not complete."""
        return len(self._data)

    def feed(self, data: bytes) -> None:
        """Append bytes."""
        self._data += data

    def take(self) -> bytes | None:
        """The next whole object; None if it is not complete.

        Raises:
            FramingError: If the bytes are no MessagePack or exceed a bound.
        """
        while self._open:
            if not self._step():
                if len(self._data) > MOST_BYTES:
                    raise FramingError(f"message is longer than {MOST_BYTES} bytes")
                return None
        whole = bytes(self._data[: self._at])
        del self._data[: self._at]
        self._start()
        return whole

    def _step(self) -> bool:
        """Walk over one header and what follows it; False if more bytes are needed."""
        data, at = self._data, self._at
        if at >= len(data):
            return False
        head = data[at]
        children = 0
        if head < 0x80 or head >= 0xE0:
            size = 0
        elif head < 0x90:
            size, children = 0, 2 * (head & 0x0F)
        elif head < 0xA0:
            size, children = 0, head & 0x0F
        elif head < 0xC0:
            size = head & 0x1F
        elif head in _FIXED:
            size = _FIXED[head]
        elif head in _SIZED or head in _CONTAINERS:
            width, factor = _SIZED.get(head) or _CONTAINERS[head]
            if at + 1 + width > len(data):
                return False
            length = int.from_bytes(data[at + 1 : at + 1 + width], "big")
            size = width
            if head in _CONTAINERS:
                children = factor * length
            else:
                size += factor + length
        else:
            raise FramingError(f"byte {head:#x} begins no MessagePack object")
        end = at + 1 + size
        if end > MOST_BYTES:
            raise FramingError(f"message is longer than {MOST_BYTES} bytes")
        if end > len(data):
            return False
        self._at = end
        self._count(children)
        return True

    def _count(self, children: int) -> None:
        """Take note of an object that has been walked over, and of those that it announces."""
        self._n_items += 1
        if self._n_items + children > MOST_ITEMS:
            raise FramingError(f"message has more than {MOST_ITEMS} items")
        self._open[-1] -= 1
        if children:
            if len(self._open) > MOST_DEPTH:
                raise FramingError(f"message is nested deeper than {MOST_DEPTH} levels")
            self._open.append(children)
        while self._open and self._open[-1] == 0:
            self._open.pop()
