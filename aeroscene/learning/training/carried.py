"""Weights of a model in another language, with which a training can begin.

A model that knows one corpus learns another in less time. Its networks have a row for each kind,
trait and array of its own language. For the new language's kinds and arrays the row of the nearest
old one is taken; everything else stays the same.

The languages may be of two catalogues. Categories are matched by name. Kinds of a category that the
first catalogue lacks begin with the mean of all vectors, and its traits with zeros.

The paper's presets have no language. Their networks see categories of the catalogue and
standardised channels, so their weights are taken as they are; statistics are those of the new data.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from aeroscene.learning.program.kinds import Kind
from aeroscene.learning.program.vocabulary import ProgramVocabulary
from aeroscene.learning.training.checkpoint import Known, Weights, read_checkpoint
from aeroscene.learning.training.checkpoint_facts import FLAT_PRESETS, CheckpointError, Part
from aeroscene.learning.training.config import Preset
from aeroscene.learning.training.presets import Sections, sections_from_plain
from aeroscene.learning.writer.language import Language

_BY_ARRAY = {"writer": "numbers.5.weight", "denoiser": "embedding.extra.2.weight"}
"""Weights with one row for each array of groups."""
_ARRAYS_LAST = ("rest.3.weight", "rest.3.bias")
"""Weights whose last rows are for the arrays of groups."""
_NETWORKS: Mapping[Part, str] = {"writer": "writer", "contents": "contents", "denoiser": "model"}
"""Section of the network of each part that can begin with other weights."""
_NO_SIZES = {"n_kinds", "dropout", "least_share", "trust"}
"""Fields of these sections that do not change the shapes of weights, or follow from the
language."""


@dataclass(frozen=True)
class Begun:
    """A model with which a training begins."""

    path: Path
    known: Known
    parts: Mapping[Part, Weights]
    sections: Sections

    def parts_for(self, known: Known, sections: Sections) -> dict[Part, Weights]:
        """Return its parts for networks of some sections, in the language of other data.

        Args:
            known: Language or statistics of the new training.
            sections: Sections of the new training.

        Raises:
            CheckpointError: If its networks have other sizes.
        """
        parts: dict[Part, Weights] = {}
        for part, weights in self.parts.items():
            name = _NETWORKS[part]
            own, other = (_sizes_of(each[name]) for each in (sections, self.sections))
            if own != other:
                raise CheckpointError(
                    f"checkpoint {str(self.path)!r} has a network of other sizes than [{name}]; "
                    f"valid: {other}"
                )
            if isinstance(self.known, Language) and isinstance(known, Language):
                old, new = self.known.vocabulary, known.vocabulary
                parts[part] = carried(part, weights, old, new)
            else:
                parts[part] = weights
        return parts


def read_begun(path: Path, preset: Preset = "default", *, any_catalogue: bool = True) -> Begun:
    """Read the model of a checkpoint.

    The semantic prior of the paper's presets is left out: it is trained anew in a minute.

    Args:
        path: File of the checkpoint.
        preset: Preset of the new training. Weights of `paper` and `progressive` fit each other.
        any_catalogue: True accepts the categories of an earlier catalogue. A training that keeps
            its language needs those of this one, and so do the paper's presets.

    Raises:
        CheckpointError: If it cannot be used, or has a preset with other networks.
    """
    is_flat = preset in FLAT_PRESETS
    found = read_checkpoint(path, any_catalogue=any_catalogue and not is_flat)
    if is_flat != (found.facts.preset in FLAT_PRESETS):
        valid = " or ".join(map(repr, sorted(FLAT_PRESETS))) if is_flat else "'default'"
        raise CheckpointError(
            f"checkpoint {str(path)!r} is of preset {found.facts.preset!r}; valid: {valid}"
        )
    parts = {part: weights for part, weights in found.parts.items() if part in _NETWORKS}
    return Begun(path, found.known, parts, sections_from_plain(found.facts.configs))


def _sizes_of(cfg: Any) -> dict[str, object]:
    """Return the fields of a network's section that decide the shapes of its weights."""
    names = {field.name for field in fields(cfg)}
    return {name: getattr(cfg, name) for name in sorted(names - _NO_SIZES)}


def carried(
    part: Part, weights: Mapping[str, Tensor], old: ProgramVocabulary, new: ProgramVocabulary
) -> Weights:
    """Carry weights of a part from one vocabulary to another.

    Kinds of a category that the old one lacks begin as the mean of its kinds.

    Args:
        part: Part of the model.
        weights: Its weights.
        old: Vocabulary that it was trained with.
        new: Vocabulary of the result.
    """
    rows = [_nearest(old, kind) for kind in new.kinds]
    arrays = [old.nearest_shape(shape) for shape in new.shapes]
    found: dict[str, Tensor] = {}
    for name, value in weights.items():
        whole = value.float()
        if name == "bias":
            # Several new kinds may stand for one old kind, whose probability
            # they share by their counts.
            found[name] = _rows(whole, rows) + _shares(rows, new)
        elif name == "embedding.own":
            # The writer's last row stands for "no kind".
            none = whole[len(old.kinds) :]
            found[name] = torch.cat([_rows(whole[: len(old.kinds)], rows), none])
        elif name == "embedding.shared":
            found[name] = _by_trait(whole, old, new)
        elif name == _BY_ARRAY[part]:
            found[name] = whole[arrays]
        elif name in _ARRAYS_LAST:
            n_others = len(whole) - len(old.shapes)
            found[name] = torch.cat([whole[:n_others], whole[n_others:][arrays]])
        else:
            found[name] = whole
    return found


def _nearest(old: ProgramVocabulary, kind: Kind) -> int:
    try:
        return old.nearest(kind)
    except KeyError:
        return -1


def _rows(value: Tensor, rows: list[int]) -> Tensor:
    """Return rows by number; the mean of all for -1."""
    return torch.cat([value, value.mean(0, keepdim=True)])[rows]


def _shares(rows: list[int], new: ProgramVocabulary) -> Tensor:
    """Return the log share of each new kind among those that stand for the same old kind."""
    counts = np.array(new.counts, dtype=float)
    numbers = np.array(rows)
    # One entry more, which -1 finds at the end.
    total = np.zeros(numbers.max() + 2)
    np.add.at(total, numbers, counts)
    return torch.from_numpy(np.log(counts / total[numbers])).float()


def _by_trait(value: Tensor, old: ProgramVocabulary, new: ProgramVocabulary) -> Tensor:
    """Return rows by the name of a trait; a new trait adds nothing at first."""
    names = [sorted(set().union(*each.traits)) for each in (old, new)]
    number = {name: index for index, name in enumerate(names[0])}
    empty = torch.zeros_like(value[0])
    return torch.stack([value[number[name]] if name in number else empty for name in names[1]])
