"""Meaning of a text as plain data: a kind of place, its looks, and its relations to other places.

The classes form a tree: a description has relations, and most relations refer to another
description. They are frozen, so that descriptions are keys under which results are kept.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

Compass = Literal["north", "east", "south", "west"]
COMPASS: tuple[Compass, ...] = ("north", "east", "south", "west")
"""Directions, clockwise from above; the index times 90 degrees is the bearing."""
Grade = Literal["naming", "relation", "chain"]
GRADES: tuple[Grade, ...] = ("naming", "relation", "chain")


@dataclass(frozen=True, kw_only=True, slots=True)
class Description:
    """Meaning of a noun phrase such as "the red car on the lawn"."""

    kind: str
    """Kind of the place, a key of `vocabulary.NOUNS`."""
    colour: str | None = None
    """Adjective of a colour; None for any."""
    form: str | None = None
    """Form, which is with the kind a key of `vocabulary.FORM_WORDS`; None for any."""
    storey: int | None = None
    """Storey of its building, 0 for the lowest one; None for any."""
    links: tuple[Link, ...] = ()
    """Relations to other places, all of which must hold."""

    @property
    def is_plain(self) -> bool:
        """True if it has no relation."""
        return not self.links


@dataclass(frozen=True, slots=True)
class Has:
    """Relation: exactly `count` objects of a kind stand on the place, or in it."""

    count: int
    kind: str


@dataclass(frozen=True, slots=True)
class On:
    """Relation: the place stands on another place, or in a room."""

    host: Description


@dataclass(frozen=True, slots=True)
class Of:
    """Relation: the place is the roof of a building."""

    whole: Description


@dataclass(frozen=True, slots=True)
class Beside:
    """Relation: the place is beside a mark, level with it."""

    mark: Description


@dataclass(frozen=True, slots=True)
class Toward:
    """Relation: the place lies on one side of a mark, by compass, and not far from it."""

    direction: Compass
    mark: Description


@dataclass(frozen=True, slots=True)
class Between:
    """Relation: the place lies between two marks."""

    first: Description
    second: Description


@dataclass(frozen=True, slots=True)
class Nearest:
    """Relation: of all places that fit the rest, the place is clearly the nearest to a mark."""

    mark: Description


Link: TypeAlias = Has | On | Of | Beside | Toward | Between | Nearest


def grade_of(description: Description) -> Grade:
    """Return the grade of a text by its meaning: naming, one relation, or a chain of them.

    One relation to a mark that has a relation itself is a chain, too.

    Args:
        description: Meaning of the text.
    """
    match description.links:
        case ():
            return "naming"
        case (link,):
            return "relation" if all(mark.is_plain for mark in marks_of(link)) else "chain"
        case _:
            return "chain"


def marks_of(link: Link) -> tuple[Description, ...]:
    """Return the descriptions that a relation refers to: none for `Has`, two for `Between`."""
    match link:
        case Has():
            return ()
        case On(host):
            return (host,)
        case Of(whole):
            return (whole,)
        case Between(first, second):
            return (first, second)
        case Beside(mark) | Toward(_, mark) | Nearest(mark):
            return (mark,)
