"""From a path of cells to a safe corridor: few straight legs, a convex polytope about each.

The optimiser needs convex free space, because its constraints are planes. The corridor knows the
obstacles exactly, not as cells. For a leg and an obstacle, both convex, the plane that touches the
obstacle nearest to the leg separates them. Moved towards the leg by the vehicle's radius and a
margin, it bounds where the centre of the vehicle may be. Obstacles that lie wholly beyond planes
already there need none of their own, so a dozen planes usually do.

Source: separating planes about a path as in Liu et al. 2017 (safe flight corridors), taken here
from the solids themselves.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float, Int

from autonomy.jit import kernel
from autonomy.planning.errors import CertificateError
from autonomy.planning.obstacles import Obstacles
from autonomy.planning.solids import (
    Point,
    Solids,
    gap_to_sphere,
    plane_to_segment,
    sphere_to_segment,
    support,
)

MAX_PLANES = 20  # six of them are the box's sides
REACHES_M = (6.0, 3.0, 1.5, 0.75)
"""Reaches of a polytope beyond its leg along each axis. The first that needs few planes is used."""
_SLACK_M = 1e-6  # against rounding: touching counts as inside
_PARALLEL = 1e-10
"""Determinant of three planes' normals below which they share no corner."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Corridor:
    """Polytopes in flight order; neighbours share the gate between them."""

    planes: Float[np.ndarray, "n planes 4"]
    """Unit normal n and offset d of each plane: n.x <= d inside. Unused planes are (0, 0, 0, 1)."""
    gates_enu_m: Float[np.ndarray, "n_plus_1 3"]
    """Start, a point in each overlap, goal."""
    moving_mps: Float[np.ndarray, "n planes"] | None = None
    """Growth of the offsets from time 0 on, for planes against moving obstacles; None without
    any."""

    @property
    def rates_mps(self) -> Float[np.ndarray, "n planes"]:
        """`moving_mps`, or zeros without moving obstacles."""
        return np.zeros(self.planes.shape[:2]) if self.moving_mps is None else self.moving_mps

    def __len__(self) -> int:
        return len(self.planes)


def straighten(
    points_enu_m: Float[np.ndarray, "n 3"], obstacles: Obstacles, *, enough_m: float
) -> Float[np.ndarray, "m 3"]:
    """Drop points of a path wherever the straight line costs no clearance.

    A line may replace a part if it keeps at least that part's smallest distance. Distances beyond
    `enough_m` do not count.
    """
    points = np.ascontiguousarray(points_enu_m, dtype=float)
    room_m = np.minimum(obstacles.signed_distance(points)[0], enough_m)
    return points[thin_out(points, room_m, obstacles.solids)]


def build_corridor(
    legs_enu_m: Float[np.ndarray, "n_plus_1 3"],
    obstacles: Obstacles,
    bounds_enu_m: tuple[np.ndarray, np.ndarray],
    *,
    wanted_m: float,
    least_m: float,
    max_leg_m: float,
) -> Corridor:
    """Build polytopes about the legs of a polyline.

    Args:
        legs_enu_m: Vertices of the polyline, start first.
        obstacles: Obstacles to stay away from.
        bounds_enu_m: Lower and upper corner of the volume in which flight is allowed.
        wanted_m: Distance to keep from the centre of the vehicle to obstacles.
        least_m: Distance to keep on a leg that offers less than `wanted_m`. Half of what the leg
            offers beyond this is kept; the other half is freedom for the optimiser.
        max_leg_m: Length above which a leg gets its polytope several times, once for each piece to
            fly.

    Raises:
        CertificateError: If a leg comes closer to an obstacle than `least_m`.
    """
    planes, gates = [], [legs_enu_m[:1]]
    for a, b in pairwise(legs_enu_m):
        offered_m = float(segment_clearance(a, b, wanted_m * 2, obstacles.solids))
        if offered_m <= least_m:
            raise CertificateError(
                f"the leg from ({a[0]:.1f}, {a[1]:.1f}, {a[2]:.1f}) to "
                f"({b[0]:.1f}, {b[1]:.1f}, {b[2]:.1f}) m passes {offered_m:.2f} m from an "
                f"obstacle; valid: more than {least_m:.2f} m"
            )
        kept_m = min(wanted_m, (offered_m + least_m) / 2)
        polytope = _polytope(a, b, kept_m, bounds_enu_m, obstacles)
        n = max(1, int(np.ceil(np.linalg.norm(b - a) / max_leg_m)))
        planes += [polytope] * n
        gates.append(a + (b - a) * np.arange(1, n + 1)[:, None] / n)
    return Corridor(planes=np.array(planes), gates_enu_m=np.concatenate(gates))


