"""What a text means: a kind, how it looks, and how it stands to other places, as plain data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

Compass = Literal["north", "east", "south", "west"]
COMPASS: tuple[Compass, ...] = ("north", "east", "south", "west")
"""Clockwise from above."""
Grade = Literal["naming", "relation", "chain"]
GRADES: tuple[Grade, ...] = ("naming", "relation", "chain")


@dataclass(frozen=True, kw_only=True, slots=True)
class Description:
    """What `the ...` in a text means."""

    kind: str
    """Key of `NOUNS`."""
    colour: str | None = None
    """Adjective of a colour; None for any."""
    form: str | None = None
    """Form by a key of `FORM_WORDS`; None for any."""
    storey: int | None = None
    """Storey of its building, 0 for the lowest one; None for any."""
    links: tuple[Link, ...] = ()
    """Relations to other places; all of them hold."""

    @property
    def is_plain(self) -> bool:
        """Whether it has no relation."""
        return not self.links


@dataclass(frozen=True, slots=True)
class Has:
    """So many of a kind stand on the place, or in it."""

    count: int
    kind: str


@dataclass(frozen=True, slots=True)
class On:
    """It stands on another place, or in a room."""

    host: Description


@dataclass(frozen=True, slots=True)
class Of:
    """It is the roof of a building."""

    whole: Description


@dataclass(frozen=True, slots=True)
class Beside:
    """It is within arm's reach of something, level with it."""

    mark: Description


@dataclass(frozen=True, slots=True)
class Toward:
    """It lies on one side of something, by compass, and not far from it."""

    direction: Compass
    mark: Description


@dataclass(frozen=True, slots=True)
class Between:
    """It lies between two others."""

    first: Description
    second: Description


@dataclass(frozen=True, slots=True)
class Nearest:
    """Of all that the rest of the description fits it is clearly the nearest to something."""

    mark: Description


Link: TypeAlias = Has | On | Of | Beside | Toward | Between | Nearest


def grade_of(description: Description) -> Grade:
    """Grade of a text by what it means: naming, one relation, or a chain of them."""
    match description.links:
        case ():
            return "naming"
        case (link,):
            return "relation" if all(mark.is_plain for mark in marks_of(link)) else "chain"
        case _:
            return "chain"


def marks_of(link: Link) -> tuple[Description, ...]:
    """Descriptions that a relation refers to."""
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
