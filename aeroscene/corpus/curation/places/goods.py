"""Goods in the open: stacks of containers, pallets in rows, crates on crates or side by side."""

from __future__ import annotations

from collections.abc import Iterator

from aeroscene.corpus.curation.builder import Attributes, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.seating import put_on
from aeroscene.corpus.curation.places.support_surfaces import Bearing, on_top
from aeroscene.solids.shapes.materials import PAINT_COLOURS

CONTAINER_M = (6.06, 2.44, 2.59)
"""A twenty-foot container."""

_CLUSTER_M = (3.8, 2.0, 1.5)
"""Area that a cluster of goods takes."""
_CLUSTER_PITCH_M = (4.6, 3.4)
"""Distances between the middles of clusters side by side and in depth."""

Area = tuple[float, float, float, float]
"""Area u0, u1, v0, v1 in the parcel's frame."""


def paint(draw: Draw) -> Attributes:
    """Draw a colour for a vehicle, container or awning, as an attribute."""
    return {"colour": draw.one_of(PAINT_COLOURS)}


def set_container(ground: Ground, u: float, v: float, turn: float) -> Placed | None:
    """Set a container on the ground, painted in any colour.

    Args:
        ground: Parcel.
        u: Middle along the street, m.
        v: Middle, m from the street.
        turn: Heading in the parcel's frame, rad.

    Returns:
        The container, or None if it does not fit.
    """
    return ground.erect("container", u, v, CONTAINER_M, turn=turn, look=paint(ground.draw))


def stack_container(ground: Ground, lower: Placed) -> Placed | None:
    """Set another container of the same size flush on top of one; None if it does not fit."""
    look = paint(ground.draw)
    return on_top(ground, lower).stand("container", lower.frame, lower.size, margin=0.0, look=look)


def pallet_row(bearing: Bearing, frame: Frame, u: float, v: float, count: int) -> None:
    """Place loaded pallets side by side along a frame's x axis.

    Args:
        bearing: Surface that carries them.
        frame: Frame of the coordinates.
        u: Middle of the row, m.
        v: Middle of the row, m.
        count: Number of pallets; those that do not fit are left out.
    """
    for index in range(count):
        # A pallet's width and 0.2 m between.
        at = u + (index - (count - 1) / 2) * 1.4
        size = (1.2, 1.0, bearing.draw.between(0.5, 1.4))
        bearing.stand("pallet", frame.moved(at, v), size)


def crate_stack(bearing: Bearing, frame: Frame, u: float, v: float) -> None:
    """Place two crates side by side and, in most cases, a smaller one on the first."""
    draw = bearing.draw
    first = bearing.stand("crate", frame.moved(u - 0.6, v), (1.0, 1.0, draw.between(0.7, 1.0)))
    side = draw.between(0.8, 1.05)
    bearing.stand("crate", frame.moved(u + 0.6, v, draw.between(-0.15, 0.15)), (side, side, 0.8))
    if first and draw.chance(0.7):
        spot = first.frame.moved(0.0, 0.0, draw.between(-0.1, 0.1))
        bearing.builder.place("crate", spot, (0.8, 0.8, 0.6), parent=first, within=first)


def plastic_crates(bearing: Bearing, frame: Frame, u: float, v: float, count: int) -> None:
    """Place plastic crates of one colour close together in two ranks.

    Args:
        bearing: Surface that carries them.
        frame: Frame of the coordinates.
        u: Middle of the first crate, m; the others follow along x and y.
        v: Middle of the first crate, m.
        count: Number of crates; those that do not fit are left out.
    """
    look = {**paint(bearing.draw), "form": "plastic"}
    for index in range(count):
        at = (u + (index // 2) * 0.82, v + (index % 2) * 0.82)
        bearing.stand("crate", frame.moved(*at), (0.7, 0.7, 0.62), look=look)


def range_goods(ground: Ground, bearing: Bearing, near: Area, rounds: int) -> Iterator[None]:
    """Place clusters of goods in rows from the back of an area, one cluster in each step.

    Args:
        ground: Parcel, in whose frame the area is.
        bearing: Surface that carries the goods.
        near: Area.
        rounds: Most clusters.
    """
    draw = ground.draw
    for index, (u, v) in zip(range(rounds), _free_spots(ground, near), strict=False):
        # Three clusters of a kind stand together.
        kind = index // 3 % 3
        if kind == 0:
            pallet_row(bearing, ground.parcel.frame, u, v, draw.count(2, 3))
        elif kind == 1:
            crate_stack(bearing, ground.parcel.frame, u, v)
        else:
            plastic_crates(bearing, ground.parcel.frame, u, v, draw.count(3, 4))
        yield


def _free_spots(ground: Ground, near: Area) -> Iterator[tuple[float, float]]:
    """Free places for clusters of goods, row by row from the back, beginning at one flank."""
    u0, u1, v0, v1 = near
    length, width, height = _CLUSTER_M
    columns, rows = (
        int((space - own) // pitch) + 1 if space >= own else 0
        for space, own, pitch in zip(
            (u1 - u0, v1 - v0), (length, width), _CLUSTER_PITCH_M, strict=True
        )
    )
    side = 1 if ground.draw.chance(0.5) else -1
    # A centimetre above the surface, which is itself an occupant.
    base = ground.level + 0.01
    for row in range(rows):
        v = v1 - width / 2 - row * _CLUSTER_PITCH_M[1]
        for column in range(columns):
            reach = (u1 - u0 - length) / 2 - column * _CLUSTER_PITCH_M[0]
            u = (u0 + u1) / 2 + side * reach
            if ground.builder.is_free(
                ground.parcel.frame.moved(u, v), (length, width, height), base
            ):
                yield (u, v)


def boxes_on(ground: Ground, bearer: Placed, count: int) -> None:
    """Place cartons along an object's upper face, evenly from end to end.

    Args:
        ground: Parcel, whose builder and randomness are used.
        bearer: Object that carries them.
        count: Number of cartons; those that do not fit are left out.
    """
    reach = bearer.size[1] / 2 - 0.4
    for index in range(count):
        at = 0.0 if count == 1 else -reach + 2 * reach * index / (count - 1)
        put_on(ground.builder, ground.draw, bearer, "box", 0.0, at, 0.0)
