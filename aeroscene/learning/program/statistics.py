"""Mean and spread of each channel by kind, and programs as standardised arrays.

Kinds are many and often rare, so the moments of a kind are mixed with those of its group (kinds
whose numbers mean the same). The mixture is that of a prior worth `_PRIOR` tokens: a rare kind
takes the group's moments, a frequent one its own.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.learning.program.atoms import NO_ATOMS, Atoms, Reaches, atoms_of
from aeroscene.learning.program.clearances import Clearances, measure_clearances
from aeroscene.learning.program.companions import (
    ANY_COMPANIONS,
    Companions,
    measure_companions,
)
from aeroscene.learning.program.encoding.encode import EncodedProgram
from aeroscene.learning.program.kinds import UnitKind
from aeroscene.learning.program.program import COS, N_CHANNELS, SIN, Program
from aeroscene.learning.program.references import (
    References,
    group_of,
    measure_references,
    with_references,
)
from aeroscene.learning.program.skeleton import Skeleton
from aeroscene.learning.program.vocabulary import ProgramVocabulary, count_program_kinds
from aeroscene.scene import SceneDomain

_PRIOR = 4.0
"""The moments of a kind's group count as so many of its tokens."""
_LEAST_SPREAD = 3e-4
"""Channels that vary by less are constant."""
_PLAIN_SPREAD, _LEAST_WEIGHT = 0.1, 0.1
"""Channels that vary by this much or more, in m or shares, have full weight; others less, down to
`_LEAST_WEIGHT`."""
_HEADED = {"site", "storey", "item", "bend"}
"""Records with a heading in their channels 3 and 4."""
_LIMIT = 5.0
"""Values are clipped at so many spreads."""


