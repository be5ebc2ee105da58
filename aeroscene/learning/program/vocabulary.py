"""Kinds of tokens counted on a corpus, arrays of groups, and looks of objects."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import msgspec
import numpy as np

from aeroscene.learning.program.kinds import Kind, What
from aeroscene.learning.program.program import Program, Shape
from aeroscene.scene import AttributeValue


@dataclass(frozen=True)
class ProgramVocabulary:
    """The symbols of a corpus; equal corpora give equal vocabularies."""

    kinds: tuple[Kind, ...]
    counts: tuple[int, ...]
    """Number of occurrences of each kind in the corpus."""
    shapes: tuple[Shape, ...]
    """Arrays of groups, the commonest first; a single object's is always the first."""
    looks: Mapping[What, tuple[tuple[dict[str, AttributeValue], int], ...]]
    """Looks of objects by key, each with its count."""

    @cached_property
    def number(self) -> Mapping[Kind, int]:
        """Numbers of the kinds."""
        return {kind: index for index, kind in enumerate(self.kinds)}

    @cached_property
    def shape_number(self) -> Mapping[Shape, int]:
        """Numbers of the arrays."""
        return {shape: index for index, shape in enumerate(self.shapes)}

    @cached_property
    def traits(self) -> tuple[frozenset[str], ...]:
        """Traits of each kind, which it shares with others."""
        return tuple(frozenset(kind.traits()) for kind in self.kinds)

    @cached_property
    def _of_category(self) -> Mapping[tuple[str, str], list[int]]:
        found: defaultdict[tuple[str, str], list[int]] = defaultdict(list)
        for index, kind in enumerate(self.kinds):
            found[kind.node, kind.category].append(index)
        return found

    def nearest(self, kind: Kind) -> int:
        """Return the number of a kind, or of the known kind that shares most with it.

        Raises:
            KeyError: If the corpus has no unit of the category, or nothing of the node.
        """
        if kind in self.number:
            return self.number[kind]
        traits = kind.traits()
        alike = self._of_category.get((kind.node, kind.category), [])
        if not alike and kind.node != "unit":
            alike = [i for i, other in enumerate(self.kinds) if other.node == kind.node]
        if not alike:
            raise KeyError(f"{kind.node} {kind.category}".strip())
        # Fewest different traits; then the commoner kind, then the first.
        return min(alike, key=lambda i: (len(traits ^ self.traits[i]), -self.counts[i], i))

    def nearest_shape(self, shape: Shape) -> int:
        """Return the number of an array, or of the known one nearest in rows."""
        if shape in self.shape_number:
            return self.shape_number[shape]
        size = shape.rows, shape.columns

        def far(index: int) -> tuple[int, int]:
            other = self.shapes[index]
            n_holes = abs(len(other.holes) - len(shape.holes))
            return sum(abs(a - b) for a, b in zip(size, other[:2], strict=True)), n_holes

        return min(range(len(self.shapes)), key=far)

    def with_looks(self, program: Program, rng: np.random.Generator) -> Program:
        """Draw the looks of a program's objects, as often as the corpus has them.

        Indoor objects of one key on one token look alike, such as the chairs of a room.
        """
        drawn: dict[tuple[What, int], dict[str, AttributeValue]] = {}
        looks: list[tuple[dict[str, AttributeValue], ...]] = []
        for place, kind in enumerate(program.kinds):
            choices = self.looks.get(kind.what)
            if not choices:
                looks.append(())
                continue
            # Places are unique, so that outdoor objects each draw their own.
            key = kind.what, int(program.parent[place]) if kind.domain == "indoor" else -place
            if key not in drawn:
                weights = np.array([count for _, count in choices], dtype=float)
                chosen = int(rng.choice(len(choices), p=weights / weights.sum()))
                drawn[key] = choices[chosen][0]
            looks.append((drawn[key],))
        return replace(program, looks=tuple(looks))


def count_program_kinds(programs: Iterable[Program]) -> ProgramVocabulary:
    """Count the vocabulary of a corpus."""
    kinds: Counter[Kind] = Counter()
    shapes: Counter[Shape] = Counter()
    looks: defaultdict[What, Counter[str]] = defaultdict(Counter)
    for program in programs:
        kinds.update(program.kinds)
        shapes.update(program.shapes)
        # Sorted keys, so that equal looks are equal texts.
        for kind, some in zip(program.kinds, program.looks, strict=True):
            texts = (msgspec.json.encode(dict(sorted(each.items()))).decode() for each in some)
            looks[kind.what].update(texts)
    # Sorted, so that the order of the scenes does not change the numbers.
    order = sorted(kinds, key=msgspec.json.encode)
    one = Shape()
    others = sorted((shape for shape in shapes if shape != one), key=lambda s: (-shapes[s], s))
    return ProgramVocabulary(
        kinds=tuple(order),
        counts=tuple(kinds[kind] for kind in order),
        shapes=(one, *others),
        looks={
            what: tuple(
                (msgspec.json.decode(text), count)
                for text, count in sorted(found.items(), key=lambda item: (-item[1], item[0]))
            )
            for what, found in sorted(looks.items(), key=lambda item: repr(item[0]))
            if found
        },
    )
