"""The iterations of `pushing.separate`, compiled: a scene costs a millisecond.

On tensors, an iteration is some fifty small operations, each of which costs more to call than to
do. Here pairs are gone through one by one, and only those that overlap are looked at closely.

Source: Müller et al. 2007, "Position Based Dynamics", section 3.3; masses, bounds and the choice of
direction are ours.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.jit import kernel

_VERTICAL = 4
"""Place of the vertical among the axes."""
_STUCK_COST = 100.0
"""Cost of a square metre of overlap that no push undoes; moving a unit mass a metre costs 1."""
_CHECK_EVERY = 5
"""Iterations between two looks, while some are patient, at whether all is done."""
_LEAST_SLOPE = 1e-3
"""Directions nearer to an axis than this do not move along the other one."""
_ENDLESS_M = 1e6
_LEAST_HELP = 0.7
"""Share of an overlap that a push must undo, or the pair is left alone."""


class Touching(NamedTuple):
    """Pairs, as `contacts.Pairs`, and where either one's parent meets the other among them."""

    token: Int[np.ndarray, "pairs 2"]
    axes: Float[np.ndarray, "pairs 5 3"]
    reach_m: Float[np.ndarray, "pairs 5"]
    offset_m: Float[np.ndarray, "pairs 3"]
    above: Int[np.ndarray, "pairs 2"]


class Freedom(NamedTuple):
    """Tokens, as `pushing.Movable`, of all scenes in one list, parents before children."""

    order: Int[np.ndarray, " n"]
    parent: Int[np.ndarray, " n"]
    """-1 where there is none."""
    heading: Float[np.ndarray, "n 2"]
    low_m: Float[np.ndarray, "n 3"]
    high_m: Float[np.ndarray, "n 3"]
    lightness: Float[np.ndarray, " n"]


@kernel
def iterate(
    touching: Touching, freedom: Freedom, tolerance_m: float, n_steps: int, n_patient_steps: int
) -> Float[np.ndarray, "n 3"]:
    """Displacements that undo overlaps, in the axes of the parents, m."""
    n_pairs = len(touching.token)
    moved = np.zeros_like(freedom.low_m)
    apart = np.zeros((n_pairs, 5))
    overlaps = np.zeros(n_pairs, dtype=np.bool_)
    busy = np.zeros(n_pairs + 1, dtype=np.bool_)
    waits = np.zeros(n_pairs, dtype=np.bool_)
    forth, back = np.zeros_like(moved), np.zeros_like(moved)
    for step in range(n_steps):
        is_patient = step < n_patient_steps
        _look(touching, _in_world(moved, freedom), tolerance_m, apart, overlaps)
        if is_patient:
            _wait(touching.above, overlaps, busy, waits)
        for pair in range(n_pairs):
            if overlaps[pair] and not (is_patient and waits[pair]):
                _part(pair, touching, apart[pair], freedom, moved, tolerance_m, forth, back)
        is_done = not _move(moved, forth, back, freedom)
        # What waits may go on later, though nothing is pushed now.
        if is_done and (not is_patient or step % _CHECK_EVERY == 0):
            break
    return moved


@kernel
def _move(
    moved: Float[np.ndarray, "n 3"],
    forth: Float[np.ndarray, "n 3"],
    back: Float[np.ndarray, "n 3"],
    freedom: Freedom,
) -> bool:
    """Add the pushes, within bounds, and forget them; whether there were any."""
    was_pushed = False
    for i in range(len(moved)):
        for axis in range(3):
            push = forth[i, axis] + back[i, axis]
            forth[i, axis], back[i, axis] = 0.0, 0.0
            if push != 0.0:
                was_pushed = True
                wanted = max(moved[i, axis] + push, freedom.low_m[i, axis])
                moved[i, axis] = min(wanted, freedom.high_m[i, axis])
    return was_pushed


@kernel
def _in_world(moved: Float[np.ndarray, "n 3"], freedom: Freedom) -> Float[np.ndarray, "n 3"]:
    """Displacements in the world, with those of all that a token stands on."""
    world = np.empty_like(moved)
    for i in freedom.order:
        c, s = freedom.heading[i]
        x, y, z = moved[i]
        world[i, 0], world[i, 1], world[i, 2] = c * x - s * y, s * x + c * y, z
        above = freedom.parent[i]
        if above >= 0:
            for axis in range(3):
                world[i, axis] += world[above, axis]
    return world


