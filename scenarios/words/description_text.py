"""English texts of descriptions, in several phrasings among which a seed chooses.

Each part of a description has a few phrasings, so that a pilot cannot rely on one pattern. Some
combinations are grammatical and still ambiguous, for example a relation that could belong to either
of two nouns. Commas, "that stands" and the order of relations prevent these.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aeroscene.scene.catalogue import ROOMS, WATER
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
)
from scenarios.words.vocabulary import FORM_WORDS, NOUNS, ON_TOP

_ORDERS = (
    "Land {at} {place}.",
    "Please land {at} {place}.",
    "Set the drone down {at} {place}.",
    "Touch down {at} {place}.",
    "Your target is {place}. Land {there}.",
    "Find {place}. Land {there}.",
)
_SHORT_ORDERS = (
    *_ORDERS,
    "Find {place} and land {there}.",
    "Fly to {place} and land {there}.",
    "Bring the drone to {place} and put it down {there}.",
)
"""Orders for short places, some of which continue after the place. At the end of a long place, a
reader would not know any more what "there" refers to."""
_NUMBERS = ("no", "one", "two", "three", "four", "five")
_STOREYS = ("on the ground floor", "one floor up", "two floors up", "three floors up")


def text_of(description: Description, rng: np.random.Generator) -> str:
    """Return the order to land on the place that a description means.

    Args:
        description: Meaning of the text.
        rng: Source of the phrasing.
    """
    place = noun_phrase(description, rng)
    at, there = _prepositions(description.kind, rng)
    # A long place is named at the end, or in a sentence of its own.
    orders = _SHORT_ORDERS if description.is_plain else _ORDERS
    text = _one(rng, orders).format(at=at, place=place, there=there)
    return text[0].upper() + text[1:]


def noun_phrase(
    description: Description, rng: np.random.Generator, *, is_mark: bool = False
) -> str:
    """Return the noun phrase of a description, such as "the red car on the lawn".

    Args:
        description: Meaning of the phrase.
        rng: Source of the phrasing.
        is_mark: True if the phrase is a landmark within another one. Its directions are then by
            compass, because two viewpoints in one sentence would be taken for one.
    """
    before, after = FORM_WORDS.get((description.kind, description.form or ""), ("", ""))
    noun, _ = NOUNS[description.kind]
    storey = "" if description.storey is None else _storey(description.storey)
    words = ["the", description.colour or "", before, noun, storey, after]
    head = " ".join(word for word in words if word)
    links = [_link(link, description, rng, is_mark=is_mark) for link in description.links]
    # "with the carpet and two chairs in it" rather than "with the carpet with two chairs in it".
    if links and isinstance(description.links[0], Has) and after.startswith("with "):
        links[0] = links[0].replace("with ", "and ", 1)
    if len(links) < 2:
        # A comma keeps "the pad with a white cross, west of ..." from placing the cross.
        is_apart = bool(after) and not is_mark and not any(x.startswith("and ") for x in links)
        return (", " if is_apart else " ").join([head, *links])
    first, *rest = description.links
    # Several relations: each form of the sentence keeps them all with the first noun.
    if isinstance(first, (Has, Of)):
        return f"{head} {links[0]}, {' and '.join(links[1:])}"
    if any(isinstance(link, Has) for link in rest):
        return f"{head} {', '.join(links)}"
    return f"{head} that is {' and '.join(links)}"


def _storey(number: int) -> str:
    return _STOREYS[number] if number < len(_STOREYS) else f"{number} floors up"


def _prepositions(kind: str, rng: np.random.Generator) -> tuple[str, str]:
    """Return the words for landing at a kind of place, before its name and in place of it."""
    if kind in ROOMS:
        return "in", _one(rng, ("there", "in it"))
    if kind in ON_TOP:
        return _one(rng, ("on top of", "on")), _one(rng, ("on top", "on top of it"))
    return "on", _one(rng, ("there", "on it"))


def _link(link: Link, whose: Description, rng: np.random.Generator, *, is_mark: bool) -> str:
    """Return a relation in words."""
    match link:
        case Has(count, kind):
            return f"with {_counted(count, kind)} {_where_on(whose.kind)}"
        case On(host):
            preposition = "in" if host.kind in ROOMS else "on"
            # In "nearest to the van on the lawn", either could be on the lawn.
            preposition = f"that stands {preposition}" if is_mark else preposition
            return f"{preposition} {_mark(host, rng)}"
        case Of(whole):
            return f"of {_mark(whole, rng)}"
        case Beside(mark):
            return f"{_one(rng, ('beside', 'next to', 'right by'))} {_mark(mark, rng)}"
        case Toward(direction, mark):
            is_short = mark.is_plain and not is_mark
            ways = _sides(direction) if is_short else _by_compass(direction)
            return _one(rng, ways).format(_mark(mark, rng))
        case Between(first, second):
            return f"between {_mark(first, rng)} and {_mark(second, rng)}"
        case Nearest(mark):
            return f"{_one(rng, ('nearest to', 'closest to'))} {_mark(mark, rng)}"


def _mark(mark: Description, rng: np.random.Generator) -> str:
    return noun_phrase(mark, rng, is_mark=True)


def _counted(count: int, kind: str) -> str:
    single, several = NOUNS[kind]
    if count == 1:
        return f"{'an' if single[0] in 'aeiou' else 'a'} {single}"
    return f"{_NUMBERS[count]} {several}"


def _where_on(kind: str) -> str:
    return "in it" if kind in ROOMS | WATER else "on it"


def _by_compass(direction: Compass) -> Sequence[str]:
    """Return phrases by compass for a place in a direction from a mark."""
    return f"{direction} of {{}}", f"to the {direction} of {{}}"


def _sides(direction: Compass) -> Sequence[str]:
    """Return all phrases for a place in a direction from a mark, also from a viewpoint."""
    place = COMPASS.index(direction)
    opposite, right, left = (COMPASS[(place + turn) % 4] for turn in (2, 1, 3))
    # An observer in the south who looks north has the east to the right.
    return (
        *_by_compass(direction),
        f"behind {{}} as seen from the {opposite}",
        f"to the right of {{}} as seen from the {right}",
        f"to the left of {{}} as seen from the {left}",
    )


def _one(rng: np.random.Generator, words: Sequence[str]) -> str:
    return words[int(rng.integers(len(words)))]
