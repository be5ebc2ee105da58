"""References from which heights and sizes count, chosen kind by kind by the least spread.

A roof is longer than its house by a fixed amount, a crate has its own length in metres, and a rail
stands on the top of the gallery beside it. No single reference suits all of them. For each group of
kinds this module takes the reference from which the training numbers vary least, because such
numbers are the easiest to draw.
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
"""Another reference than the first is taken if it leaves at most this share of the spread."""


def group_of(kind: Kind) -> Hashable:
    """Return the key of kinds whose numbers have the same meaning."""
    common = kind.node, *kind.what, kind.relation
    if not isinstance(kind, UnitKind):
        return common
    # Pinned and free axes have different units, so they belong to different groups.
    pins = kind.gap == "FREE", kind.align == "FREE", kind.turn == 4
    return *common, kind.is_on_top, kind.is_group, pins


@dataclass(frozen=True, slots=True)
class References:
    """Reference of each of `REFERENCED`, by group of kinds."""

    by_group: Mapping[Hashable, tuple[int, ...]]

    def of(self, kind: Kind) -> tuple[int, ...]:
        """Return the references of a kind; the first ones for a group that the corpus lacks."""
        found = self.by_group.get(group_of(kind), (0,) * len(REFERENCED))
        if kind.category in STAIRS and kind.relation == "SIDE":
            # Stairs end at the level that they lead to, even if the corpus has few of them.
            return (*found[:3], 2)
        return found


def measure_references(programs: Sequence[EncodedProgram]) -> References:
    """Choose the references that leave the least spread, group by group."""
    rows: defaultdict[Hashable, list[np.ndarray]] = defaultdict(list)
    for each in programs:
        for kind, choices in zip(each.program.kinds, each.choices, strict=True):
            if isinstance(kind, UnitKind):
                rows[group_of(kind)].append(choices)
    found = {key: _least(np.array(some)) for key, some in rows.items() if len(some) >= MIN_COUNT}
    return References(found)


def _least(choices: Float[np.ndarray, "k 4 4"]) -> tuple[int, ...]:
    """Return for each number the reference with the least spread, in metres."""
    found: list[int] = []
    for number in range(choices.shape[1]):
        values = choices[:, number]
        spread = np.where(np.isnan(values).any(axis=0), np.inf, values.std(axis=0))
        if number:  # The first two references of an extent are logs.
            # Times the mean extent, a spread of logs is one of metres and can be compared.
            spread[:2] *= np.exp(values[:, 0]).mean()
        best = int(np.argmin(spread))
        found.append(best if spread[best] < _BETTER * spread[0] else 0)
    return tuple(found)


def with_references(encoded: EncodedProgram, references: References) -> Program:
    """Return a scene's program whose numbers count from these references.

    Args:
        encoded: Program with the values from every reference.
        references: Reference of each group of kinds.
    """
    program = encoded.program
    table: Int[np.ndarray, "n 4"] = np.array([references.of(kind) for kind in program.kinds])
    chosen = np.take_along_axis(encoded.choices, table[:, :, None], axis=2)[:, :, 0]
    # A reference that does not exist, such as an absent bearer's extents,
    # gives NaN: the first counts.
    missing = np.isnan(chosen)
    table = np.where(missing, 0, table)
    chosen = np.where(missing, encoded.choices[:, :, 0], chosen)
    channels = program.channels.copy()
    for row, kind in enumerate(program.kinds):
        if isinstance(kind, UnitKind):
            channels[row, REFERENCED] = chosen[row]
            # Copied extents have no numbers of their own.
            channels[row, [SIZE.start + axis for axis in AS_LAST_AXES[kind.as_last]]] = np.nan
    return replace(program, channels=channels, references=table)
