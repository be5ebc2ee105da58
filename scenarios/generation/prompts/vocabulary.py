"""The vocabulary of prompts: things and places with their words, read from the tables beside it.

The tables are TOML, so that a word can be added without a line of code. Every category of the
catalogue is a thing by itself; `things.toml` adds synonyms, and things of several objects.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

import msgspec

from aeroscene.scene.catalogue import (
    COVERS,
    FLOORS,
    LEAFY,
    ROOFS,
    ROOMS,
    ROUND,
    TWO_SIDED,
    WATER,
    by_name,
)
from scenarios.generation.prompts.wishes import Relation, RelationName, named, spoken

_FOLDER = Path(__file__).parent
_ES = ("s", "x", "z", "ch", "sh")  # endings of nouns whose plural ends in -es
_SAME = frozenset(("grass", "steps", "greenery", "railings", "parking"))
"""Nouns that are their own plural."""


class Part(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Objects that must stand about the heart of a thing, such as chairs about a table."""

    thing: str
    least: int
    relation: RelationName | None = None
    """Relation to the heart; None is any place within the distance, at its level or beneath it."""
    within_m: float = 0.0


class Thing(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A thing that can be asked for and found in a scene; `things.toml` explains the fields."""

    words: tuple[str, ...] = ()
    hearts: tuple[str, ...] = ()
    form: str = ""
    use: tuple[str, ...] = ()
    parts: tuple[Part, ...] = ()
    cluster_m: float = 0.0
    least: int = 1
    long: float = 1.0
    least_m: float = 0.0
    themes: tuple[str, ...] = ()


class Place(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A theme and its words; `themes.toml` explains the fields."""

    words: tuple[str, ...]
    weak: tuple[str, ...] = ()
    nearest: tuple[str, ...] = ()
    things: dict[str, str] = {}
    is_indoor: bool = False


@cache
def things() -> Mapping[str, Thing]:
    """Return all things by name: every category, and those that the table adds."""
    table = msgspec.toml.decode((_FOLDER / "things.toml").read_bytes(), type=dict[str, Thing])
    found = {name: table.get(name, Thing()) for name in by_name()}
    # A thing whose category a later catalogue drops is left out, rather than failing to load.
    return found | {name: each for name, each in table.items() if _is_known(name, table)}


@cache
def places() -> Mapping[str, Place]:
    """Return the words of each theme, by the theme's name."""
    return msgspec.toml.decode((_FOLDER / "themes.toml").read_bytes(), type=dict[str, Place])


@cache
def categories_of(name: str) -> frozenset[str]:
    """Return the categories of the objects that may be the heart of a thing.

    Args:
        name: Name of the vocabulary.
    """
    thing = things()[name]
    if not thing.hearts:
        return frozenset({name})
    return frozenset[str]().union(*map(categories_of, thing.hearts))


@cache
def has_front(name: str) -> bool:
    """Return true if a thing has a front, so that something can be in front of it or behind it.

    Args:
        name: Name of the vocabulary.
    """
    thing = things()[name]
    frontless = COVERS | LEAFY | ROUND | TWO_SIDED
    return not thing.cluster_m and categories_of(name).isdisjoint(frontless)


def unmeasurable(wish: Relation) -> str | None:
    """Return why a relation cannot be measured, None if it can.

    Args:
        wish: Relation whose names are in the vocabulary. For example, nothing is behind a tree.
    """
    if wish.relation in {"in_front_of", "behind"} and not has_front(wish.host):
        return f"{named(wish.host)} has no front"
    if wish.relation == "facing" and not has_front(wish.thing):
        return f"{named(wish.thing)} has no front"
    return None


@cache
def domains_of(name: str) -> frozenset[str]:
    """Return the domains in which a thing may stand, by the supports of its hearts.

    Args:
        name: Name of the vocabulary.

    Returns:
        "indoor", "outdoor" or both.
    """
    found: set[str] = set()
    for category in categories_of(name):
        carried_by = set(by_name()[category].supports)
        if carried_by & (FLOORS | {"furniture"}) or things()[name].use or category in ROOMS:
            found.add("indoor")
        if carried_by & (ROOFS | WATER | {"ground"}):
            found.add("outdoor")
    return frozenset(found)


def phrases(name: str, words: Sequence[str]) -> dict[str, bool]:
    """Return the words for a thing, each with whether it is a plural.

    Args:
        name: Name of the thing, which is one of its words.
        words: Its other words in the singular.
    """
    own = [spoken(name), *words]
    return {plural(each): True for each in own} | dict.fromkeys(own, False)


def plural(words: str) -> str:
    """Return the plural of a noun phrase.

    The noun is the last word before `of`, `with` or `and`: "row of trees" becomes "rows of trees".

    Args:
        words: Noun phrase in the singular.
    """
    for joint in (" of ", " with ", " and "):
        head, found, rest = words.partition(joint)
        if found:
            return f"{plural(head)}{joint}{rest}"
    # Only the last word changes: "street lamp" becomes "street lamps".
    before, _, noun = words.rpartition(" ")
    if noun in _SAME:
        many = noun
    elif noun.endswith(("elf", "leaf")):
        many = f"{noun[:-1]}ves"
    elif noun.endswith(_ES):
        many = f"{noun}es"
    elif noun.endswith("y") and noun[-2:-1] not in "aeiou":
        many = f"{noun[:-1]}ies"
    else:
        many = f"{noun}s"
    return f"{before} {many}".strip()


def _is_known(name: str, table: Mapping[str, Thing]) -> bool:
    thing = table[name]
    if not thing.hearts:
        return name in by_name()
    # A thing is known if everything that it is made of is known, down to the catalogue.
    others = (*thing.hearts, *(part.thing for part in thing.parts))
    return all(
        other in by_name() or (other in table and _is_known(other, table)) for other in others
    )
