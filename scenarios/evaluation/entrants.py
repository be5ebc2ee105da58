"""The rows of each table: real scenes, methods, methods without a part, damaged scenes.

A row is an `Entrant`: a name, a title, and a function that trains or loads what draws its scenes.
All kinds of rows have this one form, so the rest of the evaluation need not know them. Real scenes
are a row too, since a figure means little without the value that real scenes reach.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from aeroscene.learning.baselines.fitting import Lessons, Spent
from aeroscene.learning.baselines.model import BaselineCfg
from aeroscene.learning.baselines.presets import FittedPreset, fit_preset, shipped_preset, without
from aeroscene.learning.baselines.registry import METHODS, Fitted, fit
from aeroscene.learning.program import DecodingCfg, EncodingCfg
from aeroscene.learning.training.config import Preset
from aeroscene.learning.training.course import Watcher
from aeroscene.metrics.damage import DAMAGES
from aeroscene.scene import Scene, SceneDomain
from scenarios.evaluation.choices import SAMPLED, TRAINED
from scenarios.evaluation.sources import Data, EvaluationError

TableName = Literal["synthesis", "ablation", "choices", "damage"]


@dataclass(frozen=True, kw_only=True)
class Means:
    """Data, budget and settings that an entrant may use."""

    lessons: Callable[[str], Lessons]
    """Function from a method's name to its data, budget and folder."""
    cfg: BaselineCfg
    data: Data
    watcher: Watcher


@dataclass(frozen=True, kw_only=True)
class Entrant:
    """A row of a table."""

    name: str
    title: str
    begin: Callable[[Means], Fitted]
    """Function that trains or loads the method; called only if draws are missing."""
    is_real: bool = False
    """True if its scenes are those of the test split, which limits their number."""


@dataclass(frozen=True, eq=False)
class _Real:
    """Scenes of the test split by number, as they are or damaged on purpose."""

    scenes: Sequence[Scene]
    change: Callable[[Scene, np.random.Generator], Scene] | None = None
    spent: Spent | None = None

    def sample(self, seed: int, domain: SceneDomain) -> Scene:
        del domain  # A real scene has its own.
        scene = self.scenes[seed]
        return scene if self.change is None else self.change(scene, np.random.default_rng(seed))


def _trained(name: str) -> Entrant:
    return Entrant(
        name=name,
        title=METHODS[name].title,
        begin=lambda means: fit(
            name, means.lessons(METHODS[name].training), means.watcher, means.cfg
        ),
    )


def _real(name: str, title: str, change: Any = None) -> Entrant:
    return Entrant(
        name=name,
        title=title,
        begin=lambda means: _Real(means.data.test, change),
        is_real=True,
    )


GROUND_TRUTH = _real("ground_truth", "ground truth (test split)")
_SHIPPED = (
    Entrant(
        name="paper_shipped",
        title="the AeroScene paper's, as it ships",
        begin=lambda means: shipped_preset("paper"),  # noqa: ARG005
    ),
    Entrant(
        name="progressive_shipped",
        title="the AeroScene paper's, coarse first, as it ships",
        begin=lambda means: shipped_preset("progressive"),  # noqa: ARG005
    ),
    Entrant(
        name="ours_shipped",
        title="ours, as it ships",
        begin=lambda means: shipped_preset("default"),  # noqa: ARG005
    ),
)
"""Models that ship; they were trained for longer than a table allows, on other scenes of the same
grammar."""

_PRESETS: Mapping[str, Preset] = {
    "paper": "paper",
    "progressive": "progressive",
    "ours": "default",
}
_GUIDANCE: Mapping[str, Mapping[str, float]] = {
    "without_collision": {"collision_weight": 0.0},
    "without_coarse_to_fine": {"coarse_to_fine_weight": 0.0},
    "with_semantic": {"semantic_step_weight": 0.1},
    "without_all": {"collision_weight": 0.0, "coarse_to_fine_weight": 0.0},
}
_DECODING = {
    "without_collision": ("without making room", DecodingCfg(makes_room=False)),
    "without_semantic": ("without mending and turning", DecodingCfg(mends=False)),
    "without_all": ("without both", DecodingCfg(makes_room=False, mends=False)),
}
"""Steps of our decoder that can be switched off. Ours has no guidance: decoding does what its terms
are for. Nothing corresponds to "coarse to fine", because the places of fine objects exist only in
the frames of coarse ones."""


_ENCODING = {
    "without_partitions": EncodingCfg(has_partitions=False),
    "without_relations": EncodingCfg(has_relations=False),
    "without_either": EncodingCfg(has_partitions=False, has_relations=False),
}
"""Parts of a scene that programs leave out; each needs a training of its own."""


