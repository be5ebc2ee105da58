"""Parts that shapes have in common: paint, legs, sloping planes, prisms and cones.

All of them are given by intervals in the frame of the object, because furniture and buildings are
designed from faces and edges rather than from centres and sizes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import cos, pi, sin

from aeroscene.scene import Quaternion, Vector3
from aeroscene.solids.shapes.primitive import (
    Axis,
    Interval,
    Part,
    Span,
    block,
    centred,
    cylinder,
    hull,
)

PAINT_M = 0.005
"""Thickness of paint."""


def paint(x: Span, y: Span, z: Span, material: str) -> Part:
    """A box that touches nothing, for paint, panes and handles.

    Args:
        x: Interval, or length about zero, m.
        y: Interval, or length about zero, m.
        z: Interval of heights above the object's bottom, m.
        material: Name of the material.
    """
    return block(x, y, z, material, collides=False)


def disc(
    centre_m: Vector3, diameter_m: float, length_m: float, material: str, *, axis: Axis = "z"
) -> Part:
    """A cylinder that touches nothing, for hoops, lamps and lids."""
    return cylinder(centre_m, diameter_m, length_m, material, axis=axis, collides=False)


def about(middle: float, length: float) -> Interval:
    """The interval of a length about a point, m."""
    return (middle - length / 2, middle + length / 2)


def inwards(sign: int, reach: float, depth: float) -> Interval:
    """The interval of a depth on the inner side of `sign * reach`.

    For example, `inwards(-1, 2.0, 0.5)` is (-2.0, -1.5): the last half metre of a box at its -x
    end.
    """
    # The interval is ordered from low to high on both sides.
    return (reach - depth, reach) if sign > 0 else (-reach, depth - reach)


def shifted(part: Part, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Part:
    """A copy of a part, moved by some metres."""
    px, py, pz = part.position_m
    return replace(part, position_m=(px + x, py + y, pz + z))


def legs(x: float, y: float, z: Interval, thick: float, material: str) -> list[Part]:
    """Four square posts in the corners of a rectangle about the middle.

    Args:
        x: Length of the rectangle, to the outer faces of the posts, m.
        y: Its width, m.
        z: Lower and upper end, m.
        thick: Side of a post, m.
        material: Name of the material.
    """
    return [
        block(inwards(sx, x / 2, thick), inwards(sy, y / 2, thick), z, material)
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]


def leaning(
    centre_m: Vector3, size_m: Vector3, angle_rad: float, axis: Axis, material: str
) -> Part:
    """A box turned about one axis, by the right-hand rule."""
    c, s = cos(angle_rad / 2), sin(angle_rad / 2)
    # Quaternions w, x, y, z.
    turn: dict[Axis, Quaternion] = {
        "x": (c, s, 0.0, 0.0),
        "y": (c, 0.0, s, 0.0),
        "z": (c, 0.0, 0.0, s),
    }
    return Part(
        kind="box", position_m=centre_m, quat_wxyz=turn[axis], size_m=size_m, material=material
    )


def prism(
    profile_xz_m: Sequence[tuple[float, float]], y: Span, material: str, lean_m: float = 0.0
) -> Part:
    """A convex side view pulled along y; the upper corners lean inwards by `lean_m`.

    Args:
        profile_xz_m: Corners of the side view, x and z, in any order.
        y: Interval along y, m.
        material: Name of the material.
        lean_m: Distance by which each side leans inwards at the top, m; used for cabins of cars.
    """
    top = max(z for _, z in profile_xz_m)
    foot = min(z for _, z in profile_xz_m)
    right, left = y if isinstance(y, tuple) else centred(y)
    vertices: list[Vector3] = []
    for px, pz in profile_xz_m:
        # In proportion to the height, so that the sides stay plane.
        inset = lean_m * (pz - foot) / (top - foot) if lean_m else 0.0
        vertices += [(px, right + inset, pz), (px, left - inset, pz)]
    return hull(vertices, material)


def frustum(
    bottom: tuple[float, float], top: tuple[float, float], z: Interval, material: str
) -> Part:
    """A hull between a lower and an upper rectangle, both about the middle, m."""
    vertices: list[Vector3] = [
        (sx * length / 2, sy * width / 2, height)
        for (length, width), height in ((bottom, z[0]), (top, z[1]))
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]
    return hull(vertices, material)


def cone(
    bottom: tuple[float, float] | float,
    top: tuple[float, float] | float,
    z: Interval,
    material: str,
    *,
    sides: int = 8,
) -> Part:
    """A cone or drum with flat facets.

    Args:
        bottom: Lower diameter, or diameters along x and y, m.
        top: Upper diameter, or diameters along x and y; 0 makes a tip.
        z: Lower and upper end, m.
        material: Name of the material.
        sides: Number of facets.
    """
    vertices: list[Vector3] = []
    for diameter, height in ((bottom, z[0]), (top, z[1])):
        along, across = diameter if isinstance(diameter, tuple) else (diameter, diameter)
        # A tip is one corner; several at one place would make faces without area.
        if min(along, across) < 0.01:
            vertices.append((0.0, 0.0, height))
            continue
        for side in range(sides):
            # Half a step, so that an even number of facets has flat sides towards the axes.
            angle = 2 * pi * (side + 0.5) / sides
            vertices.append((along / 2 * cos(angle), across / 2 * sin(angle), height))
    return hull(vertices, material)
