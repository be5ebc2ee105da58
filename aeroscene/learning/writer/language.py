"""Everything that is known of a corpus' programs: their symbols, their numbers, their structure.

A checkpoint stores a language as text and arrays, so that a model can be used without its corpus.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import msgspec
import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.learning.program.atoms import Atoms, Reaches
from aeroscene.learning.program.clearances import Clearances
from aeroscene.learning.program.companions import Bond, Companions, HostKey
from aeroscene.learning.program.encoding.cfg import WHOLE, EncodingCfg
from aeroscene.learning.program.encoding.encode import EncodedProgram
from aeroscene.learning.program.kinds import KINDS, Attributes, Kind, theme_of
from aeroscene.learning.program.program import Shape
from aeroscene.learning.program.references import References, group_of
from aeroscene.learning.program.statistics import ProgramStatistics, measure_programs
from aeroscene.learning.program.vocabulary import ProgramVocabulary
from aeroscene.learning.writer.syntax import Syntax, classes_of, families_of, learn_syntax
from aeroscene.scene import AttributeValue, SceneDomain

_MEASURED = ("mean", "spread", "low", "high")
_FLAGS = ("is_free", "has")


class _Looks(msgspec.Struct, array_like=True):
    category: str
    domain: str
    attributes: Attributes
    found: tuple[tuple[dict[str, AttributeValue], int], ...]


class _Document(msgspec.Struct, omit_defaults=True):
    kinds: tuple[dict[str, Any], ...]
    counts: tuple[int, ...]
    shapes: tuple[Shape, ...]
    looks: tuple[_Looks, ...]
    clearances: dict[str, tuple[float, float]]
    companions: dict[Bond, tuple[HostKey, ...]] = {}
    encoding: EncodingCfg = WHOLE


@dataclass(frozen=True, eq=False)
class Language:
    """The language of a corpus' programs: vocabulary, statistics and syntax."""

    vocabulary: ProgramVocabulary
    statistics: ProgramStatistics
    syntax: Syntax
    encoding: EncodingCfg = WHOLE
    """Details of scenes that its programs keep."""

    @property
    def themes(self) -> dict[SceneDomain, set[str]]:
        """Themes of the corpus, for each domain that has any."""
        themes: dict[SceneDomain, set[str]] = {}
        for kind in self.vocabulary.kinds:
            if theme := theme_of(kind):
                themes.setdefault(cast("SceneDomain", kind.domain), set()).add(theme)
        return themes

    def to_json(self) -> str:
        """Write the vocabulary as text."""
        known = self.vocabulary
        looks = tuple(_Looks(*what, tuple(found)) for what, found in known.looks.items())
        document = _Document(
            tuple(map(msgspec.to_builtins, known.kinds)),
            known.counts,
            known.shapes,
            looks,
            dict(self.statistics.clearances.by_category),
            {bond: tuple(hosts) for bond, hosts in self.statistics.companions.by_bond.items()},
            self.encoding,
        )
        return msgspec.json.encode(document).decode()

    def to_arrays(self) -> dict[str, np.ndarray]:
        """Return statistics and structure as arrays by name, for a checkpoint.

        Measured numbers are in single precision.
        """
        statistics, syntax = self.statistics, self.syntax
        arrays = {name: getattr(statistics, name).astype(np.float32) for name in _MEASURED}
        arrays |= {name: getattr(statistics, name) for name in _FLAGS}
        # Kinds of one group repeat the same row, which costs little and needs no table of groups.
        references = [statistics.references.of(kind) for kind in self.vocabulary.kinds]
        return arrays | {
            "references": np.array(references, dtype=np.int8),
            "most": syntax.most.astype(np.int16),
            "always": syntax.always,
            "bears_fine": syntax.bears_fine,
            "most_children": syntax.most_children.astype(np.int16),
            # As pairs of numbers, because few of the combinations occur.
            "has_shape": np.argwhere(syntax.has_shape).astype(np.int16),
            "atoms": self._atoms(),
        }

    def _atoms(self) -> Float[np.ndarray, "k 4"]:
        """Return every atom as first kind of its group, channel, value and reach."""
        by_group = self.statistics.atoms.by_group
        rows: list[tuple[float, float, float, float]] = []
        seen: set[Hashable] = set()
        for number, kind in enumerate(self.vocabulary.kinds):
            group = group_of(kind)
            if group in seen:
                continue
            seen.add(group)
            for channel, (values, reaches) in by_group.get(group, {}).items():
                pairs = zip(values.tolist(), reaches.tolist(), strict=True)
                rows += [(number, channel, value, reach) for value, reach in pairs]
        return np.array(rows, dtype=np.float32).reshape(-1, 4)

    @staticmethod
    def restored(text: str, arrays: Mapping[str, np.ndarray]) -> Language:
        """Restore a language from the results of `to_json` and `to_arrays`.

        Raises:
            msgspec.DecodeError: If the text is malformed.
            KeyError: If an array is missing.
        """
        document = msgspec.json.decode(text, type=_Document)
        looks = {(e.category, e.domain, e.attributes): e.found for e in document.looks}
        kinds = [msgspec.convert(k, KINDS.get(str(k.get("node")), Kind)) for k in document.kinds]
        vocabulary = ProgramVocabulary(tuple(kinds), document.counts, document.shapes, looks)
        rows = zip(kinds, arrays["references"].tolist(), strict=True)
        statistics = ProgramStatistics(
            **{name: arrays[name].astype(np.float64) for name in _MEASURED},
            **{name: arrays[name] for name in _FLAGS},
            references=References({group_of(kind): tuple(row) for kind, row in rows}),
            clearances=Clearances(document.clearances),
            companions=Companions(document.companions),
            # Older checkpoints have no atoms.
            atoms=_restored_atoms(kinds, arrays.get("atoms", np.zeros((0, 4)))),
        )
        syntax = Syntax(
            vocabulary=vocabulary,
            class_of=classes_of(vocabulary),
            most=arrays["most"],
            always=arrays["always"],
            bears_fine=arrays["bears_fine"],
            most_children=arrays["most_children"].astype(np.int64),
            has_shape=_restored_shapes(vocabulary, arrays.get("has_shape")),
        )
        return Language(vocabulary, statistics, syntax, document.encoding)


