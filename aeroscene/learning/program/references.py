"""From what heights and sizes count, kind by kind: what varies least over a corpus.

A roof is so much longer than its house, a crate so many metres long, a rail stands on the top of
the gallery beside it: which of these a kind is, its own numbers say.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from aeroscene.learning.program.encoding.encode import EncodedProgram
from aeroscene.learning.program.kinds import AS_LAST_AXES, Kind, UnitKind
from aeroscene.learning.program.program import REFERENCED, SIZE, Program
from aeroscene.scene.catalogue import STAIRS

MIN_COUNT = 5
"""Groups of fewer tokens count from their bearer alone."""
_BETTER = 0.7
"""Another reference than the first leaves at most this share of its spread."""


def group_of(kind: Kind) -> Hashable:
    """What kinds have in common whose numbers mean the same."""
    common = kind.node, *kind.what, kind.relation
    if not isinstance(kind, UnitKind):
        return common
    pins = kind.gap == "FREE", kind.align == "FREE", kind.turn == 4
    return *common, kind.is_on_top, kind.is_group, pins


@dataclass(frozen=True, slots=True)
class References:
    """The reference of each of `REFERENCED`, by the group of a kind."""

    by_group: Mapping[Hashable, tuple[int, ...]]

    def of(self, kind: Kind) -> tuple[int, ...]:
        """Those of a kind; the first ones of a group that the corpus has not."""
        found = self.by_group.get(group_of(kind), (0,) * len(REFERENCED))
        if kind.category in STAIRS and kind.relation == "SIDE":
            # Stairs end at the level that they lead to, however few the corpus has.
            return (*found[:3], 2)
        return found


def measure_references(programs: Sequence[EncodedProgram]) -> References:
    """The references that leave least to say."""
    rows: defaultdict[Hashable, list[np.ndarray]] = defaultdict(list)
    for each in programs:
        for kind, choices in zip(each.program.kinds, each.choices, strict=True):
            if isinstance(kind, UnitKind):
                rows[group_of(kind)].append(choices)
    found = {key: _least(np.array(some)) for key, some in rows.items() if len(some) >= MIN_COUNT}
    return References(found)


def _least(choices: Float[np.ndarray, "k 4 4"]) -> tuple[int, ...]:
    """For each number the reference with the least spread, in metres."""
    found: list[int] = []
    for number in range(choices.shape[1]):
        values = choices[:, number]
        spread = np.where(np.isnan(values).any(axis=0), np.inf, values.std(axis=0))
        if number:  # Logs of extents.
            spread[:2] *= np.exp(values[:, 0]).mean()
        best = int(np.argmin(spread))
        found.append(best if spread[best] < _BETTER * spread[0] else 0)
    return tuple(found)


def with_references(encoded: EncodedProgram, references: References) -> Program:
    """A scene's program whose numbers count from these."""
    program = encoded.program
    table: Int[np.ndarray, "n 4"] = np.array([references.of(kind) for kind in program.kinds])
    chosen = np.take_along_axis(encoded.choices, table[:, :, None], axis=2)[:, :, 0]
    # What is missing, as the extents of nothing are, counts from the first.
    missing = np.isnan(chosen)
    table = np.where(missing, 0, table)
    chosen = np.where(missing, encoded.choices[:, :, 0], chosen)
    channels = program.channels.copy()
    for row, kind in enumerate(program.kinds):
        if isinstance(kind, UnitKind):
            channels[row, REFERENCED] = chosen[row]
            # What is as it was the last time has no numbers of its own.
            channels[row, [SIZE.start + axis for axis in AS_LAST_AXES[kind.as_last]]] = np.nan
    return replace(program, channels=channels, references=table)
