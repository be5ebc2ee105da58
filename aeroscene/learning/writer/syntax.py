"""The structure that programs keep: kinds of children of each kind, their numbers, required ones.

Classes are kinds that are the same thing, whatever their relation to a host. Records of partitions
state the number of their children. For all other tokens the limits are learned from the corpus.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Int

from aeroscene.learning.program.kinds import NODES, Kind, SplitKind, UnitKind
from aeroscene.learning.program.program import Program, Shape
from aeroscene.learning.program.vocabulary import ProgramVocabulary

FEW = 2
"""A parent that never had more than so many children of a class never gets more, because a building
has one roof. Children that came in greater numbers may be repeated without end."""
ENOUGH = 8
"""Tokens of a class that must have been seen before children that all of them have count as
required."""
_MANY = np.iinfo(np.int16).max


def required_children(kind: Kind) -> list[frozenset[str]]:
    """Return the nodes of a record's children, in order.

    A slice of three parts needs three nodes, for example. Tokens without requirements have none.
    """
    part, segment, item = (frozenset({name}) for name in ("part", "segment", "item"))
    match kind:
        case SplitKind(node="slice"):
            return [NODES] * kind.arity
        case SplitKind(node="cross" | "grid"):
            return [part] * (kind.arity + kind.rows) + [NODES] * (kind.arity * kind.rows)
        case Kind(node="pinwheel"):
            return [NODES] * 5
        case SplitKind(node="overlay"):
            return [NODES] + [item] * kind.arity
        case SplitKind(node="border"):
            return [segment] * kind.arity
        case Kind(node="item"):
            return [NODES]
        case _:
            return []


def count_objects(kind: Kind, shape: Shape) -> int:
    """Return the number of objects that a token stands for.

    The writer counts down how many objects are still wished for by it.

    Args:
        kind: Kind of the token.
        shape: Its array, which only a group has.
    """
    if isinstance(kind, UnitKind):
        return len(shape.array().cells(kind.to_relation(0).kind)) if kind.is_group else 1
    return int(kind.node in {"leaf", "lane", "segment"} and bool(kind.category))


@dataclass(frozen=True, eq=False)
class Syntax:
    """The structure that drawn programs keep."""

    vocabulary: ProgramVocabulary
    class_of: Int[np.ndarray, " kinds"]
    most: Int[np.ndarray, "classes classes"]
    """Most children of a class (column) that a token of a class (row) had."""
    always: Bool[np.ndarray, "classes categories"]
    """Categories of children that each class always has."""
    bears_fine: Bool[np.ndarray, " classes"]
    """True for coarse classes that had fine children."""
    most_children: Int[np.ndarray, " classes"]
    has_shape: Bool[np.ndarray, "families shapes"]
    """Arrays that the units of each family had, see `families_of`."""

    def shapes(self, kind: int) -> Bool[np.ndarray, " shapes"]:
        """Return the arrays that a token of a kind may have."""
        return self.has_shape[self._family_of[kind]]

    @cached_property
    def _family_of(self) -> Int[np.ndarray, " kinds"]:
        return families_of(self.vocabulary)

    @cached_property
    def is_coarse(self) -> Bool[np.ndarray, " kinds"]:
        """True for kinds of the coarse part."""
        return np.array([kind.is_coarse for kind in self.vocabulary.kinds])

    @cached_property
    def is_start(self) -> Bool[np.ndarray, " kinds"]:
        """True for kinds that are start pads."""
        return np.array(
            [bool(dict(kind.attributes).get("is_start")) for kind in self.vocabulary.kinds]
        )

    @cached_property
    def what(self) -> Int[np.ndarray, " kinds"]:
        """Number of the key of each kind, whatever its relation to a host."""
        number: dict[object, int] = {}
        return np.array([number.setdefault(k.what, len(number)) for k in self.vocabulary.kinds])

    @cached_property
    def is_as_last(self) -> Bool[np.ndarray, " kinds"]:
        """True for kinds that copy an extent of the last object of their key."""
        kinds = self.vocabulary.kinds
        return np.array([isinstance(kind, UnitKind) and bool(kind.as_last) for kind in kinds])

    @cached_property
    def category(self) -> Int[np.ndarray, " kinds"]:
        """Number of the category of each kind, by name."""
        names = [kind.category for kind in self.vocabulary.kinds]
        return np.unique(names, return_inverse=True)[1]

    @cached_property
    def node(self) -> tuple[str, ...]:
        """The node of each kind."""
        return tuple(kind.node for kind in self.vocabulary.kinds)

    @cached_property
    def required(self) -> tuple[tuple[frozenset[str], ...], ...]:
        """`required_children` of each kind."""
        return tuple(tuple(required_children(kind)) for kind in self.vocabulary.kinds)

    @cached_property
    def cap(self) -> Int[np.ndarray, "classes kinds"]:
        """Greatest number of children of a kind's class that a token of a class may have."""
        # More than FEW in the corpus means: as many as you like.
        many = np.where(self.most <= FEW, self.most, _MANY)
        return many[:, self.class_of]

    def fits(self, nodes: frozenset[str]) -> Bool[np.ndarray, " kinds"]:
        """Return the kinds of some nodes."""
        if nodes not in self._fits:
            # Asked for at every token of a draw, so the answer is kept.
            self._fits[nodes] = np.isin(np.array(self.node), sorted(nodes))
        return self._fits[nodes]

    @cached_property
    def _fits(self) -> dict[frozenset[str], Bool[np.ndarray, " kinds"]]:
        return {}

    @cached_property
    def fits_record(self) -> Bool[np.ndarray, " kinds"]:
        """True for kinds of the nodes that records require."""
        return self.fits(NODES | {"part", "segment", "item"})


