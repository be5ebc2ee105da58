"""Which places of a scene a description fits, by geometry.

Words have no sharp edges: 4 m from a bench is perhaps still beside it. So each condition has three
outcomes, and a text may be used only if it surely fits one place and surely fits no other one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from aeroscene.scene.catalogue import ROOMS
from scenarios.words.goal import (
    COMPASS,
    Beside,
    Between,
    Compass,
    Description,
    Has,
    Link,
    Nearest,
    Of,
    On,
    Toward,
    marks_of,
)
from scenarios.words.site import Place, Site, Truth
from scenarios.words.vocabulary import ALIKE_COLOURS, ALIKE_KINDS, ALIKE_TO

BESIDE_M, NOT_BESIDE_M = 2.5, 7.0
"""Gap up to which something is beside another, and from which on it is not."""
TOWARD_M = 20.0
"""Gap up to which one speaks of a side of something."""
_SURE_RAD, _WITHIN_RAD, _MAYBE_RAD = math.radians(30), math.radians(50), math.radians(70)
"""Angle from a compass direction within which a middle, and all of a footprint, surely lie; and
beyond which no part of it may lie."""
_BETWEEN_M = 40.0
"""Gap up to which one speaks of the space between two things."""
_CLOSER, _CLOSER_M = 1.4, 1.0
"""A place is the nearest if others are farther by this factor and length together."""
_TOUCH = 0.02
"""Share of the smaller footprint that may overlap where two things only touch."""
_LEVEL_M = 1.0
"""Vertical gap up to which two things are level with each other."""


def fits(description: Description, site: Site) -> Mapping[Place, Truth]:
    """Places that a description fits or may be thought to fit.

    Args:
        description: What is looked for.
        site: Where.

    Returns:
        `YES` or `MAYBE` under each such place; all others it surely does not fit.
    """
    if description not in site.fits:
        site.fits[description] = _fits(description, site)
    return site.fits[description]


def _fits(description: Description, site: Site) -> Mapping[Place, Truth]:
    found: dict[Place, Truth] = {}
    for kind in (description.kind, *ALIKE_TO.get(description.kind, ())):
        for place in site.of_kind(kind):
            if truth := _looks_fit(description, place, site):
                found[place] = truth
    for link in description.links:
        if found and not isinstance(link, Nearest):
            found = _kept(link, found, site)
    # The nearest of those that all else fits.
    for link in description.links:
        if found and isinstance(link, Nearest):
            found = _nearest(link, found, site)
    return found


def the_one(description: Description, site: Site) -> Place | None:
    """The only place that a description fits; None if it fits none, or if another one may do."""
    found = fits(description, site)
    if len(found) != 1:
        return None
    (place, truth), *_ = found.items()
    return place if truth is Truth.YES else None


def _looks_fit(description: Description, place: Place, site: Site) -> Truth:
    wanted = (description.kind, description.colour, description.form)
    truth = _same_kind(wanted[0], place.kind)
    if truth and wanted[1] is not None:
        truth = min(truth, _same_colour(wanted[1], place))
    if truth and wanted[2] is not None and place.form != wanted[2]:
        is_other = place.kind == wanted[0] and place.form is not None
        truth = Truth.NO if is_other else min(truth, Truth.MAYBE)
    if truth and description.storey is not None:
        storey = site.storey_of(place)
        truth = truth if storey == description.storey else Truth.NO
    return truth


def _same_kind(wanted: str, kind: str) -> Truth:
    if wanted == kind:
        return Truth.YES
    return Truth.MAYBE if (wanted, kind) in ALIKE_KINDS else Truth.NO


def _same_colour(wanted: str, place: Place) -> Truth:
    if wanted == place.colour:
        return Truth.YES
    # A van with a red cab and a white box may be called either.
    shown = {place.colour} if place.colour is not None else place.colours
    may_be = not shown or any(each == wanted or (wanted, each) in ALIKE_COLOURS for each in shown)
    return Truth.MAYBE if may_be else Truth.NO


def _kept(link: Link, found: Mapping[Place, Truth], site: Site) -> dict[Place, Truth]:
    """Places for which a relation holds or may hold."""
    known = site.holds.setdefault(link, {})
    holds = None if all(place.id in known for place in found) else _condition(link, site)
    kept: dict[Place, Truth] = {}
    for place, truth in found.items():
        if holds is not None and place.id not in known:
            known[place.id] = holds(place)
        if both := min(truth, known[place.id]):
            kept[place] = both
    return kept


def _condition(link: Link, site: Site) -> Callable[[Place], Truth]:
    """Function that says whether a relation holds for a place.

    A relation to something that is not unique holds for nobody.
    """
    if isinstance(link, Has):
        return lambda place: has(link, place, site)
    marks = [the_one(mark, site) for mark in marks_of(link)]
    if any(mark is None for mark in marks):
        return lambda _: Truth.NO
    first = marks[0]
    assert first is not None
    match link:
        case On():
            return lambda place: on(place, first, site)
        case Of():
            return lambda place: _truth(site.whole_of(place) is first)
        case Beside():
            return lambda place: beside(place, first, site)
        case Toward(direction):
            return lambda place: toward(place, first, direction, site)
        case Between():
            second = marks[1]
            assert second is not None
            return lambda place: between(place, first, second, site)
        case _:
            raise TypeError(link)


def _truth(value: bool) -> Truth:
    return Truth.YES if value else Truth.NO


def has(link: Has, place: Place, site: Site) -> Truth:
    """Whether so many of a kind stand on a place."""
    sure = possible = 0
    for other, is_sure in site.standing_on(place):
        truth = _same_kind(link.kind, other.kind)
        possible += truth > Truth.NO
        sure += is_sure and truth is Truth.YES
    if sure == possible == link.count:
        return Truth.YES
    # Where there are more, some may still say that there are two.
    return Truth.NO if possible < link.count else Truth.MAYBE


def on(place: Place, host: Place, site: Site) -> Truth:
    """Whether something stands on a place, or in a room."""
    stands = site.stands_on(place, host)
    return Truth.MAYBE if stands is None else _truth(stands)


def beside(place: Place, mark: Place, site: Site) -> Truth:
    """Whether something is within reach of a mark, level with it and in the same room."""
    if place is mark or not _is_level(place, mark):
        return Truth.NO
    gap_m = site.gap_m(place, mark)
    if gap_m > NOT_BESIDE_M:
        return Truth.NO
    is_sure = gap_m <= BESIDE_M and _are_apart(place, mark) and _share_a_room(place, mark, site)
    return Truth.YES if is_sure else Truth.MAYBE


def toward(place: Place, mark: Place, direction: Compass, site: Site) -> Truth:
    """Whether something lies in a direction from a mark."""
    if place is mark:
        return Truth.NO
    off_rad = _angles_off(place.points, mark.centre, direction)
    if off_rad.min() > _MAYBE_RAD:
        return Truth.NO
    (middle_rad,) = _angles_off(place.centre[None], mark.centre, direction)
    is_sure = (
        middle_rad <= _SURE_RAD
        and off_rad.max() <= _WITHIN_RAD
        and site.gap_m(place, mark) <= TOWARD_M
        and _are_apart(place, mark)
        and _is_level(site.foot_of(place), site.foot_of(mark))
        and _share_a_room(place, mark, site)
    )
    return Truth.YES if is_sure else Truth.MAYBE


def between(place: Place, first: Place, second: Place, site: Site) -> Truth:
    """Whether something lies between two marks."""
    if place in {first, second}:
        return Truth.NO
    way = second.centre - first.centre
    length_m = float(np.linalg.norm(way))
    if length_m < 1e-6:
        return Truth.NO
    along, across = _in_frame(place.points, first.centre, way / length_m)
    is_near = (along > 0.0) & (along < length_m) & (np.abs(across) < 0.5 * length_m)
    if not is_near.any():
        return Truth.NO
    (middle_along,), (middle_across,) = _in_frame(place.centre[None], first.centre, way / length_m)
    is_sure = (
        site.gap_m(first, second) <= _BETWEEN_M
        and 0.25 * length_m <= middle_along <= 0.75 * length_m
        and abs(middle_across) <= 0.15 * length_m
        and all(_are_apart(place, mark) for mark in (first, second))
        and all(_is_level(site.foot_of(place), site.foot_of(mark)) for mark in (first, second))
        and all(_share_a_room(place, mark, site) for mark in (first, second))
    )
    return Truth.YES if is_sure else Truth.MAYBE


def _nearest(link: Nearest, found: Mapping[Place, Truth], site: Site) -> dict[Place, Truth]:
    mark = the_one(link.mark, site)
    if mark is None:
        return {}
    gaps_m = {place: _gap_m(place, mark, site) for place in found if place is not mark}
    nearest = min(gaps_m, key=lambda place: gaps_m[place], default=None)
    if nearest is None:
        return {}
    reach_m = _CLOSER * gaps_m[nearest] + _CLOSER_M
    near = [place for place, gap_m in gaps_m.items() if gap_m <= reach_m]
    is_sure = len(near) == 1 and _are_apart(nearest, mark) and _share_a_room(nearest, mark, site)
    return {place: min(found[place], Truth.YES if is_sure else Truth.MAYBE) for place in near}


def _gap_m(place: Place, mark: Place, site: Site) -> float:
    """Least distance between two things, also from storey to storey."""
    rise_m = max(place.bottom_m - mark.top_m, mark.bottom_m - place.top_m, 0.0)
    return math.hypot(site.gap_m(place, mark), rise_m)


def _are_apart(place: Place, mark: Place) -> bool:
    """Whether neither stands on the other: footprints may touch, but not overlap."""
    least_m2 = min(place.ground.area, mark.ground.area)
    return place.ground.intersection(mark.ground).area <= _TOUCH * least_m2


def _is_level(place: Place, mark: Place) -> bool:
    """Whether the heights of two things overlap, or nearly do."""
    return place.bottom_m <= mark.top_m + _LEVEL_M and mark.bottom_m <= place.top_m + _LEVEL_M


def _share_a_room(place: Place, mark: Place, site: Site) -> bool:
    """Whether no wall of a room stands between two things; rooms count as places of a storey."""
    rooms = site.room_by_id
    if ROOMS & {place.kind, mark.kind}:
        return place.kind == mark.kind and site.whole_of(place) is site.whole_of(mark)
    return rooms[place.id] is rooms[mark.id]


def _angles_off(points: np.ndarray, centre: np.ndarray, direction: Compass) -> np.ndarray:
    """Angle of each point from a direction, seen from a centre, rad."""
    bearing = math.radians(90.0 * COMPASS.index(direction))
    along, across = _in_frame(points, centre, np.array([math.sin(bearing), math.cos(bearing)]))
    return np.abs(np.arctan2(across, along))


def _in_frame(
    points: np.ndarray, origin: np.ndarray, axis: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Lengths along an axis and across it, m."""
    away = points - origin
    return away @ axis, away @ np.array([-axis[1], axis[0]])