def _restored_shapes(
    vocabulary: ProgramVocabulary, pairs: Int[np.ndarray, "k 2"] | None
) -> Bool[np.ndarray, "families shapes"]:
    """Return the arrays that each family had; all of them if the checkpoint does not say."""
    n_families = int(families_of(vocabulary).max()) + 1
    found = np.full((n_families, len(vocabulary.shapes)), pairs is None)
    if pairs is not None:
        found[tuple(pairs.T)] = True
    return found


def _restored_atoms(kinds: Sequence[Kind], rows: Float[np.ndarray, "k 4"]) -> Atoms:
    """Return the atoms from the rows of `Language.to_arrays`."""
    found: defaultdict[Hashable, dict[int, Reaches]] = defaultdict(dict)
    ordered = rows[np.lexsort((rows[:, 1], rows[:, 0]))].astype(np.float64)
    is_next = (np.diff(ordered[:, :2], axis=0) != 0).any(axis=1)
    for own in np.split(ordered, np.flatnonzero(is_next) + 1) if len(rows) else ():
        number, channel = own[0, :2].astype(int).tolist()
        # Single precision would turn 2.35 m into 2.3499999; rounding restores the exact value.
        found[group_of(kinds[number])][channel] = own[:, 2].round(6), own[:, 3]
    return Atoms(found)


def learn_language(encoded: Sequence[EncodedProgram], encoding: EncodingCfg = WHOLE) -> Language:
    """Learn the language of an encoded corpus; equal corpora give equal languages."""
    vocabulary, statistics = measure_programs(encoded)
    syntax = learn_syntax(vocabulary, [each.program for each in encoded])
    return Language(vocabulary, statistics, syntax, encoding)
