"""Primitives in the world, and parts in an object's own frame: pure data.

Every primitive is convex, because physics engines collide convex solids only. A part is placed in
the frame of its object's box: x forwards, y left, origin in the middle of the box's bottom, so that
z is the height above the surface on which the object stands.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from aeroscene.scene import Quaternion, Vector3

PrimitiveKind = Literal["box", "cylinder", "ellipsoid", "mesh"]
Interval = tuple[float, float]
Span = Interval | float
"""An interval, or the length of an interval about zero."""
Axis = Literal["x", "y", "z"]

IDENTITY: Quaternion = (1.0, 0.0, 0.0, 0.0)
# Turns that take local z, along which cylinders stand, to each axis.
_HALF_SQRT_2 = 0.5**0.5
_QUAT_Z_TO: dict[Axis, Quaternion] = {
    "x": (_HALF_SQRT_2, 0.0, _HALF_SQRT_2, 0.0),
    "y": (_HALF_SQRT_2, -_HALF_SQRT_2, 0.0, 0.0),
    "z": IDENTITY,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Primitive:
    """A convex solid in the world, from which MuJoCo geoms and meshes are built."""

    kind: PrimitiveKind
    """A cylinder stands along its local z; a mesh is the convex hull of its vertices."""
    position_enu_m: Vector3
    """Centre of the bounding box in the local frame."""
    quat_wxyz: Quaternion
    """Local to world."""
    size_m: Vector3
    """Full local extents: a cylinder's are (diameter, diameter, length)."""
    material: str
    """Name in `MATERIALS`."""
    object_id: int
    collides: bool
    """False for paint, panes of colour and other skins that touch nothing."""
    vertices_m: tuple[Vector3, ...] = ()
    """Vertices of a mesh, in its local frame; empty otherwise."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A primitive in the frame of its object; the fields are as in `Primitive`."""

    kind: PrimitiveKind
    position_m: Vector3
    quat_wxyz: Quaternion = IDENTITY
    size_m: Vector3
    material: str
    collides: bool = True
    vertices_m: tuple[Vector3, ...] = ()


def block(x: Span, y: Span, z: Span, material: str, *, collides: bool = True) -> Part:
    """A box along the axes, from its intervals in m."""
    return _inscribed("box", (x, y, z), material, collides=collides)


def centred_block(
    centre_m: Vector3, size_m: Vector3, material: str, *, collides: bool = True
) -> Part:
    """A box along the axes, from its centre and full extents, m."""
    return Part(
        kind="box", position_m=centre_m, size_m=size_m, material=material, collides=collides
    )


def cylinder(
    centre_m: Vector3,
    diameter_m: float,
    length_m: float,
    material: str,
    *,
    axis: Axis = "z",
    collides: bool = True,
) -> Part:
    """A cylinder along one of the axes; diameter and length in m."""
    return Part(
        kind="cylinder",
        position_m=centre_m,
        quat_wxyz=_QUAT_Z_TO[axis],
        size_m=(diameter_m, diameter_m, length_m),
        material=material,
        collides=collides,
    )


def ellipsoid(x: Span, y: Span, z: Span, material: str) -> Part:
    """The ellipsoid inscribed in the box of three intervals, in m."""
    return _inscribed("ellipsoid", (x, y, z), material)


def _inscribed(
    kind: PrimitiveKind, spans: tuple[Span, Span, Span], material: str, *, collides: bool = True
) -> Part:
    x, y, z = (span if isinstance(span, tuple) else centred(span) for span in spans)
    return Part(
        kind=kind,
        position_m=((x[0] + x[1]) / 2, (y[0] + y[1]) / 2, (z[0] + z[1]) / 2),
        size_m=(x[1] - x[0], y[1] - y[0], z[1] - z[0]),
        material=material,
        collides=collides,
    )


def hull(vertices_m: list[Vector3], material: str, *, collides: bool = True) -> Part:
    """The convex hull of some points, in m.

    Args:
        vertices_m: At least four points that do not lie in one plane, in the object's frame. Points
            inside the hull do no harm.
        material: Name of the material.
        collides: False for decor.
    """
    low = tuple(min(v[i] for v in vertices_m) for i in range(3))
    high = tuple(max(v[i] for v in vertices_m) for i in range(3))
    # Vertices are kept about the centre of their bounding box, which becomes the part's position.
    centre = ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2)
    return Part(
        kind="mesh",
        position_m=centre,
        size_m=(high[0] - low[0], high[1] - low[1], high[2] - low[2]),
        material=material,
        collides=collides,
        vertices_m=tuple(
            (v[0] - centre[0], v[1] - centre[1], v[2] - centre[2]) for v in vertices_m
        ),
    )


def centred(length_m: float) -> Interval:
    """The interval of a length about zero."""
    return (-length_m / 2, length_m / 2)
