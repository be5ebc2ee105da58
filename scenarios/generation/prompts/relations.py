"""Relations of things to hosts, each decided by boxes, as tables of things by hosts.

People's prepositions are vague, so each relation has one definition that can be measured on boxes
and outlines. Everything is vectorised over all pairs, because a scene has hundreds of objects and
each draw is judged.

| relation | holds if |
|---|---|
| on | the middle is over the host and the underside at its top, or the host bears it;
|    | of buildings: on_roof |
| on_roof | the middle is over the host and the underside at most 1 m below its top |
| over | the outlines overlap, and the top is at least half a metre higher |
| under | the middle is under the host, from below its top |
| inside | the middle and the height lie within the host; of ground: on it |
| next_to, near | at the same level, 3 m, 10 m apart at most, the middle outside |
| in_front_of, behind | off the front, the back, at most 15 m, and no farther aside than 2 m |
| facing | the host is within 20 m and 45 degrees of the thing's front |
| along | within 4 m of a host beside which others stand, 10 m or two thirds of it apart |
| around | within 5 m of a host, which has them on three sides at least |
| between | the middle lies in the hull of two hosts at most 30 m apart, and in neither |
"""

from __future__ import annotations

import numpy as np
import shapely
from jaxtyping import Bool, Float

from aeroscene.scene.catalogue import GROUND, SHELLS
from scenarios.generation.prompts.instances import Instances, is_borne_by
from scenarios.generation.prompts.wishes import RelationName

_WITHIN_M = {
    "next_to": 3.0,
    "near": 10.0,
    "in_front_of": 15.0,
    "behind": 15.0,
    "facing": 20.0,
    "along": 4.0,
    "around": 5.0,
}
_LEVEL_M = 0.5
"""Gap in height up to which things still count as being at one level: a kerb, a step."""
_ON_M = 0.6
"""Height by which an underside may miss the top that it stands on: water, slopes of roofs."""
_UNDER_M = 0.3
_ASIDE_M = 2.0  # beyond the host's own width, for "in front of" and "behind"
_SIDES = 3
"""Fewest sides, of four, on which things are around a host."""
_ROW_M = 10.0  # length of a row along a long host; a short one needs two thirds of its own
_BETWEEN_M = 30.0
_COS_FACING = np.cos(np.pi / 4)

_Table = Bool[np.ndarray, "n k"]


def holds(relation: RelationName, subjects: Instances, hosts: Instances) -> _Table:
    """Return a table that is true if a subject stands in a relation to a host.

    Nothing stands in a relation to itself, nor to a thing that shares an object with it.

    Args:
        relation: Any but `between`, which takes two hosts.
        subjects: Things, n of them.
        hosts: Things, k of them.
    """
    if not len(subjects) or not len(hosts):
        return np.zeros((len(subjects), len(hosts)), dtype=bool)
    table = _JUDGES[relation](subjects, hosts, _WITHIN_M.get(relation, 0.0))
    return table & ~_is_same(subjects, hosts)


def within(subjects: Instances, hosts: Instances, within_m: float) -> _Table:
    """Return a table that is true if a subject is near a host at its level, or beneath it.

    Args:
        subjects: Things, n of them.
        hosts: Things, k of them.
        within_m: Greatest distance between the outlines.
    """
    if not len(subjects) or not len(hosts):
        return np.zeros((len(subjects), len(hosts)), dtype=bool)
    return _is_near(subjects, hosts, within_m) & ~_is_same(subjects, hosts)


def between(subjects: Instances, hosts: Instances, others: Instances) -> Bool[np.ndarray, " n"]:
    """Return, for each subject, true if it is between a host and another one.

    Args:
        subjects: Things, n of them.
        hosts: Things that may be the first host.
        others: Things that may be the second host; the same as `hosts` for "between two houses".
    """
    found = np.zeros(len(subjects), dtype=bool)
    if not len(subjects):
        return found
    is_off = ~(_is_over(subjects, hosts) | _is_same(subjects, hosts))
    is_off_other = ~(_is_over(subjects, others) | _is_same(subjects, others))
    for i, rows in enumerate(hosts.rows):
        for j, other in enumerate(others.rows):
            outlines = (hosts.outline[i], others.outline[j])
            if rows == other or shapely.distance(*outlines) > _BETWEEN_M:
                continue
            hull = shapely.convex_hull(shapely.union_all(outlines))
            found |= is_off[:, i] & is_off_other[:, j] & shapely.covers(hull, subjects.centre)
    return found


def _on(subjects: Instances, hosts: Instances, _within_m: float) -> _Table:
    at_top = np.abs(subjects.base_m[:, None] - hosts.level_m) <= _ON_M
    is_on = _is_over(subjects, hosts) & (at_top | is_borne_by(subjects, hosts))
    # "On" a building means on its roof. Its children do not count, since they may be its rooms.
    return np.where(_is_of(hosts, SHELLS), _on_roof(subjects, hosts, 0.0), is_on)


def _over(subjects: Instances, hosts: Instances, _within_m: float) -> _Table:
    overlap = shapely.intersects(subjects.outline[:, None], hosts.outline[None])
    return overlap & (subjects.top_m[:, None] >= hosts.top_m + _LEVEL_M)


def _on_roof(subjects: Instances, hosts: Instances, _within_m: float) -> _Table:
    return _is_over(subjects, hosts) & (subjects.base_m[:, None] >= hosts.top_m - 1.0)


def _under(subjects: Instances, hosts: Instances, _within_m: float) -> _Table:
    # 5 cm of tolerance, for a subject that is as high as its host.
    is_lower = subjects.top_m[:, None] <= hosts.top_m + 0.05
    is_below = subjects.base_m[:, None] <= hosts.top_m - _UNDER_M
    return _is_over(subjects, hosts) & is_lower & is_below & ~_is_of(hosts, SHELLS)


