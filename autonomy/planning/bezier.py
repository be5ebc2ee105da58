"""Pieces of a trajectory as Bezier curves: a curve lies in the hull of its control points.

Bounds on a few control points therefore hold on the whole curve, between samples too. The functions
work on numpy arrays and CasADi expressions alike.
"""

from __future__ import annotations

import math
from typing import Any

Node = tuple[Any, Any, Any]
"""Position, velocity and acceleration at one end of a piece."""


def control_points(a: Node, b: Node, t: Any) -> list[list[Any]]:
    """Return the control points of position (6), velocity (5), acceleration (4) and jerk (3).

    The piece leads from a to b in t seconds, as a polynomial of degree 5.
    """
    p0, v0, a0 = a
    p1, v1, a1 = b
    points = [
        p0,
        p0 + v0 * t / 5,
        p0 + 2 * v0 * t / 5 + a0 * t**2 / 20,
        p1 - 2 * v1 * t / 5 + a1 * t**2 / 20,
        p1 - v1 * t / 5,
        p1,
    ]
    derivatives = [points]
    for degree in (5, 4, 3):
        last = derivatives[-1]
        derivatives.append([degree / t * (last[i + 1] - last[i]) for i in range(degree)])
    return derivatives


def integral_of_square(points: list[Any], t: Any) -> Any:
    """Integral over a piece of t seconds of the squared norm of a Bezier curve."""
    degree = len(points) - 1
    total = 0
    for i, a in enumerate(points):
        for j, b in enumerate(points):
            share = math.comb(degree, i) * math.comb(degree, j) / math.comb(2 * degree, i + j)
            total += share * (a.T @ b)
    return t * total / (2 * degree + 1)