@kernel
def _look(
    touching: Touching,
    world: Float[np.ndarray, "n 3"],
    tolerance_m: float,
    apart: Float[np.ndarray, "pairs 5"],
    overlaps: Bool[np.ndarray, " pairs"],
) -> None:
    """How far the centres of all pairs are apart along their axes, and which pairs overlap."""
    for pair in range(len(overlaps)):
        first, second = touching.token[pair]
        x, y, z = touching.offset_m[pair]
        x += world[second, 0] - world[first, 0]
        y += world[second, 1] - world[first, 1]
        z += world[second, 2] - world[first, 2]
        overlaps[pair] = True
        for k in range(5):
            ax, ay, az = touching.axes[pair, k]
            apart[pair, k] = ax * x + ay * y + az * z
            if not touching.reach_m[pair, k] - abs(apart[pair, k]) > tolerance_m:
                overlaps[pair] = False
                break


@kernel
def _wait(
    above: Int[np.ndarray, "pairs 2"],
    overlaps: Bool[np.ndarray, " pairs"],
    busy: Bool[np.ndarray, " pairs_and_none"],
    waits: Bool[np.ndarray, " pairs"],
) -> None:
    """Which pairs wait for what their members stand on."""
    n_pairs = len(overlaps)
    for pair in range(n_pairs):
        busy[pair] = busy[pair] or overlaps[pair]
    for pair in range(n_pairs):
        waits[pair] = busy[above[pair, 0]] or busy[above[pair, 1]]
    for pair in range(n_pairs):
        busy[pair] = overlaps[pair] or waits[pair]


@kernel
def _part(
    pair: int,
    touching: Touching,
    apart: Float[np.ndarray, " 5"],
    freedom: Freedom,
    moved: Float[np.ndarray, "n 3"],
    tolerance_m: float,
    forth: Float[np.ndarray, "n 3"],
    back: Float[np.ndarray, "n 3"],
) -> None:
    """Push both of a pair along the direction that costs least; the greatest push either way."""
    first, second = touching.token[pair]
    light_first, light_second = freedom.lightness[first], freedom.lightness[second]
    share = light_first / (light_first + light_second)
    best, least, best_first, best_second, best_depth = 0, np.inf, 0.0, 0.0, 0.0
    for k in range(10):
        axis = k % 5
        sign = 1.0 if k < 5 else -1.0
        direction = touching.axes[pair, axis] * sign
        depth = touching.reach_m[pair, axis] - sign * apart[axis] - tolerance_m / 2
        room_first = _room(first, -direction, freedom, moved)
        room_second = _room(second, direction, freedom, moved)
        move_second = min(depth - min(depth * share, room_first), room_second)
        move_first = min(depth - move_second, room_first)
        stuck = depth - move_first - move_second
        cost = move_first**2 / light_first + move_second**2 / light_second
        cost += _STUCK_COST * stuck**2
        # Thin things overlap least in height: that is no way out where it is blocked.
        if axis == _VERTICAL and stuck > tolerance_m:
            cost = np.inf
        if cost < least:
            best, least = k, cost
            best_first, best_second, best_depth = move_first, move_second, depth
    # What no way helps stays: a room would be pushed out from under a slab that is too low.
    if best_first + best_second < _LEAST_HELP * best_depth:
        return
    direction = touching.axes[pair, best % 5] * (1.0 if best < 5 else -1.0)
    _note(first, -direction, best_first, freedom, forth, back)
    _note(second, direction, best_second, freedom, forth, back)


@kernel
def _room(
    token: int,
    direction: Float[np.ndarray, " 3"],
    freedom: Freedom,
    moved: Float[np.ndarray, "n 3"],
) -> float:
    """How far a token may go along a direction of the world until it is at a bound."""
    room = np.inf
    own = _in_parent(direction, freedom.heading[token])
    for axis in range(3):
        slope = abs(own[axis])
        if slope < _LEAST_SLOPE:
            along = _ENDLESS_M
        elif own[axis] > 0:
            along = (freedom.high_m[token, axis] - moved[token, axis]) / slope
        else:
            along = (moved[token, axis] - freedom.low_m[token, axis]) / slope
        room = min(room, along)
    return room


@kernel
def _in_parent(
    direction: Float[np.ndarray, " 3"], heading: Float[np.ndarray, " 2"]
) -> tuple[float, float, float]:
    x, y, z = direction
    c, s = heading
    return c * x + s * y, c * y - s * x, z


@kernel
def _note(
    token: int,
    direction: Float[np.ndarray, " 3"],
    move_m: float,
    freedom: Freedom,
    forth: Float[np.ndarray, "n 3"],
    back: Float[np.ndarray, "n 3"],
) -> None:
    """Keep the greatest push either way: many that push the same way do not add up."""
    own = _in_parent(direction, freedom.heading[token])
    for axis in range(3):
        forth[token, axis] = max(forth[token, axis], own[axis] * move_m)
        back[token, axis] = min(back[token, axis], own[axis] * move_m)
