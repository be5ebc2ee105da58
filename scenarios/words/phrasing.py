"""English texts of descriptions, in several phrasings that a seed chooses among."""

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
"""Orders that go on after the place, which only a short one allows: at the end of a long one nobody
knows any more what `there` is."""
_NUMBERS = ("no", "one", "two", "three", "four", "five")
_STOREYS = ("on the ground floor", "one floor up", "two floors up", "three floors up")


def text_of(description: Description, rng: np.random.Generator) -> str:
    """The order to land on what a description means.

    Args:
        description: What is meant.
        rng: Chooses the phrasing.
    """
    place = noun_phrase(description, rng)
    at, there = _prepositions(description.kind, rng)
    orders = _SHORT_ORDERS if description.is_plain else _ORDERS
    text = _one(rng, orders).format(at=at, place=place, there=there)
    return text[0].upper() + text[1:]


def noun_phrase(
    description: Description, rng: np.random.Generator, *, is_mark: bool = False
) -> str:
    """`The ...` with all that a description says.

    Args:
        description: What is meant.
        rng: Chooses the phrasing.
        is_mark: Whether something else is described by it. Then directions are by compass: two
            viewpoints in one sentence would be taken for one.
    """
    before, after = FORM_WORDS.get((description.kind, description.form or ""), ("", ""))
    noun, _ = NOUNS[description.kind]
    storey = "" if description.storey is None else _storey(description.storey)
    words = ["the", description.colour or "", before, noun, storey, after]
    head = " ".join(word for word in words if word)
    links = [_link(link, description, rng, is_mark=is_mark) for link in description.links]
    if links and isinstance(description.links[0], Has) and after.startswith("with "):
        links[0] = links[0].replace("with ", "and ", 1)
    if len(links) < 2:
        # The cross of a landing pad is not west of anything: the pad is.
        is_apart = bool(after) and not is_mark and not any(x.startswith("and ") for x in links)
        return (", " if is_apart else " ").join([head, *links])
    first, *rest = description.links
    if isinstance(first, (Has, Of)):
        return f"{head} {links[0]}, {' and '.join(links[1:])}"
    if any(isinstance(link, Has) for link in rest):
        return f"{head} {', '.join(links)}"
    return f"{head} that is {' and '.join(links)}"


def _storey(number: int) -> str:
    return _STOREYS[number] if number < len(_STOREYS) else f"{number} floors up"


def _prepositions(kind: str, rng: np.random.Generator) -> tuple[str, str]:
    """How one lands at a kind of place, before its name and after it."""
    if kind in ROOMS:
        return "in", _one(rng, ("there", "in it"))
    if kind in ON_TOP:
        return _one(rng, ("on top of", "on")), _one(rng, ("on top", "on top of it"))
    return "on", _one(rng, ("there", "on it"))


def _link(link: Link, whose: Description, rng: np.random.Generator, *, is_mark: bool) -> str:
    """A relation in words."""
    match link:
        case Has(count, kind):
            return f"with {_counted(count, kind)} {_where_on(whose.kind)}"
        case On(host):
            preposition = "in" if host.kind in ROOMS else "on"
            # `nearest to the van on the lawn` leaves open what is on the lawn.
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
    """Ways to say by compass that something lies in a direction from a mark."""
    return f"{direction} of {{}}", f"to the {direction} of {{}}"


def _sides(direction: Compass) -> Sequence[str]:
    """All ways to say that something lies in a direction from a mark."""
    place = COMPASS.index(direction)
    opposite, right, left = (COMPASS[(place + turn) % 4] for turn in (2, 1, 3))
    # Whoever stands in the south and looks north has the east to the right.
    return (
        *_by_compass(direction),
        f"behind {{}} as seen from the {opposite}",
        f"to the right of {{}} as seen from the {right}",
        f"to the left of {{}} as seen from the {left}",
    )


def _one(rng: np.random.Generator, words: Sequence[str]) -> str:
    return words[int(rng.integers(len(words)))]