def learn_syntax(vocabulary: ProgramVocabulary, programs: Iterable[Program]) -> Syntax:
    """Learn the structure of a corpus.

    Args:
        vocabulary: Kinds and arrays of the corpus.
        programs: Its programs.
    """
    class_of = classes_of(vocabulary)
    categories = np.unique([kind.category for kind in vocabulary.kinds]).tolist()
    number_of = {name: number for number, name in enumerate(categories)}
    n = int(class_of.max()) + 1
    most = np.zeros((n, n), dtype=np.int16)
    n_with, n_seen = np.zeros((n, len(categories)), dtype=int), np.zeros(n, dtype=int)
    bears, most_children = np.zeros(n, dtype=bool), np.zeros(n, dtype=int)
    family_of = families_of(vocabulary)
    has_shape = np.zeros((int(family_of.max()) + 1, len(vocabulary.shapes)), dtype=bool)
    for program in programs:
        kinds = [vocabulary.nearest(kind) for kind in program.kinds]
        own = class_of[kinds]
        # Every array that a family had somewhere may be drawn for it again.
        has_shape[family_of[kinds], [vocabulary.nearest_shape(s) for s in program.shapes]] = True
        children = program.children()
        for place, below in enumerate(children):
            n_seen[own[place]] += 1
            n_with[own[place], sorted({number_of[program.kinds[i].category] for i in below})] += 1
            most_children[own[place]] = max(most_children[own[place]], len(below))
            for each, count in Counter(own[below].tolist()).items():
                most[own[place], each] = max(most[own[place], each], count)
            if place < program.n_coarse:
                bears[own[place]] |= any(i >= program.n_coarse for i in below)
    always = (n_with == n_seen[:, None]) & (n_seen[:, None] >= ENOUGH)
    # Tokens without a category, such as widths, are never required.
    always[:, number_of.get("", 0)] &= False
    return Syntax(
        vocabulary=vocabulary,
        class_of=class_of,
        most=most,
        always=always,
        bears_fine=bears,
        most_children=most_children,
        has_shape=has_shape,
    )


def classes_of(vocabulary: ProgramVocabulary) -> Int[np.ndarray, " kinds"]:
    """Return the class of each kind."""
    return _numbered([(kind.node, *kind.what) for kind in vocabulary.kinds])


def families_of(vocabulary: ProgramVocabulary) -> Int[np.ndarray, " kinds"]:
    """Return the family of each kind.

    Kinds of a family are equal objects in the same relation, alone or in a group; they share
    arrays.
    """
    return _numbered([(k.node, *k.what, k.relation, k.is_group) for k in vocabulary.kinds])


def _numbered(keys: Sequence[tuple[object, ...]]) -> Int[np.ndarray, " kinds"]:
    number = {key: index for index, key in enumerate(sorted(set(keys), key=repr))}
    return np.array([number[key] for key in keys])