def _less_encoded(name: str, encoding: EncodingCfg) -> Entrant:
    method = f"ours_{name}"
    return Entrant(
        name=method,
        title=f"{METHODS['ours'].title}, {name.replace('_', ' ')}",
        begin=lambda means: fit_preset(
            "default", means.lessons(method), means.watcher, encoding=encoding
        ),
    )


def _trained_otherwise(name: str) -> Entrant:
    method, (words, changes) = f"ours_{name}", TRAINED[name]
    return Entrant(
        name=method,
        title=f"{METHODS['ours'].title}, {words}",
        begin=lambda means: fit_preset(
            "default", means.lessons(method), means.watcher, changes=changes
        ),
    )


def _sampled_otherwise(name: str, *, is_shipped: bool) -> Entrant:
    words, fields = SAMPLED[name]
    return Entrant(
        name=f"{_row_name('ours', is_shipped)}_{name}",
        title=f"ours, {words}",
        begin=lambda means: _changed("ours", means, is_shipped, {"sampler": fields}, DecodingCfg()),
    )


def _less_guided(
    method: str, name: str, weights: Mapping[str, float], *, is_shipped: bool
) -> Entrant:
    changes = {"guidance": weights}
    return Entrant(
        name=f"{_row_name(method, is_shipped)}_{name}",
        title=f"{METHODS[method].title}, {name.replace('_', ' ')} guidance",
        begin=lambda means: _changed(method, means, is_shipped, changes, DecodingCfg()),
    )


def _less_decoded(name: str, *, is_shipped: bool) -> Entrant:
    words, decoding = _DECODING[name]
    return Entrant(
        name=f"{_row_name('ours', is_shipped)}_{name}",
        title=f"ours, {words}",
        begin=lambda means: _changed("ours", means, is_shipped, {}, decoding),
    )


def _row_name(method: str, is_shipped: bool) -> str:
    return f"{method}_shipped" if is_shipped else method


def _changed(
    method: str, means: Means, is_shipped: bool, changes: Mapping[str, Any], decoding: DecodingCfg
) -> FittedPreset:
    preset = _PRESETS[method]
    if is_shipped:
        return without(None, preset, changes, decoding, None)
    # The changes concern sampling alone, so the training of the whole method serves them all.
    lessons = means.lessons(method)
    whole = fit(method, lessons, means.watcher, means.cfg)
    return without(lessons.folder, preset, changes, decoding, whole.spent)


def entrants_of(table: TableName, data: Data, names: Sequence[str]) -> list[Entrant]:
    """Return the rows of a table in its order.

    Args:
        table: Name of the table.
        data: Data of the table; shipped models take part for the corpus only.
        names: Rows to return; empty returns all.

    Raises:
        EvaluationError: If there is no row of a name.
    """
    found = [GROUND_TRUTH, *_others(table, data)]
    if not names:
        return found
    known = {entrant.name: entrant for entrant in found}
    for name in names:
        if name not in known:
            raise EvaluationError(
                f"methods {name!r} is no row of table {table}; valid: {', '.join(known)}"
            )
    # In the table's order, whatever the order of the names.
    return [entrant for entrant in found if entrant.name in names]


def _others(table: TableName, data: Data) -> list[Entrant]:
    if table == "damage":
        return [_real(name, name.replace("_", " "), change) for name, change in DAMAGES.items()]
    if table == "synthesis":
        # The models that ship know the corpus's grammar and no other data.
        return [*map(_trained, METHODS), *(_SHIPPED if data.is_corpus else ())]
    # For the corpus, the shipped models are taken apart, so that nobody has to train one first.
    is_shipped = data.is_corpus
    whole = {entrant.name: entrant for entrant in (*map(_trained, METHODS), *_SHIPPED)}
    sampled = whole[_row_name("ours", is_shipped)]
    if table == "choices":
        return [
            whole["ours"],
            *map(_trained_otherwise, TRAINED),
            *([sampled] if is_shipped else []),
            *(_sampled_otherwise(name, is_shipped=is_shipped) for name in SAMPLED),
        ]
    guided: list[Entrant] = []
    for method in ("paper", "progressive"):
        guided.append(whole[_row_name(method, is_shipped)])
        for name, weights in _GUIDANCE.items():
            guided.append(_less_guided(method, name, weights, is_shipped=is_shipped))
    return [
        *guided,
        sampled,
        *(_less_decoded(name, is_shipped=is_shipped) for name in _DECODING),
        *([whole["ours"]] if is_shipped else []),
        *(_less_encoded(name, encoding) for name, encoding in _ENCODING.items()),
    ]