def refine(corridor: Corridor, counts: Int[np.ndarray, " n"]) -> Corridor:
    """Return a corridor of the same free space with each piece cut into `counts` parts."""
    gates = [corridor.gates_enu_m[:1]]
    for (a, b), count in zip(pairwise(corridor.gates_enu_m), counts.tolist(), strict=True):
        gates.append(a + (b - a) * np.arange(1, count + 1)[:, None] / count)
    return Corridor(
        planes=np.repeat(corridor.planes, counts, axis=0), gates_enu_m=np.concatenate(gates)
    )


def _polytope(
    a: np.ndarray,
    b: np.ndarray,
    kept_m: float,
    bounds_enu_m: tuple[np.ndarray, np.ndarray],
    obstacles: Obstacles,
) -> np.ndarray:
    leg_low, leg_high = np.minimum(a, b), np.maximum(a, b)
    for reach_m in REACHES_M:
        # The leg itself is always inside, whatever the bounds.
        low = np.minimum(np.maximum(leg_low - reach_m, bounds_enu_m[0]), leg_low - 0.05)
        high = np.maximum(np.minimum(leg_high + reach_m, bounds_enu_m[1]), leg_high + 0.05)
        planes, is_complete = polytope_about(a, b, kept_m, low, high, obstacles.solids)
        if is_complete:
            return planes
    raise CertificateError(
        f"more than {MAX_PLANES - 6} obstacles crowd the leg to ({b[0]:.1f}, {b[1]:.1f}, "
        f"{b[2]:.1f}) m; valid: a way through less clutter"
    )


@kernel
def segment_clearance(p: Point, q: Point, enough: float, solids: Solids) -> float:
    """Distance from a segment to the nearest solid, at most `enough`.

    Solids whose bounding sphere is farther than the best so far are skipped.
    """
    clearance = enough
    for i in range(len(solids.centers)):
        if sphere_to_segment(p, q, i, solids) - _SLACK_M < clearance:
            clearance = min(clearance, plane_to_segment(p, q, i, solids)[0])
    return clearance


@kernel
def thin_out(
    points: Float[np.ndarray, "n 3"], room: Float[np.ndarray, " n"], solids: Solids
) -> Int[np.ndarray, " m"]:
    """Keep few points: jump from each to the farthest (by bisection) seen with no less room."""
    kept = [0]
    while kept[-1] < len(points) - 1:
        at = kept[-1]
        reach, beyond = at + 1, len(points)
        while beyond - reach > 1:
            to = (reach + beyond) // 2
            needed = room[at : to + 1].min() - _SLACK_M
            if segment_clearance(points[at], points[to], needed, solids) >= needed:
                reach = to
            else:
                beyond = to
        kept.append(reach)
    return np.array(kept)