@dataclass(frozen=True, slots=True, eq=False)
class ProgramStatistics:
    """Standardisation of channels by kind.

    Pinned channels vary by centimetres and are standardised by that, so that they keep their
    accuracy.
    """

    mean: Float[np.ndarray, "kinds channels"]
    spread: Float[np.ndarray, "kinds channels"]
    low: Float[np.ndarray, "kinds channels"]
    """Least value in training of a kind's group, standardised."""
    high: Float[np.ndarray, "kinds channels"]
    """Greatest value in training of a kind's group, standardised; beyond it a boat would leave its
    water."""
    is_free: Bool[np.ndarray, "kinds channels"]
    """True for channels that a kind has and that vary."""
    has: Bool[np.ndarray, "kinds channels"]
    """True for channels that a kind has."""
    references: References
    clearances: Clearances
    companions: Companions = ANY_COMPANIONS
    atoms: Atoms = NO_ATOMS

    @property
    def importance(self) -> Float[np.ndarray, "kinds channels"]:
        """Weight of an error in training, 0 to 1: low if a channel varies by millimetres."""
        return np.where(self.is_free, (self.spread / _PLAIN_SPREAD).clip(_LEAST_WEIGHT, 1.0), 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class ProgramExample:
    """A program as arrays: the tokens that the writer draws, and the channels that are diffused."""

    skeleton: Skeleton
    member: Int[np.ndarray, " n"]
    host: Int[np.ndarray, " n"]
    shape: Int[np.ndarray, " n"]
    """Number of the array of a group, in the vocabulary."""
    x0: Float[np.ndarray, "n channels"]
    """Standardised channels; 0 where a channel does not vary."""


def measure_programs(
    encoded: Sequence[EncodedProgram],
) -> tuple[ProgramVocabulary, ProgramStatistics]:
    """Return the vocabulary of a corpus, and the statistics of its channels."""
    vocabulary = count_program_kinds(each.program for each in encoded)
    references = measure_references(encoded)
    programs = [with_references(each, references) for each in encoded]
    ids = np.array([vocabulary.number[kind] for p in programs for kind in p.kinds])
    rows = np.concatenate([program.channels for program in programs])
    groups: defaultdict[Hashable, list[int]] = defaultdict(list)
    for number, kind in enumerate(vocabulary.kinds):
        groups[group_of(kind)].append(number)
    atoms: dict[Hashable, dict[int, Reaches]] = {}
    shape = len(vocabulary.kinds), N_CHANNELS
    mean, spread, low, high = (np.zeros(shape) for _ in range(4))
    has = np.zeros(shape, dtype=bool)
    for group, numbers in groups.items():
        common = rows[np.isin(ids, numbers)]
        # Atoms belong to groups, because single kinds are too rare to show them.
        atoms[group] = atoms_of(common, _with_atoms(vocabulary.kinds[numbers[0]].node))
        common_mean, common_var = _moments(common)
        for number in numbers:
            own = rows[ids == number]
            n = (~np.isnan(own)).sum(axis=0)
            own_mean, own_var = _moments(own)
            # The distance of the two means adds to the variance, as in a pooled variance.
            shift = n * _PRIOR / (n + _PRIOR) * (own_mean - common_mean) ** 2
            var = (n * own_var + _PRIOR * common_var + shift) / (n + _PRIOR)
            mean[number] = (n * own_mean + _PRIOR * common_mean) / (n + _PRIOR)
            spread[number] = np.sqrt(var)
            has[number] = n > 0
            _let_turn(mean[number], spread[number])
            # The range is the group's: a rare kind has too few tokens to limit itself.
            scaled = (common - mean[number]) / np.maximum(spread[number], _LEAST_SPREAD)
            scaled = np.nan_to_num(scaled)
            low[number], high[number] = scaled.min(axis=0), scaled.max(axis=0)
    is_free = has & (spread > _LEAST_SPREAD)
    statistics = ProgramStatistics(
        mean,
        np.maximum(spread, _LEAST_SPREAD),
        # The mean, which is 0 after standardising, is always within the range.
        low.clip(-_LIMIT, 0.0),
        high.clip(0.0, _LIMIT),
        is_free,
        has,
        references,
        measure_clearances([each.gaps for each in encoded]),
        measure_companions(
            [
                (kind, host)
                for each in encoded
                for kind, host in zip(each.program.kinds, each.hosts, strict=True)
                if isinstance(kind, UnitKind)
            ]
        ),
        Atoms({group: found for group, found in atoms.items() if found}),
    )
    return vocabulary, statistics


def _moments(rows: Float[np.ndarray, "k channels"]) -> tuple[np.ndarray, np.ndarray]:
    """Mean and variance of each channel, without NaN; 0 where no row has it."""
    n = np.maximum((~np.isnan(rows)).sum(axis=0), 1)
    mean = np.nansum(rows, axis=0) / n
    return mean, np.nansum((rows - mean) ** 2, axis=0) / n


def _let_turn(mean: Float[np.ndarray, " channels"], spread: Float[np.ndarray, " channels"]) -> None:
    """Leave the unit circle of headings that vary, in place."""
    # Standardised separately, cosine and sine would no longer form a circle.
    if spread[COS] > 0.3:
        mean[[COS, SIN]], spread[[COS, SIN]] = 0.0, 1.0


def to_example(
    encoded: EncodedProgram, vocabulary: ProgramVocabulary, statistics: ProgramStatistics
) -> ProgramExample:
    """Turn a scene's program into arrays; unknown kinds take the nearest one of the corpus.

    Args:
        encoded: The scene's program.
        vocabulary: Kinds and arrays of the corpus.
        statistics: Statistics of the corpus.

    Raises:
        KeyError: If the corpus has nothing of a category.
    """
    program = with_references(encoded, statistics.references)
    kind = np.array([vocabulary.nearest(each) for each in program.kinds])
    scaled = (program.channels - statistics.mean[kind]) / statistics.spread[kind]
    scaled = np.where(statistics.is_free[kind], np.nan_to_num(scaled), 0.0)
    return ProgramExample(
        skeleton=Skeleton(_domain(program.kinds[0].domain), kind, program.parent, program.n_coarse),
        member=program.member,
        host=program.host,
        shape=np.array([vocabulary.nearest_shape(shape) for shape in program.shapes]),
        x0=scaled.clip(-_LIMIT, _LIMIT),
    )


def from_example(
    example: ProgramExample, vocabulary: ProgramVocabulary, statistics: ProgramStatistics
) -> Program:
    """Turn arrays into a program, within the range of training; its looks are not drawn yet.

    Constant channels get their means.
    """
    kind, s = example.skeleton.kind_id, statistics
    kinds = tuple(vocabulary.kinds[number] for number in kind.tolist())
    x0 = np.where(s.is_free[kind], example.x0.clip(s.low[kind], s.high[kind]), 0.0)
    values = s.mean[kind] + x0 * s.spread[kind]
    return Program(
        kinds=kinds,
        parent=example.skeleton.parent,
        member=example.member,
        host=example.host,
        shapes=tuple(vocabulary.shapes[number] for number in example.shape.tolist()),
        channels=np.where(s.has[kind], values, np.nan),
        references=np.array([s.references.of(each) for each in kinds]),
        n_coarse=example.skeleton.n_coarse,
        clearances=s.clearances,
        companions=s.companions,
    )


def on_atoms(program: Program, atoms: Atoms) -> Program:
    """Put the numbers of a drawn program on atoms near them.

    Only drawn programs need this: a program that was read off a scene has exact numbers.
    """
    channels = program.channels.copy()
    for row, kind in zip(channels, program.kinds, strict=True):
        atoms.snap(group_of(kind), row)
    return program.with_channels(channels)


def _domain(name: str) -> SceneDomain:
    return "indoor" if name == "indoor" else "mixed" if name == "mixed" else "outdoor"


def _with_atoms(node: str) -> list[int]:
    """Return the channels in which tokens of a node may have atoms.

    Headings have none: their two channels belong together.
    """
    headings = {COS, SIN} if node in {"unit", "member"} else {3, 4} if node in _HEADED else set()
    return [channel for channel in range(N_CHANNELS) if channel not in headings]
