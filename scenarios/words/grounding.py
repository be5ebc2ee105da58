"""Evaluation of a description on a scene, by geometry: the places that it fits.

Words have no sharp edges: 4 m from a bench is perhaps still beside it. Each condition therefore has
three outcomes, yes, maybe and no. A text may be used only if it surely fits one place and surely
fits no other place. Several conditions together are as sure as the least sure of them, which is the
minimum of `Truth`.
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
"""Gap up to which a place is surely beside a mark, and gap beyond which it surely is not."""
TOWARD_M = 20.0
"""Greatest gap at which a place is surely "north of" a mark."""
_SURE_RAD, _WITHIN_RAD, _MAYBE_RAD = math.radians(30), math.radians(50), math.radians(70)
"""Angles from a compass direction. A place surely lies there if its middle is within the first and
all of its footprint within the second. It surely does not if all of it is beyond the third."""
_BETWEEN_M = 40.0
"""Greatest gap of two marks at which a place is surely "between" them."""
_CLOSER, _CLOSER_M = 1.4, 1.0
"""A place is surely the nearest if all others are farther than its distance times this factor plus
this length."""
_TOUCH = 0.02
"""Share of the smaller footprint up to which an overlap counts as touching."""
_LEVEL_M = 1.0
"""Vertical gap up to which two places count as level with each other."""


def fits(description: Description, site: Site) -> Mapping[Place, Truth]:
    """Return the places that a description fits, or that a reader may think it fits.

    Args:
        description: Description to evaluate.
        site: All places of the scene; it keeps the result.

    Returns:
        `YES` or `MAYBE` for each such place. It surely fits no other place.
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
    # "Nearest" is a comparison among the places that all other conditions leave, so it is last.
    for link in description.links:
        if found and isinstance(link, Nearest):
            found = _nearest(link, found, site)
    return found


def the_one(description: Description, site: Site) -> Place | None:
    """Return the only place that a description fits.

    Args:
        description: Description to evaluate.
        site: All places of the scene.

    Returns:
        The place; None if the description fits none for sure, or may fit a second one.
    """
    found = fits(description, site)
    # Two places that may fit are enough to make the text ambiguous.
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
        # A place of another kind, or of no known form, may still be taken for it.
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
    """Return the places for which a relation holds or may hold."""
    # Outcomes are kept by place, since many descriptions share a relation.
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
    """Return the function that evaluates a relation for a place.

    A relation to a mark that is not unique holds for no place.
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
    """Evaluate whether exactly `link.count` objects of a kind stand on a place.

    Args:
        link: Count and kind.
        place: Place that would carry them.
        site: All places of the scene.
    """
    sure = possible = 0
    for other, is_sure in site.standing_on(place):
        truth = _same_kind(link.kind, other.kind)
        possible += truth > Truth.NO
        sure += is_sure and truth is Truth.YES
    if sure == possible == link.count:
        return Truth.YES
    # With more than two of them, it is still true in a sense that there are two.
    return Truth.NO if possible < link.count else Truth.MAYBE


def on(place: Place, host: Place, site: Site) -> Truth:
    """Evaluate whether a place stands on a host, or in it if the host is a room."""
    stands = site.stands_on(place, host)
    return Truth.MAYBE if stands is None else _truth(stands)


def beside(place: Place, mark: Place, site: Site) -> Truth:
    """Evaluate whether a place is beside a mark: near it, level with it and in the same room."""
    if place is mark or not _is_level(place, mark):
        return Truth.NO
    gap_m = site.gap_m(place, mark)
    if gap_m > NOT_BESIDE_M:
        return Truth.NO
    is_sure = gap_m <= BESIDE_M and _are_apart(place, mark) and _share_a_room(place, mark, site)
    return Truth.YES if is_sure else Truth.MAYBE


def toward(place: Place, mark: Place, direction: Compass, site: Site) -> Truth:
    """Evaluate whether a place lies in a compass direction from a mark.

    Args:
        place: Place whose footprint is tested.
        mark: Landmark, from whose middle the angle is measured.
        direction: Direction as seen from the mark.
        site: All places of the scene.
    """
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
        # A roof counts by its building, which is what an observer on the ground sees.
        and _is_level(site.foot_of(place), site.foot_of(mark))
        and _share_a_room(place, mark, site)
    )
    return Truth.YES if is_sure else Truth.MAYBE


def between(place: Place, first: Place, second: Place, site: Site) -> Truth:
    """Evaluate whether a place lies between two marks.

    Args:
        place: Place whose footprint is tested.
        first: One mark.
        second: The other mark.
        site: All places of the scene.
    """
    if place in {first, second}:
        return Truth.NO
    way = second.centre - first.centre
    length_m = float(np.linalg.norm(way))
    if length_m < 1e-6:
        return Truth.NO
    along, across = _in_frame(place.points, first.centre, way / length_m)
    # A point beside the line by more than half of its length is surely not between.
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
    # All places within this reach may be taken for the nearest.
    reach_m = _CLOSER * gaps_m[nearest] + _CLOSER_M
    near = [place for place, gap_m in gaps_m.items() if gap_m <= reach_m]
    is_sure = len(near) == 1 and _are_apart(nearest, mark) and _share_a_room(nearest, mark, site)
    # A place that fits the rest only perhaps is not surely the nearest of those that fit.
    return {place: min(found[place], Truth.YES if is_sure else Truth.MAYBE) for place in near}


def _gap_m(place: Place, mark: Place, site: Site) -> float:
    """Return the least distance between two places, which may be on different storeys."""
    rise_m = max(place.bottom_m - mark.top_m, mark.bottom_m - place.top_m, 0.0)
    return math.hypot(site.gap_m(place, mark), rise_m)


def _are_apart(place: Place, mark: Place) -> bool:
    """Return true if neither stands on the other: footprints may touch, but not overlap."""
    least_m2 = min(place.ground.area, mark.ground.area)
    return place.ground.intersection(mark.ground).area <= _TOUCH * least_m2


def _is_level(place: Place, mark: Place) -> bool:
    """Return true if the heights of two places overlap, or nearly do."""
    return place.bottom_m <= mark.top_m + _LEVEL_M and mark.bottom_m <= place.top_m + _LEVEL_M


def _share_a_room(place: Place, mark: Place, site: Site) -> bool:
    """Return true if no wall of a room is between two places; two rooms need one building."""
    rooms = site.room_by_id
    if ROOMS & {place.kind, mark.kind}:
        return place.kind == mark.kind and site.whole_of(place) is site.whole_of(mark)
    return rooms[place.id] is rooms[mark.id]


def _angles_off(points: np.ndarray, centre: np.ndarray, direction: Compass) -> np.ndarray:
    """Return the angle of each point from a direction, seen from a centre, 0 to pi rad."""
    # Compass bearings count clockwise from north, so east is the sine and north the cosine.
    bearing = math.radians(90.0 * COMPASS.index(direction))
    along, across = _in_frame(points, centre, np.array([math.sin(bearing), math.cos(bearing)]))
    return np.abs(np.arctan2(across, along))


def _in_frame(
    points: np.ndarray, origin: np.ndarray, axis: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the coordinates of points along an axis and across it, m; positive to its left."""
    away = points - origin
    return away @ axis, away @ np.array([-axis[1], axis[0]])