def _inside(subjects: Instances, hosts: Instances, _within_m: float) -> _Table:
    is_high = subjects.base_m[:, None] >= hosts.base_m - _UNDER_M
    is_low = subjects.top_m[:, None] <= hosts.top_m + _UNDER_M
    is_held = _is_over(subjects, hosts) & is_high & is_low
    # Ground has hardly a height to be inside of: "in the park" means on it.
    return np.where(_is_of(hosts, GROUND), _on(subjects, hosts, 0.0), is_held)


def _next_to(subjects: Instances, hosts: Instances, within_m: float) -> _Table:
    return _is_near(subjects, hosts, within_m) & ~_is_over(subjects, hosts)


def _in_front_of(subjects: Instances, hosts: Instances, within_m: float) -> _Table:
    return _is_off_side(subjects, hosts, within_m, 1.0)


def _behind(subjects: Instances, hosts: Instances, within_m: float) -> _Table:
    return _is_off_side(subjects, hosts, within_m, -1.0)


def _facing(subjects: Instances, hosts: Instances, within_m: float) -> _Table:
    to_host = shapely.get_coordinates(
        shapely.shortest_line(subjects.centre[:, None], hosts.outline[None])
    ).reshape(len(subjects), len(hosts), 2, 2)
    away = to_host[:, :, 1] - to_host[:, :, 0]
    far_m = np.linalg.norm(away, axis=2)
    # The angle between the subject's front and the nearest point of the host's outline.
    forward = subjects.view.forward[subjects.first]
    along_m = np.einsum("nki,ni->nk", away, forward)
    return (along_m >= _COS_FACING * far_m) & _next_to(subjects, hosts, within_m)


def _along(subjects: Instances, hosts: Instances, within_m: float) -> _Table:
    table = _is_near(subjects, hosts, within_m)
    along, across = _own_axes(subjects, hosts)
    half_m = hosts.view.arrays.size_m[hosts.first, :2] / 2
    is_long_x = half_m[:, 0] >= half_m[:, 1]
    place_m = np.where(is_long_x, along, across)
    # One thing at a long host is not "along" it: the row must stretch over part of its length.
    for k in range(len(hosts)):
        stretch_m = np.ptp(place_m[table[:, k], k]) if table[:, k].any() else 0.0
        least_m = min(_ROW_M, 4.0 * half_m[k].max() / 3.0)
        table[:, k] &= bool(stretch_m >= least_m)
    return table


def _around(subjects: Instances, hosts: Instances, within_m: float) -> _Table:
    table = _next_to(subjects, hosts, within_m)
    along, across = _own_axes(subjects, hosts)
    # Quarters of the circle about the host's own axes: 0 front, 1 left, 2 back, 3 right.
    side = np.round(np.arctan2(across, along) / (np.pi / 2)).astype(int) % 4
    for k in range(len(hosts)):
        table[:, k] &= len(set(side[table[:, k], k])) >= _SIDES
    return table


_JUDGES = {
    "on": _on,
    "on_roof": _on_roof,
    "over": _over,
    "under": _under,
    "inside": _inside,
    "next_to": _next_to,
    "near": _next_to,
    "in_front_of": _in_front_of,
    "behind": _behind,
    "facing": _facing,
    "along": _along,
    "around": _around,
}


def _is_over(subjects: Instances, hosts: Instances) -> _Table:
    """Return a table that is true if the middle of a subject is in the outline of a host."""
    return shapely.covers(hosts.outline[None], subjects.centre[:, None])


def _is_near(subjects: Instances, hosts: Instances, within_m: float) -> _Table:
    """Return a table that is true if outlines are near, and the things are at one level."""
    # The heights that both share; negative is the gap between them.
    low_m = np.maximum(subjects.base_m[:, None], hosts.base_m)
    high_m = np.minimum(subjects.top_m[:, None], hosts.top_m)
    apart_m = shapely.distance(subjects.outline[:, None], hosts.outline[None])
    return (apart_m <= within_m) & (high_m - low_m >= -_LEVEL_M)


def _is_off_side(subjects: Instances, hosts: Instances, within_m: float, sign: float) -> _Table:
    """Return a table of subjects off the front of hosts, or off the back for a negative sign."""
    along, across = _own_axes(subjects, hosts)
    half_m = hosts.view.arrays.size_m[hosts.first, :2] / 2
    is_before = sign * along > half_m[:, 0]
    is_abreast = np.abs(across) <= half_m[:, 1] + _ASIDE_M
    return is_before & is_abreast & _is_near(subjects, hosts, within_m)


def _own_axes(
    subjects: Instances, hosts: Instances
) -> tuple[Float[np.ndarray, "n k"], Float[np.ndarray, "n k"]]:
    """Return the middles of subjects, in m, on the x and y axes of each host's first box."""
    view, rows = hosts.view, hosts.first
    away = shapely.get_coordinates(subjects.centre)[:, None] - view.centre_m[rows]
    return (
        np.einsum("nki,ki->nk", away, view.forward[rows]),
        np.einsum("nki,ki->nk", away, view.leftward[rows]),
    )


def _is_of(hosts: Instances, categories: frozenset[str]) -> Bool[np.ndarray, " k"]:
    objects = hosts.view.scene.objects
    return np.array([objects[row].category in categories for row in hosts.first], dtype=bool)


def _is_same(subjects: Instances, hosts: Instances) -> _Table:
    """Return a table that is true if a subject shares an object with a host."""
    return np.array(
        [[not set(rows).isdisjoint(other) for other in hosts.rows] for rows in subjects.rows],
        dtype=bool,
    ).reshape(len(subjects), len(hosts))
