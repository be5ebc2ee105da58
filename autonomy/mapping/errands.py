"""Errands: flights to a place from which unseen cells on the path to a goal can be seen.

The camera looks ahead and down, so that a path that goes up, around a corner or back leads into
space that it will never show from where the vehicle is. The vehicle then flies to the place from
which it sees most for the time that takes, turns to face the cells, and nods if they are above its
view. Cells that stay unknown although it looked at them are given up: the map takes them for
occupied. So every errand ends, and the search for a path tries another one.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from jaxtyping import Int

from autonomy.mapping.agenda import Errand
from autonomy.mapping.distances import slices
from autonomy.mapping.gestures import NOD_RAD, nod, turn
from autonomy.mapping.rays import FREE_AT, OCCUPIED_AT
from autonomy.mapping.seen_map import SeenMap
from autonomy.mapping.task import Task, in_words
from autonomy.mapping.views import Sight, best_viewpoint, visible
from autonomy.planning.errors import PlanningError
from autonomy.planning.trajectory import Trajectory

LOOK_IMAGES = 4
"""Number of images of the camera ahead after which cells that are still unknown are given up."""
MOST_NODS = 2
"""Number of nods of one errand: one sets out backwards, the other forwards."""
_SEARCHED_M = 14.0
"""Greatest distance of a place to look from along each axis."""
_AHEAD_CELLS = 8
"""Number of further cells of the path that the same look should show."""
_LEAST_WEIGHT = 0.2
"""Least worth of seeing a further cell, where the next one is worth 1."""
_FACING_RAD = math.radians(8.0)
"""Heading error below which the vehicle counts as facing the cells."""
_EDGE_RAD = math.radians(3.0)
"""Margin at the edge of the image: cells that appear within it are not counted on."""
_PAUSE_M = 8.0
"""Distance that could be flown in the time of a look, which is the price of stopping at all."""


def set_out(task: Task, ahead: Int[np.ndarray, "n 3"]) -> None:
    """Choose a place from which to see the unknown about the first cells of a path, or give up.

    Args:
        task: Vehicle and map; the agenda receives the errand.
        ahead: Cells of the path from the first one that lacks room on.

    Raises:
        PlanningError: If the vehicle still moves.
    """
    seen = task.seen
    _require_rest(task)
    needed = _unknown_about(task, ahead[:1])
    # Nothing unknown is near, so the room is lacking for good: the next search passes elsewhere.
    if len(needed) == 0:
        seen.give_up(ahead[:1])
        return
    further = _without(_unknown_about(task, ahead[1 : 1 + _AHEAD_CELLS]), needed)
    targets = np.concatenate([needed, further])
    weights = np.ones(len(targets))
    # Cells farther along the path are worth less, because the path may change before them.
    away = np.linalg.norm(further - ahead[0], axis=1)
    weights[len(needed) :] = np.maximum(1.0 - away / (2 * _AHEAD_CELLS), _LEAST_WEIGHT)
    block = seen.block_about(task.start_cell[None], _SEARCHED_M)
    part = np.ascontiguousarray(seen.evidence[slices(block)])
    back = best_viewpoint(
        seen.field_in(block).distance_m,
        task.start_cell - block[0],
        task.needed_m,
        targets - block[0],
        weights,
        len(needed),
        part,
        _sight(seen, NOD_RAD),
        _PAUSE_M / seen.cfg.resolution_m,
    )
    if len(back) == 0:
        seen.give_up(needed)
        return
    # The way back begins at the place to look from.
    place = back[0].astype(float)
    is_visible = visible(place, needed - block[0], part, _sight(seen, NOD_RAD))
    shown = needed[is_visible]
    wanted = targets[visible(place, targets - block[0], part, _sight(seen, NOD_RAD))]
    is_level = visible(place, wanted - block[0], part, _sight(seen, 0.0))
    task.agenda.errand = Errand(
        path=back[::-1] + block[0], targets=shown, needs_nod=not bool(is_level.all())
    )


def pursue(task: Task, errand: Errand) -> Trajectory | None:
    """Plan the next part of an errand: the flight to its place, a turn, or a nod.

    Returns:
        The plan; None if the errand is over, because its cells were seen or given up.

    Raises:
        PlanningError: If the vehicle still moves: its present plan leads there.
    """
    seen = task.seen
    evidence = seen.evidence[tuple(errand.targets.T)]
    targets = errand.targets[(evidence > FREE_AT) & (evidence < OCCUPIED_AT)]
    place = task.point(errand.path[-1])
    # A nod that was planned is flown even if the cells came into view on the way to its place:
    # more is to be seen higher up.
    is_there = task.away_m(place) < 2 * seen.cfg.resolution_m
    if len(targets) == 0 and not (is_there and errand.needs_nod and not errand.nods):
        task.agenda.errand = None
        return None
    _require_rest(task)
    if len(errand.path) > 1 and task.away_m(place) > 1.5 * seen.cfg.resolution_m:
        try:
            return task.fly(np.concatenate([task.start_cell[None], errand.path]), place)
        except PlanningError:
            return _give_up(task, targets)
    way = seen.centres(errand.targets).mean(axis=0) - task.start.position_enu_m
    to_turn = math.remainder(math.atan2(way[1], way[0]) - task.start.yaw_rad, math.tau)
    # After a nod the heading is right, and another turn would only delay the second nod.
    if abs(to_turn) > _FACING_RAD and not errand.nods:
        return turn(task, to_turn)
    return _look(task, errand, targets)


def _look(task: Task, errand: Errand, targets: np.ndarray) -> Trajectory | None:
    """Stay or nod until the images show the cells, or it is clear that they will not.

    Returns:
        The next nod or stay; None once the cells are given up.
    """
    seen = task.seen
    if errand.needs_nod and errand.nods < MOST_NODS:
        is_first = errand.nods % 2 == 0
        at_place = dataclasses.replace(errand, path=errand.path[-1:], nods=errand.nods + 1)
        try:
            gesture = nod(task, backwards_first=is_first)
        except PlanningError:
            # There is no room for a nod, so the level view has to do.
            task.agenda.errand = dataclasses.replace(at_place, needs_nod=False)
        else:
            task.agenda.errand = at_place
            return gesture
    errand = errand if task.agenda.errand is None else task.agenda.errand
    since = seen.n_looks if errand.facing_since is None else errand.facing_since
    if errand.needs_nod or seen.n_looks - since >= LOOK_IMAGES:
        return _give_up(task, targets)
    task.agenda.errand = dataclasses.replace(errand, facing_since=since)
    # A turn by nothing keeps the vehicle where it is while images come in.
    return turn(task, 0.0)


def _give_up(task: Task, targets: np.ndarray) -> None:
    task.agenda.errand = None
    if len(targets):
        task.seen.give_up(targets)


def _require_rest(task: Task) -> None:
    if task.is_moving:
        raise PlanningError(
            f"still moving at {in_words(task.start.position_enu_m)}, from where to look around; "
            "valid: fly the plan to its end and plan again"
        )


def _unknown_about(task: Task, cells: Int[np.ndarray, "n 3"]) -> Int[np.ndarray, "k 3"]:
    """Return the unseen cells that are nearer to the given ones than the vehicle needs.

    These are the cells that must turn out to be free before the vehicle can pass.
    """
    if len(cells) == 0:
        return np.zeros((0, 3), dtype=np.int64)
    seen = task.seen
    block = seen.block_about(cells, task.needed_m)
    part = seen.evidence[slices(block)]
    unknown = np.argwhere((part > FREE_AT) & (part < OCCUPIED_AT)) + block[0]
    # Distances are from the centre of a cell to the surface of the other one.
    away = np.maximum(np.abs(unknown[:, None] - cells[None]) - 0.5, 0.0)
    nearest_m = np.linalg.norm(away, axis=2).min(axis=1) * seen.cfg.resolution_m
    return unknown[nearest_m < task.needed_m]


def _without(cells: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return the cells that are not among the others."""
    # A few hundred cells at most, for which a set of tuples is quick enough.
    known = set(map(tuple, others.tolist()))
    return cells[[tuple(cell) not in known for cell in cells.tolist()]].reshape(-1, 3)


def _sight(seen: SeenMap, tilt_rad: float) -> Sight:
    """Return the view of the camera while the vehicle turns all round.

    Args:
        seen: Map, whose settings have the camera's pitch and field of view.
        tilt_rad: Angle by which a nod tilts the camera upwards besides.
    """
    cfg = seen.cfg
    half = cfg.camera_vertical_fov_rad / 2 - _EDGE_RAD
    # A margin of a metre, because a place counts as reached from two cells away, see `pursue`.
    most = (cfg.max_range_m - 1.0) / cfg.resolution_m
    return Sight(
        least_rise=math.tan(-cfg.camera_pitch_down_rad - half),
        most_rise=math.tan(-cfg.camera_pitch_down_rad + half + tilt_rad),
        least_length=1.5,
        most_length=most,
    )