@kernel
def polytope_about(
    p: Point, q: Point, kept: float, low: Point, high: Point, solids: Solids
) -> tuple[Float[np.ndarray, "planes 4"], bool]:
    """Build planes about the segment from p to q: a box, then one for each obstacle in the way.

    Returns:
        The planes, and whether all needed ones fit.
    """
    planes = np.zeros((MAX_PLANES, 4))
    planes[6:, 3] = 1.0
    for axis in range(3):
        planes[2 * axis, axis], planes[2 * axis, 3] = 1.0, high[axis]
        planes[2 * axis + 1, axis], planes[2 * axis + 1, 3] = -1.0, -low[axis]
    near, distance = _separating_planes(p, q, low, high, kept, solids)
    count = 6
    # Nearest first: near planes exclude many of the farther obstacles.
    for n in np.argsort(distance):
        if _is_beyond(int(near[n, 4]), planes[:count], kept, solids):
            continue
        if count == MAX_PLANES:
            return planes, False
        # The normal of the plane on the obstacle points at the vehicle; inside is n.x <= d.
        planes[count, :3] = -near[n, :3]
        planes[count, 3] = -near[n, 3] - kept
        count += 1
    return _without_idle(planes, count), True


@kernel
def _without_idle(
    planes: Float[np.ndarray, "planes 4"], count: int
) -> Float[np.ndarray, "planes 4"]:
    """Return a bounded polytope with the planes that have a corner of it, the others unused."""
    has_corner = np.zeros(count, dtype=np.bool_)
    for i in range(count):
        for j in range(i + 1, count):
            across = _cross(planes[i], planes[j])
            for k in range(j + 1, count):
                f = planes[k]
                det = across[0] * f[0] + across[1] * f[1] + across[2] * f[2]
                if abs(det) < _PARALLEL or (has_corner[i] and has_corner[j] and has_corner[k]):
                    continue
                corner = planes[i, 3] * _cross(planes[j], f) + planes[j, 3] * _cross(f, planes[i])
                corner = (corner + f[3] * across) / det
                if _is_inside(corner, planes[:count]):
                    has_corner[i], has_corner[j], has_corner[k] = True, True, True
    kept = np.zeros_like(planes)
    kept[:, 3] = 1.0
    n = 0
    for i in range(count):
        if has_corner[i]:
            kept[n] = planes[i]
            n += 1
    return kept


@kernel
def _cross(a: Float[np.ndarray, " 4"], b: Float[np.ndarray, " 4"]) -> Point:
    x, y = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2]
    return np.array([x, y, a[0] * b[1] - a[1] * b[0]])


@kernel
def _is_inside(point: Point, planes: Float[np.ndarray, "k 4"]) -> bool:
    for n in range(len(planes)):
        f = planes[n]
        if f[0] * point[0] + f[1] * point[1] + f[2] * point[2] > f[3] + _SLACK_M:
            return False
    return True


@kernel
def _separating_planes(
    p: Point, q: Point, low: Point, high: Point, kept: float, solids: Solids
) -> tuple[Float[np.ndarray, "k 5"], Float[np.ndarray, " k"]]:
    """Return plane (4) and index of each solid that may reach into a box, and its distance."""
    planes = np.empty((len(solids.centers), 5))
    distance = np.empty(len(solids.centers))
    count = 0
    middle = 0.5 * (low + high)
    half = 0.5 * np.sqrt(np.sum((high - low) ** 2))
    for i in range(len(solids.centers)):
        if gap_to_sphere(middle[0], middle[1], middle[2], i, solids) - half < kept:
            d, nx, ny, nz, offset = plane_to_segment(p, q, i, solids)
            planes[count] = np.array([nx, ny, nz, offset, float(i)])
            distance[count] = d
            count += 1
    return planes[:count], distance[:count]


@kernel
def _is_beyond(i: int, planes: Float[np.ndarray, "k 4"], kept: float, solids: Solids) -> bool:
    """Return whether one of the planes already keeps the vehicle away from all of solid i."""
    for n in range(len(planes)):
        f = planes[n]
        if -support(-f[0], -f[1], -f[2], i, solids) >= f[3] + kept - _SLACK_M:
            return True
    return False
