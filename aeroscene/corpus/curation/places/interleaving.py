"""Interleaving of several growths of one place."""

from __future__ import annotations

from collections.abc import Iterator


def interleave(*growths: Iterator[None]) -> Iterator[None]:
    """Take one step of each growth after another, until none is left.

    A scene that fills up early then has a little of everything, instead of all of the first growth.
    """
    growing = list(growths)
    while growing:
        for growth in tuple(growing):
            try:
                next(growth)
            except StopIteration:
                growing.remove(growth)
            else:
                yield
