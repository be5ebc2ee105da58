"""Several growths of one place, taken in turn."""

from __future__ import annotations

from collections.abc import Iterator


def in_turn(*growths: Iterator[None]) -> Iterator[None]:
    """One step of each growth after another, until none is left."""
    growing = list(growths)
    while growing:
        for growth in tuple(growing):
            try:
                next(growth)
            except StopIteration:
                growing.remove(growth)
            else:
                yield
