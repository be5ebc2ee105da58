"""All methods by name, with one interface: fit on scenes, then sample scenes.

    fitted = fit("atiss", lessons, watcher)
    scene = fitted.sample(seed=7, domain="outdoor")

The methods, by name:

- `random`: objects drawn from the marginals of training, each on its own
- `atiss`, `diffusion_sdf`, `diffuscene`, `physcene`: re-implementations from their papers
- `paper`, `progressive`: the AeroScene paper's method, our presets of that name
- `ours`: our default preset
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Protocol

from aeroscene.learning.baselines.atiss import Atiss
from aeroscene.learning.baselines.diffuscene import DiffuScene
from aeroscene.learning.baselines.diffusion_sdf import DiffusionSdf
from aeroscene.learning.baselines.fitting import (
    BASELINE_TRAINING,
    Lessons,
    Spent,
    fit_baseline,
)
from aeroscene.learning.baselines.layouts import LayoutCode
from aeroscene.learning.baselines.marginals import Marginals
from aeroscene.learning.baselines.model import BaselineCfg, BaselineModel
from aeroscene.learning.baselines.physcene import PhyScene
from aeroscene.learning.baselines.presets import fit_preset
from aeroscene.learning.training.config import TrainCfg, TrainingError
from aeroscene.learning.training.course import Watcher
from aeroscene.scene import Scene, SceneDomain


class Fitted(Protocol):
    """A trained method."""

    @property
    def spent(self) -> Spent | None:
        """Cost of its training; None if it has none, or if somebody else trained it."""
        ...

    def sample(self, seed: int, domain: SceneDomain) -> Scene:
        """Draw the scene of a seed, without areas; every call gives the same scene.

        Raises:
            SceneError: If the domain was not trained on, or a number is not finite.
        """
        ...


@dataclass(frozen=True, kw_only=True)
class Method:
    """A method to compare."""

    name: str
    title: str
    source: str
    training: str
    """Name of the method whose training it shares; for most, its own name."""
    fit: Callable[[Lessons, BaselineCfg, Watcher], Fitted]


@dataclass(frozen=True, eq=False)
class _FittedMarginals:
    marginals: Marginals
    spent: Spent | None = None

    def sample(self, seed: int, domain: SceneDomain) -> Scene:
        return self.marginals.sample(seed, domain)


def _baseline(
    name: str,
    title: str,
    source: str,
    make: Callable[[LayoutCode, BaselineCfg], BaselineModel],
    training: str = "",
    training_cfg: TrainCfg = BASELINE_TRAINING,
) -> Method:
    # Methods with one training share its folder and cost.
    shared = training or name
    return Method(
        name=name,
        title=title,
        # Tables must not suggest that these are the authors' own programs.
        source=f"re-implementation from {source}",
        training=shared,
        fit=lambda lessons, cfg, watcher: fit_baseline(
            shared, make, lessons, cfg, watcher, training_cfg=training_cfg
        ),
    )


_SMALL_BATCHES = replace(BASELINE_TRAINING, batch_size=8)
"""Settings of a diffusion over all slots: half the batch gives twice the steps in the same time."""
_ALL = (
    Method(
        name="random",
        training="random",
        title="random from training marginals",
        source="aeroscene.learning.baselines.marginals",
        fit=lambda lessons, cfg, watcher: _FittedMarginals(Marginals(lessons.train)),  # noqa: ARG005
    ),
    _baseline("atiss", "ATISS", "Paschalidou et al. 2021", Atiss),
    _baseline("diffusion_sdf", "Diffusion-SDF for layouts", "Chou et al. 2023", DiffusionSdf),
    _baseline(
        "diffuscene", "DiffuScene", "Tang et al. 2024", DiffuScene, training_cfg=_SMALL_BATCHES
    ),
    # PhyScene differs from DiffuScene in its sampler only, so both share one training.
    _baseline(
        "physcene",
        "PhyScene",
        "Yang et al. 2024",
        PhyScene,
        training="diffuscene",
        training_cfg=_SMALL_BATCHES,
    ),
    Method(
        name="paper",
        training="paper",
        title="the AeroScene paper's",
        source="our preset paper",
        fit=lambda lessons, cfg, watcher: fit_preset("paper", lessons, watcher),  # noqa: ARG005
    ),
    Method(
        name="progressive",
        training="progressive",
        title="the AeroScene paper's, coarse first",
        source="our preset progressive",
        fit=lambda lessons, cfg, watcher: fit_preset("progressive", lessons, watcher),  # noqa: ARG005
    ),
    Method(
        name="ours",
        training="ours",
        title="ours",
        source="our default preset",
        fit=lambda lessons, cfg, watcher: fit_preset("default", lessons, watcher),  # noqa: ARG005
    ),
)
METHODS: Mapping[str, Method] = {method.name: method for method in _ALL}
"""Methods by name, in the order of the table."""


def fit(name: str, lessons: Lessons, watcher: Watcher, cfg: BaselineCfg | None = None) -> Fitted:
    """Train a method within its budget, from where it was stopped.

    Args:
        name: One of `METHODS`.
        lessons: Scenes, budget and folder.
        watcher: Reports progress, and may stop the training.
        cfg: Size and sampling of a baseline; our own presets ignore it.

    Raises:
        TrainingError: If there is no such method, or its folder holds another training.
        OSError: If a file cannot be written.
    """
    if name not in METHODS:
        raise TrainingError(f"method is {name!r}; valid: {', '.join(METHODS)}")
    return METHODS[name].fit(lessons, cfg or BaselineCfg(), watcher)
