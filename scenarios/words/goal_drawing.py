"""Drawing of a goal: a description that fits one place of a scene and surely no other, with a text.

A text should be short and fair. Descriptions are therefore generated from the place's own looks and
from landmarks near it. Each is checked by `grounding` until one fits the place alone. A relation is
kept only if the description would fit another place without it. Otherwise texts would be full of
words that nobody needs, and a pilot could ignore the relations.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from aeroscene.scene import InteractionArea, Scene
from aeroscene.scene.catalogue import LAWNS, ROOFS, ROOMS, STRIPS, WATER
from flightsim.draws import generator
from scenarios.words.description_text import text_of
from scenarios.words.goal import (
    COMPASS,
    Beside,
    Between,
    Description,
    Grade,
    Has,
    Link,
    Nearest,
    Of,
    On,
    Toward,
    grade_of,
    marks_of,
)
from scenarios.words.grounding import TOWARD_M, fits, the_one
from scenarios.words.site import Place, Site, Truth, site_of
from scenarios.words.vocabulary import COUNTED, NOUNS, TOWERING

_MOST_MARKS = 14
"""Number of nearest landmarks that a text may refer to."""
_MOST_NESTED = 5
"""Number of nearest landmarks with a relation of their own that a text may refer to."""
_MOST_COUNT = 5
"""Greatest number of objects that a text counts."""
_MOST_TRIES = 60
"""Pairs of relations that are tried for a chain."""
_POOR_MARKS = STRIPS | LAWNS | WATER | ROOFS | ROOMS
"""Kinds that are too large, or too similar to each other, to serve as landmarks."""


@dataclass(frozen=True, kw_only=True, eq=False)
class WordGoal:
    """A goal in words.

    Attributes:
        text: Text that the pilot gets.
        description: Meaning of the text.
        areas: Areas of the only place that it fits; landing on any of them is a success.
    """

    text: str
    description: Description
    areas: tuple[InteractionArea, ...]

    @property
    def grade(self) -> Grade:
        """Grade of the text: it names, relates, or chains relations."""
        return grade_of(self.description)


def draw_goal(scene: Scene, area: InteractionArea, grade: Grade, seed: int) -> WordGoal | None:
    """Draw a goal whose text fits the place that carries an area, and no other place.

    Args:
        scene: Scene of the flight.
        area: Landing area whose place is meant.
        grade: Grade of the text.
        seed: Seed of the draw; the same seed gives the same text.

    Returns:
        The goal; None if no text of the grade fits that place alone.
    """
    site = site_of(scene)
    place = site.place_of(area.object_id)
    if place is None or place.kind not in NOUNS:
        return None
    rng = generator(seed, scene.scene_id, "words", grade, str(area.object_id))
    description = describe(site, place, grade, rng)
    if description is None:
        return None
    return WordGoal(text=text_of(description, rng), description=description, areas=place.areas)


def describe(
    site: Site, place: Place, grade: Grade, rng: np.random.Generator
) -> Description | None:
    """Draw a description of a grade that fits a place and surely no other.

    Each relation is needed: without it, the description would fit another place as well.

    Args:
        site: All places of the scene.
        place: Place that is meant.
        grade: Grade of the description.
        rng: Source of the choice.

    Returns:
        The description, or None if there is none.
    """
    found: Iterator[Description]
    match grade:
        case "naming":
            found = (each for each in _heads(site, place) if the_one(each, site) is place)
            # Any of them, not only the shortest: texts should vary.
            every = list(found)
            return every[int(rng.integers(len(every)))] if every else None
        case "relation":
            found = _related(site, place, rng)
        case "chain":
            found = _chained(site, place, rng)
    return next(found, None)


def _heads(site: Site, place: Place) -> list[Description]:
    """Return all descriptions of a place without relations, the shortest first; each fits it."""
    if place.id in site.heads:
        return site.heads[place.id]
    looks = [(name, value) for name in ("colour", "form") if (value := getattr(place, name))]
    if (storey := site.storey_of(place)) is not None:
        looks.append(("storey", storey))
    site.heads[place.id] = [
        Description(kind=place.kind, **dict(chosen))
        # By the number of looks, so that the shortest description comes first.
        for count in range(len(looks) + 1)
        for chosen in itertools.combinations(looks, count)
    ]
    return site.heads[place.id]


def _name(site: Site, place: Place) -> Description | None:
    """Return the shortest description without relations that fits a place alone, else None."""
    heads = _heads(site, place) if place.kind in NOUNS else []
    return next((head for head in heads if the_one(head, site) is place), None)


def _shuffled(items: Sequence, rng: np.random.Generator) -> list:
    return [items[i] for i in rng.permutation(len(items))]


def _related(site: Site, place: Place, rng: np.random.Generator) -> Iterator[Description]:
    """Yield descriptions with one relation to a landmark that needs only a name."""
    # Heads that fit the place alone would make the relation idle.
    open_heads = [head for head in _heads(site, place) if the_one(head, site) is not place]
    links = _links(site, place, _named_marks(site, place))
    for head in _shuffled(open_heads, rng):
        for link in _by_kind(links, rng):
            if the_one(found := replace(head, links=(link,)), site) is place:
                yield found


def _chained(site: Site, place: Place, rng: np.random.Generator) -> Iterator[Description]:
    """Yield descriptions with two relations, or with one to a landmark that has one itself."""
    heads = [head for head in _heads(site, place) if the_one(head, site) is not place]
    ways = [_paired(site, place, heads, rng), _nested(site, place, heads, rng)]
    for way in _shuffled(ways, rng):
        yield from way


def _paired(
    site: Site, place: Place, heads: Sequence[Description], rng: np.random.Generator
) -> Iterator[Description]:
    links = _by_kind(_links(site, place, _named_marks(site, place)), rng)
    pairs = [pair for pair in itertools.combinations(links, 2) if _go_together(*pair)]
    for head in _shuffled(heads, rng):
        # Neither relation may be enough alone, or the other one would be idle.
        alone = {link: the_one(replace(head, links=(link,)), site) is place for link in links}
        tried = [pair for pair in _shuffled(pairs, rng) if not any(alone[link] for link in pair)]
        for pair in tried[:_MOST_TRIES]:
            if the_one(found := replace(head, links=_ordered(pair)), site) is place:
                yield found


def _nested(
    site: Site, place: Place, heads: Sequence[Description], rng: np.random.Generator
) -> Iterator[Description]:
    marks = []
    for other in _around(site, place):
        if other.kind == place.kind:
            continue
        # A landmark that a name tells apart needs no relation, so it would make no chain.
        if _name(site, other) is not None:
            continue
        related = next(_related(site, other, rng), None)
        if related is not None and not _speaks_of(related, place, site):
            marks.append((other, related))
        if len(marks) == _MOST_NESTED:
            break
    links = _by_kind(_links(site, place, marks), rng)
    nested = [link for link in links if not isinstance(link, (Has, Between))]
    nested = [link for link in nested if not _is_nearest_to_nearest(link)]
    for head in _shuffled(heads, rng):
        for link in nested[:_MOST_TRIES]:
            if the_one(found := replace(head, links=(link,)), site) is place:
                yield found


def _speaks_of(description: Description, place: Place, site: Site) -> bool:
    """Return true if a description refers to a place, which it then must not help to describe."""
    marks = [mark for link in description.links for mark in marks_of(link)]
    return any(the_one(mark, site) is place for mark in marks)


def _is_nearest_to_nearest(link: Link) -> bool:
    # "the bench nearest to the car nearest to the tree" is hard to follow.
    inner = link.mark.links if isinstance(link, Nearest) else ()
    return any(isinstance(each, Nearest) for each in inner)


def _go_together(first: Link, second: Link) -> bool:
    """Return true if two relations are of different kinds, and not the host named twice."""
    return type(first) is not type(second) and not {On, Of} >= {type(first), type(second)}


def _ordered(pair: tuple[Link, Link]) -> tuple[Link, ...]:
    """Return relations in the order of a sentence: objects on the place first, its host last.

    The host is last, because after a host with a form, such as "in the room with the carpet", a
    reader could take a further relation for the host's.
    """
    rank = (Has, Of, Beside, Between, Toward, Nearest, On)
    return tuple(sorted(pair, key=lambda link: rank.index(type(link))))


def _by_kind(links: Sequence[Link], rng: np.random.Generator) -> list[Link]:
    """Return relations in a drawn order, in which the kinds of relations take turns."""
    kinds: dict[type, list[Link]] = {}
    for link in _shuffled(links, rng):
        kinds.setdefault(type(link), []).append(link)
    # "Nearest" comes last, because it nearly always fits one place alone. If it took turns with the
    # others, most texts would use it.
    last = kinds.pop(Nearest, [])
    rows = itertools.zip_longest(*_shuffled(list(kinds.values()), rng))
    return [*(link for row in rows for link in row if link is not None), *last]


def _around(site: Site, place: Place) -> list[Place]:
    """Return the landmarks around a place, the nearest first."""
    near = [
        (gap_m, other.id, other)  # The number breaks ties, so that the order is always the same.
        for other in site.places
        if other is not place
        and other.kind in NOUNS
        and other.kind not in _POOR_MARKS
        and (gap_m := site.gap_m(other, place)) <= TOWARD_M
    ]
    return [other for _, _, other in sorted(near, key=lambda each: each[:2])]


def _named_marks(site: Site, place: Place) -> list[tuple[Place, Description]]:
    """Return the landmarks around a place that a name alone identifies, with the shortest name."""
    found: list[tuple[Place, Description]] = []
    hosts = [host for host in site.hosts if site.stands_on(place, host)]
    whole = site.whole_of(place) if place.kind in ROOFS else None
    # The host and the building come first, since they are the most natural things to refer to.
    wanted = [*hosts, *([] if whole is None else [whole]), *_around(site, place)]
    for other in dict.fromkeys(wanted):
        if (name := _name(site, other)) is not None:
            found.append((other, name))
        if len(found) == _MOST_MARKS:
            break
    return found


def _links(site: Site, place: Place, marks: Sequence[tuple[Place, Description]]) -> list[Link]:
    """Return the relations to landmarks that surely hold for a place."""
    found: list[Link] = []
    counts = Counter(other.kind for other, _ in site.standing_on(place))
    found += [
        Has(count, kind)
        for kind, count in counts.items()
        if kind in COUNTED and count <= _MOST_COUNT
    ]
    for _, name in marks:
        found += [On(name), Beside(name)]
        found += [Of(name)] if place.kind in ROOFS else []
        found += [Nearest(name)] if name.kind != place.kind else []
        found += [Toward(direction, name) for direction in COMPASS]
    level = [name for other, name in marks if other.kind not in TOWERING]
    found += [Between(first, second) for first, second in itertools.combinations(level, 2)]
    return [
        link
        for link in found
        if fits(Description(kind=place.kind, links=(link,)), site).get(place) is Truth.YES
    ]
