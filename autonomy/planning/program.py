"""The quadratic program of a corridor at fixed times, as CasADi functions for each size.

The problem has one form for any corridor, so its code is generated once for each number of pieces
and planes, and then solved for many corridors.

    unknowns     node states between start and goal, dimensionless; a slack s_k >= 0 each piece
    position     control points of piece k in polytope k, whose planes may move     (hard)
    velocity     control points within the speed limits, times 1 + s_k              (exact penalty)
    acceleration control points within the limits, times share_k (1 + s_k)          (exact penalty)

minimise  sum_k  int |jerk|^2 dt / jerk_weight  +  T_k  +  T_k (PRICE s_k + SQUARE_PRICE s_k^2)

The linear price exceeds the worth of any limit where times are well chosen, so there the slack is
exactly zero; the square keeps the optimum smooth in the times. A plane n.x <= d + r t moves with
the obstacle that it keeps away: its offset at control point j of a piece is the one at j fifths of
the piece, and the curve stays behind it at all times in between.

Node states are made dimensionless by the times beside them, (p, v tau, a tau^2) with tau the
geometric mean: in plain SI units the QP is too badly scaled for any solver in CasADi's wheel.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from autonomy.planning.bezier import control_points, integral_of_square

PRICE = 4.0
"""Price of exceeding a limit by its whole value, seconds for each second of flight."""
SQUARE_PRICE = 20.0
JERK_WEIGHT_M2PS5 = 40.0
"""Integral of squared jerk that is worth one second."""
OCTAGON = math.cos(math.pi / 8)
"""Distance from the middle to the sides of an octagon inside the unit circle."""
PLANES = (8, 12, 16, 24)
"""Sizes of polytopes that programs are built for."""
PIECES = (1, 2, 3, 4, 6, 8, 10, 12, 16, 20)
"""Numbers of pieces that programs are built for; above these, every number."""
REPLANNED = (6, 8, 10, 12)
"""Numbers of pieces that nearly all replans in flight have."""
# Normals of an octagon's sides: a circle's limit by eight linear rows.
_DIRECTIONS = [(math.cos(n * math.pi / 4), math.sin(n * math.pi / 4)) for n in range(8)]


@dataclass(frozen=True, kw_only=True, eq=False)
class Program:
    """CasADi's functions for one number of pieces and of planes."""

    solve: Any
    """Function from p, at fixed times, to x, f and the multipliers."""
    gradient: Any
    """Function from x, p and the multipliers to the gradient of the optimum by log T."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Symbols:
    """One corridor problem as CasADi expressions."""

    log_t: Any
    fixed: Any
    """Ends (18), planes (5 each), speed and acceleration bounds (4), share of each piece."""
    unknowns: Any
    slack: Any
    nodes: Any
    cost: Any
    rows: Any
    """Inequality constraints: rows that are at most zero."""


@functools.cache
def build(n_pieces: int, n_planes: int) -> Program:
    """Build the QP of a size, once in a process; takes 0.1 to 0.4 s.

    CasADi is imported here, because it takes long to load and a flight without a plan needs none.
    """
    import casadi as ca

    s = symbols(n_pieces, n_planes)
    parameters = ca.vertcat(s.log_t, s.fixed)
    multipliers = ca.SX.sym("multipliers", s.rows.shape[0])
    lagrangian = s.cost + ca.dot(multipliers, s.rows)
    return Program(
        solve=ca.qpsol(
            "corridor",
            "piqp",
            {"x": s.unknowns, "p": parameters, "f": s.cost, "g": s.rows},
            # Scaling the rows again and again costs more time than it saves iterations.
            {"error_on_fail": False, "piqp": {"preconditioner_iter": 1}},
        ),
        gradient=ca.Function(
            "gradient", [s.unknowns, parameters, multipliers], [ca.gradient(lagrangian, s.log_t)]
        ),
    )


def prepare(pieces: Iterable[int] = REPLANNED) -> None:
    """Build programs for some numbers of pieces, so that no replan waits for one; takes 3 s.

    Call it before a flight, for example while the vehicle gets ready.
    """
    for n_pieces in pieces:
        for n_planes in PLANES[1:]:
            build(n_pieces, n_planes)


def pieces_to_fill(lengths: Float[np.ndarray, " n"], least: int = 1) -> Int[np.ndarray, " n"]:
    """Return the number of parts of each piece, so that a program of the total size exists.

    The longest pieces are cut first. Lengths are in metres or seconds; there will be `least` pieces
    or more.
    """
    counts = np.ones(len(lengths), dtype=np.int64)
    wanted = max(least, len(lengths))
    for _ in range(next((size for size in PIECES if size >= wanted), wanted) - len(lengths)):
        counts[np.argmax(lengths / counts)] += 1
    return counts


def symbols(n_pieces: int, n_planes: int) -> Symbols:
    """Return cost and constraints of a corridor problem as expressions, times included."""
    import casadi as ca

    n = n_pieces
    log_t, ends = ca.SX.sym("log_t", n), ca.SX.sym("ends", 18)
    planes = ca.SX.sym("planes", 5 * n_planes * n)
    bounds, share = ca.SX.sym("bounds", 4), ca.SX.sym("share", n)
    inner, slack = ca.SX.sym("inner", 9 * (n - 1)), ca.SX.sym("slack", n)
    nodes = [(ends[:3], ends[3:6], ends[6:9])]
    for k in range(n - 1):
        tau = ca.exp((log_t[k] + log_t[k + 1]) / 2)
        y = inner[9 * k : 9 * k + 9]
        nodes.append((y[:3], y[3:6] / tau, y[6:] / tau**2))
    nodes.append((ends[9:12], ends[12:15], ends[15:]))
    cost, rows, since = ca.SX(0), [], ca.SX(0)
    for k in range(n):
        t = ca.exp(log_t[k])
        position, velocity, acceleration, jerk = control_points(nodes[k], nodes[k + 1], t)
        cost += integral_of_square(jerk, t) / JERK_WEIGHT_M2PS5 + t
        cost += t * (PRICE * slack[k] + SQUARE_PRICE * slack[k] ** 2)
        polytope = ca.reshape(planes[5 * n_planes * k : 5 * n_planes * (k + 1)], 5, n_planes)
        # Start and goal are given, so the program does not choose these two points.
        for j in range(1 if k == 0 else 0, 5 if k == n - 1 else 6):
            offset = polytope[3, :].T + polytope[4, :].T * (since + t * j / 5)
            rows.append(polytope[:3, :].T @ position[j] - offset)
        # A piece's first points of velocity and acceleration are the last ones of the piece before.
        rows += _within(ca.vertsplit, velocity[1:], bounds[0], bounds[1], slack[k])
        across, up = bounds[2] * share[k], bounds[3] * share[k]
        rows += _within(ca.vertsplit, acceleration[1:], across, up, slack[k])
        since += t
    return Symbols(
        log_t=log_t,
        fixed=ca.vertcat(ends, planes, bounds, share),
        unknowns=ca.vertcat(inner, slack),
        slack=slack,
        nodes=nodes,
        cost=cost,
        rows=ca.vertcat(*rows, -slack),
    )


def _within(split: Any, points: list[Any], across: Any, up: Any, slack: Any) -> list[Any]:
    """Return constraint rows for vectors within an octagonal prism."""
    rows = []
    for x, y, z in (split(point) for point in points):
        rows += [(c * x + s * y) / (across * OCTAGON) - 1 - slack for c, s in _DIRECTIONS]
        rows += [sign * z / up - 1 - slack for sign in (-1, 1)]
    return rows
