"""Distances to convex solids, and planes that separate from them, compiled.

Iterations for nearest points never end exactly, and a proof must not depend on where they stopped.
The point nearest to a convex solid gives a plane that touches the solid and has it on one side;
with the solid's support function as offset that is exact to the last bit, however the nearest point
was rounded. So "farther than r" is always true. From outside distances are exact, except that the
iteration for hulls stops, on the safe side, when it no longer matters.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from autonomy.jit import kernel

_NEWTON_STEPS = 30
_NEWTON_TOLERANCE = 1e-10
_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
# Far along a leg of 50 m the plane may be off by no more than a millimetre, and its normal turns
# with the place of the minimum.
_GOLDEN_STEPS = 44
_HULL_SWEEPS = 200
_HULL_TOLERANCE_M = 1e-7
_UNBOUNDED = 1e9  # half extent of an axis that plays no part, m
_CYLINDER, _ELLIPSOID, _HULL = 1, 2, 3  # as in `Shape`; kernels see plain numbers

Point = Float[np.ndarray, " 3"]
Plane = tuple[float, float, float, float, float]
"""Distance, unit normal (3) and offset of a plane."""


class Solids(NamedTuple):
    """Arrays of n solids for kernels."""

    centers: np.ndarray
    """Centres (n, 3), ENU, m."""
    rotations: np.ndarray
    """Rotation matrices (n, 3, 3), local to world."""
    halves: np.ndarray
    """Half extents (n, 3), local, m."""
    shapes: np.ndarray
    """Numbers of `Shape` (n,)."""
    faces: np.ndarray
    """Faces of all hulls (m, 4): outward unit normal and offset, local."""
    faces_end: np.ndarray
    """Index one past the last face of each solid (n,)."""


@kernel
def distances_to_solids(
    points: Float[np.ndarray, "k 3"], solids: Solids
) -> tuple[Float[np.ndarray, " k"], Int[np.ndarray, " k"]]:
    """Signed distance from each point to the nearest solid, and its index."""
    distance = np.full(len(points), np.inf)
    nearest = np.full(len(points), -1)
    for k in range(len(points)):
        distance[k], nearest[k] = nearest_solid(points[k, 0], points[k, 1], points[k, 2], solids)
    return distance, nearest


@kernel
def nearest_solid(x: float, y: float, z: float, solids: Solids) -> tuple[float, int]:
    """Signed distance from a point to the nearest solid, and its index; infinite and -1 if none."""
    distance, nearest = np.inf, -1
    for i in range(len(solids.centers)):
        if gap_to_sphere(x, y, z, i, solids) >= distance:
            continue
        d = plane_between(x, y, z, i, solids)[0]
        if d < distance:
            distance, nearest = d, i
    return distance, nearest


@kernel
def gap_to_sphere(x: float, y: float, z: float, i: int, solids: Solids) -> float:
    """Distance from a point to the sphere about solid i, m: a quick lower bound.

    It is negative inside the sphere.
    """
    c, h = solids.centers[i], solids.halves[i]
    away = math.sqrt((x - c[0]) ** 2 + (y - c[1]) ** 2 + (z - c[2]) ** 2)
    return away - math.sqrt(h[0] ** 2 + h[1] ** 2 + h[2] ** 2)


@kernel
def sphere_to_segment(p: Point, q: Point, i: int, solids: Solids) -> float:
    """Distance from the segment from p to q to the sphere about solid i: a quick lower bound."""
    c, h = solids.centers[i], solids.halves[i]
    x, y, z = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    u, v, w = c[0] - p[0], c[1] - p[1], c[2] - p[2]
    square = x * x + y * y + z * z
    share = 0.0
    if square > 0.0:
        share = min(max((u * x + v * y + w * z) / square, 0.0), 1.0)
    away = math.sqrt((u - share * x) ** 2 + (v - share * y) ** 2 + (w - share * z) ** 2)
    return away - math.sqrt(h[0] ** 2 + h[1] ** 2 + h[2] ** 2)


@kernel
def plane_between(x: float, y: float, z: float, i: int, solids: Solids) -> Plane:
    """Signed distance of a point to solid i, and the plane that touches the solid below it.

    Returns:
        Distance, unit normal (3) and offset d, ENU: the solid lies in n.x <= d, and for a point
            outside n.point - d is the distance.
    """
    centers, rotations, halves, shapes, faces, faces_end = solids
    r = rotations[i]
    dx, dy, dz = x - centers[i, 0], y - centers[i, 1], z - centers[i, 2]
    u = r[0, 0] * dx + r[1, 0] * dy + r[2, 0] * dz
    v = r[0, 1] * dx + r[1, 1] * dy + r[2, 1] * dz
    w = r[0, 2] * dx + r[1, 2] * dy + r[2, 2] * dz
    a, b, c = halves[i, 0], halves[i, 1], halves[i, 2]
    if shapes[i] == _CYLINDER:
        d, n, m, o, touch = _cylinder(u, v, w, a, c)
    elif shapes[i] == _ELLIPSOID:
        d, n, m, o, touch = _ellipsoid(u, v, w, a, b, c)
    elif shapes[i] == _HULL:
        d, n, m, o, touch = _hull(u, v, w, faces[(faces_end[i - 1] if i else 0) : faces_end[i]])
    else:
        d, n, m, o, touch = _box(u, v, w, a, b, c)
    nx = r[0, 0] * n + r[0, 1] * m + r[0, 2] * o
    ny = r[1, 0] * n + r[1, 1] * m + r[1, 2] * o
    nz = r[2, 0] * n + r[2, 1] * m + r[2, 2] * o
    return d, nx, ny, nz, touch + nx * centers[i, 0] + ny * centers[i, 1] + nz * centers[i, 2]


@kernel
def support(nx: float, ny: float, nz: float, i: int, solids: Solids) -> float:
    """Largest n.x of all points of solid i; for a hull that of its bounding box, an upper bound.

    The normal n need not be a unit vector.
    """
    centers, rotations, halves, shapes, _, _ = solids
    r = rotations[i]
    n = r[0, 0] * nx + r[1, 0] * ny + r[2, 0] * nz
    m = r[0, 1] * nx + r[1, 1] * ny + r[2, 1] * nz
    o = r[0, 2] * nx + r[1, 2] * ny + r[2, 2] * nz
    a, b, c = halves[i, 0], halves[i, 1], halves[i, 2]
    if shapes[i] == _CYLINDER:
        extent = a * math.sqrt(n * n + m * m) + c * abs(o)
    elif shapes[i] == _ELLIPSOID:
        extent = math.sqrt((a * n) ** 2 + (b * m) ** 2 + (c * o) ** 2)
    else:
        extent = a * abs(n) + b * abs(m) + c * abs(o)
    return extent + nx * centers[i, 0] + ny * centers[i, 1] + nz * centers[i, 2]


@kernel
def plane_to_segment(p: Point, q: Point, i: int, solids: Solids) -> Plane:
    """Like `plane_between`, for the point of the segment from p to q that is nearest to solid i.

    The distance along the segment is convex, so golden section finds its minimum; the two ends are
    tried as well.
    """
    low, high = 0.0, 1.0
    s, t = 1.0 - _GOLDEN, _GOLDEN
    at_s, at_t = _from_segment(p, q, s, i, solids), _from_segment(p, q, t, i, solids)
    for _ in range(_GOLDEN_STEPS):
        if at_s[0] < at_t[0]:
            high, t, at_t = t, s, at_s
            s = high - _GOLDEN * (high - low)
            at_s = _from_segment(p, q, s, i, solids)
        else:
            low, s, at_s = s, t, at_t
            t = low + _GOLDEN * (high - low)
            at_t = _from_segment(p, q, t, i, solids)
    nearest = at_s if at_s[0] < at_t[0] else at_t
    for end in (0.0, 1.0):
        at_end = _from_segment(p, q, end, i, solids)
        if at_end[0] <= nearest[0]:
            nearest = at_end
    return nearest


@kernel
def _from_segment(p: Point, q: Point, s: float, i: int, solids: Solids) -> Plane:
    x, y, z = p[0] + s * (q[0] - p[0]), p[1] + s * (q[1] - p[1]), p[2] + s * (q[2] - p[2])
    return plane_between(x, y, z, i, solids)


@kernel
def _box(x: float, y: float, z: float, a: float, b: float, c: float) -> Plane:
    u, v, w = abs(x) - a, abs(y) - b, abs(z) - c
    inside = max(u, v, w)
    if inside > 0.0:
        n, m, o = max(u, 0.0), max(v, 0.0), max(w, 0.0)
    else:
        n = 1.0 if u == inside else 0.0
        m = 1.0 if v == inside else 0.0
        o = 1.0 if w == inside else 0.0
    length = math.sqrt(n * n + m * m + o * o)
    n, m, o = n / length, m / length, o / length
    # Inside, the nearest face decides: the least penetration, negative.
    distance = length if inside > 0.0 else inside
    touch = n * a + m * b + o * c
    n, m, o = n if x >= 0.0 else -n, m if y >= 0.0 else -m, o if z >= 0.0 else -o
    return distance, n, m, o, touch


@kernel
def _cylinder(x: float, y: float, z: float, radius: float, half_length: float) -> Plane:
    across = math.sqrt(x * x + y * y)
    # A cylinder is a box in the plane of its axis and the point.
    d, n, o, _, touch = _box(across, z, 0.0, radius, half_length, _UNBOUNDED)
    if across > 0.0:
        return d, n * x / across, n * y / across, o, touch
    return d, n, 0.0, o, touch


@kernel
def _ellipsoid(x: float, y: float, z: float, a: float, b: float, c: float) -> Plane:
    """Find the Lagrange multiplier by Newton's method, from the left of the root.

    The nearest point is (a^2 x / (a^2 + t), ...), where f(t) = sum (a x / (a^2 + t))^2 - 1 = 0; f
    is convex and falls, so the iteration never passes the root. Inside, where the deepest point is
    not unique, the smallest semi-axis times (gauge - 1) is a safe bound.
    """
    gauge = math.sqrt((x / a) ** 2 + (y / b) ** 2 + (z / c) ** 2)
    shortest = min(a, b, c)
    t = max(gauge - 1.0, 0.0) * shortest**2
    for _ in range(_NEWTON_STEPS if gauge > 1.0 else 0):
        p, q, r = a * x / (a * a + t), b * y / (b * b + t), c * z / (c * c + t)
        value = p * p + q * q + r * r - 1.0
        if value < _NEWTON_TOLERANCE:
            break
        slope = p * p / (a * a + t) + q * q / (b * b + t) + r * r / (c * c + t)
        t += value / (2.0 * slope)
    n, m, o = x / (a * a + t), y / (b * b + t), z / (c * c + t)
    length = math.sqrt(n * n + m * m + o * o)
    if length == 0.0:
        return -shortest, 0.0, 0.0, 1.0, c
    distance = t * length if gauge > 1.0 else (gauge - 1.0) * shortest
    n, m, o = n / length, m / length, o / length
    return distance, n, m, o, math.sqrt((a * n) ** 2 + (b * m) ** 2 + (c * o) ** 2)


@kernel
def _hull(x: float, y: float, z: float, faces: Float[np.ndarray, "m 4"]) -> Plane:
    """Project on an intersection of half-spaces n.p <= d by Hildreth's dual coordinate ascent.

    The nearest point is (x, y, z) - sum l_j n_j with multipliers l >= 0, and any such l gives a
    plane that the hull is below: (sum l_j n_j).p <= sum l_j d_j. So the distance to it never is too
    large, at whatever step the iteration ends.
    """
    deepest, best = -np.inf, 0
    for j in range(len(faces)):
        f = faces[j]
        beyond = f[0] * x + f[1] * y + f[2] * z - f[3]
        if beyond > deepest:
            deepest, best = beyond, j
    f = faces[best]
    if deepest <= 0.0:
        return deepest, f[0], f[1], f[2], f[3]
    n, m, o, touch = deepest * f[0], deepest * f[1], deepest * f[2], deepest * f[3]
    multipliers = np.zeros(len(faces))
    multipliers[best] = deepest
    for _ in range(_HULL_SWEEPS):
        change = 0.0
        for j in range(len(faces)):
            f = faces[j]
            beyond = f[0] * (x - n) + f[1] * (y - m) + f[2] * (z - o) - f[3]
            step = max(beyond, -multipliers[j])
            multipliers[j] += step
            n, m, o = n + step * f[0], m + step * f[1], o + step * f[2]
            touch += step * f[3]
            change = max(change, abs(step))
        if change < _HULL_TOLERANCE_M:
            break
    length = math.sqrt(n * n + m * m + o * o)
    n, m, o, touch = n / length, m / length, o / length, touch / length
    return n * x + m * y + o * z - touch, n, m, o, touch
