"""Parts that shapes have in common: paint, legs, sloping planes, prisms and cones."""

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
    """A box that touches nothing: paint, panes, handles."""
    return block(x, y, z, material, collides=False)


def disc(
    centre_m: Vector3, diameter_m: float, length_m: float, material: str, *, axis: Axis = "z"
) -> Part:
    """A cylinder that touches nothing: hoops, lamps, lids."""
    return cylinder(centre_m, diameter_m, length_m, material, axis=axis, collides=False)


def about(middle: float, length: float) -> Interval:
    """The interval of a length about a point."""
    return (middle - length / 2, middle + length / 2)


def inwards(sign: int, reach: float, depth: float) -> Interval:
    """The interval of a depth on the inner side of `sign * reach`."""
    return (reach - depth, reach) if sign > 0 else (-reach, depth - reach)


def shifted(part: Part, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Part:
    """A part moved."""
    px, py, pz = part.position_m
    return replace(part, position_m=(px + x, py + y, pz + z))


def legs(x: float, y: float, z: Interval, thick: float, material: str) -> list[Part]:
    """Four square posts in the corners of a rectangle about the middle."""
    return [
        block(inwards(sx, x / 2, thick), inwards(sy, y / 2, thick), z, material)
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]


def leaning(
    centre_m: Vector3, size_m: Vector3, angle_rad: float, axis: Axis, material: str
) -> Part:
    """A box turned about one axis."""
    c, s = cos(angle_rad / 2), sin(angle_rad / 2)
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
    """A convex side view pulled along y; the upper corners lean inwards by `lean_m`."""
    top = max(z for _, z in profile_xz_m)
    foot = min(z for _, z in profile_xz_m)
    right, left = y if isinstance(y, tuple) else centred(y)
    vertices: list[Vector3] = []
    for px, pz in profile_xz_m:
        inset = lean_m * (pz - foot) / (top - foot) if lean_m else 0.0
        vertices += [(px, right + inset, pz), (px, left - inset, pz)]
    return hull(vertices, material)


def frustum(
    bottom: tuple[float, float], top: tuple[float, float], z: Interval, material: str
) -> Part:
    """A hull between a lower and an upper rectangle, both about the middle."""
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
    """A faceted cone or drum, from its lower to its upper diameter or those along x and y."""
    vertices: list[Vector3] = []
    for diameter, height in ((bottom, z[0]), (top, z[1])):
        along, across = diameter if isinstance(diameter, tuple) else (diameter, diameter)
        if min(along, across) < 0.01:
            vertices.append((0.0, 0.0, height))
            continue
        for side in range(sides):
            angle = 2 * pi * (side + 0.5) / sides
            vertices.append((along / 2 * cos(angle), across / 2 * sin(angle), height))
    return hull(vertices, material)
