"""Filling of a place: further objects once everything that characterises it stands.

Scenes need about 150 objects, and small places run out of meaningful ones. Rows of equal objects
along the edges look planned, while random ones would look scattered.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from aeroscene.corpus.curation.frame import INWARD, STREETWARD
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.scene import Vector3

_PITCH_M = {"tree": 5.2, "bicycle": 1.0, "crate": 1.4, "pallet": 1.5}
_USUAL_PITCH_M = 3.4
"""Distance between neighbours in a row."""
_INSET_M = 1.3
"""Distance of the rows from the borders of the area."""
_LEAST_M = 4.0

_Row = Iterator[tuple[float, float, float]]
"""Places and turns, one after another."""


def fill_up(
    ground: Ground, names: Sequence[str], near: tuple[float, float, float, float], rounds: int
) -> Iterator[None]:
    """Place two objects of a kind in each step, in rows along the back and the flanks of an area.

    Each kind has its own row; all objects of a row are equal and face the area.

    Args:
        ground: Parcel.
        names: Categories, used in turn.
        near: Area u0, u1, v0, v1.
        rounds: Number of steps.
    """
    u0, u1, v0, v1 = near
    if u1 - u0 < _LEAST_M or v1 - v0 < _LEAST_M:
        return
    rows: dict[str, tuple[_Row, Vector3]] = {}
    for index in range(rounds):
        name = names[index % len(names)]
        if name not in rows:
            # The number of kinds so far decides on the side, so that each kind has another one.
            row = _row(ground, len(rows), near, _PITCH_M.get(name, _USUAL_PITCH_M))
            rows[name] = (row, _size(ground, name))
        row, size = rows[name]
        placed = 0
        # The row is a generator: the next round continues where this one stopped.
        for u, v, turn in row:
            look = {"form": "round"} if name == "tree" else None
            placed += ground.stand(name, u, v, size, turn=turn, look=look) is not None
            if placed == 2:
                break
        if placed:
            yield


def _row(
    ground: Ground, number: int, near: tuple[float, float, float, float], pitch: float
) -> _Row:
    """Places along the next side of an area (back, left or right), from a random start."""
    u0, u1, v0, v1 = near
    # The start varies, so that rows of two scenes do not begin alike.
    start = ground.draw.between(0.0, 0.4)
    if number % 3 == 0:
        count = int((u1 - u0 - 2 * _INSET_M) / pitch)
        for index in range(int(start * count), count):
            yield u0 + _INSET_M + (index + 0.5) * pitch, v1 - _INSET_M, STREETWARD
        return
    side = 1 if number % 3 == 1 else -1
    u, turn = (u1 - _INSET_M, 2 * INWARD) if side > 0 else (u0 + _INSET_M, 0.0)
    count = int((v1 - v0 - 2 * _INSET_M) / pitch)
    for index in range(int(start * count), count):
        yield u, v0 + _INSET_M + (index + 0.5) * pitch, turn


def _size(ground: Ground, name: str) -> Vector3:
    """One size for a whole row; trees and bushes are as wide as deep."""
    x, y, z = ground.draw.size_of(name)
    if name == "tree":
        width = ground.draw.between(2.2, 3.4)
        return (width, width, round(2.1 * width, 2))
    return (x, x, z) if name == "bush" else (x, y, z)
