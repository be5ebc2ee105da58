"""Test of a network's capacity: it learns eight scenes by heart, as DiffuScene does beside it.

A network that cannot memorise cannot learn. Given the contents of a scene that it has seen a
thousand times, it has to put everything back where it was. A failure here points to the network or
the loss, whatever the data. DiffuScene draws the contents too, so each of its draws is compared
with the one of the eight scenes that it resembles most. Both get the same CPU time.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from jaxtyping import Float
from scipy.optimize import linear_sum_assignment

from aeroscene.learning.baselines.diffuscene import DiffuScene
from aeroscene.learning.baselines.layouts import LayoutCode, LayoutSet, layouts_of
from aeroscene.learning.baselines.model import BaselineCfg
from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.diffusion.loss import diffusion_loss
from aeroscene.learning.diffusion.sampling import sample
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.paper.boxes import FlatBoxes
from aeroscene.learning.paper.guidance.layout import FlatReader
from aeroscene.learning.paper.layouts import IS_TWO_SIDED, FlatLayout
from aeroscene.learning.paper.training_set import FlatTrainingSet, flat_training_set
from aeroscene.learning.training.batches.source import Batch, Batches
from aeroscene.learning.training.config import Budget, Preset, TrainCfg
from aeroscene.learning.training.loop import LossFunction, LossTerms, PartTraining, train_steps
from aeroscene.learning.training.networks import new_denoiser
from aeroscene.learning.training.paper_preset import paper_sampler
from aeroscene.learning.training.presets import preset_sections
from aeroscene.scene import Scene
from scenarios.bench.configs import BenchError
from scenarios.bench.row import Row, higher, lower

N_SCENES = 8
_N_OBJECTS = (12, 30)
"""Range of objects of the learned scenes; larger scenes take longer and show no more."""
MOST_PLACE_CM, MOST_EXTENT_PERCENT, MOST_HEADING_DEG = 5.0, 5.0, 3.0
_MISSING_M = 10.0
"""Distance that a missing object counts as, when the most similar scene is searched."""
_TRAINING = TrainCfg(
    batch_size=N_SCENES,
    optimiser="adam",
    learning_rate=1e-3,
    second_decay=0.99,
    weight_decay=0.0,
    schedule="cosine",
    warmup_steps=50,
)
_SEED = 3


def small_scenes(scenes: Sequence[Scene]) -> list[Scene]:
    """Return the first eight indoor scenes of 12 to 30 objects.

    Args:
        scenes: Scenes to choose from.

    Raises:
        BenchError: If there are not as many.
    """
    least, most = _N_OBJECTS
    found = [
        scene
        for scene in scenes
        if scene.domain == "indoor" and least <= len(scene.objects) <= most
    ][:N_SCENES]
    if len(found) < N_SCENES:
        raise BenchError(
            f"data have {len(found)} indoor scenes of {least} to {most} objects; valid: "
            f"{N_SCENES} or more; --cpu-seconds 0 leaves memorising out"
        )
    return found


def memorising_rows(preset: Preset, scenes: Sequence[Scene], cpu_s: float) -> Iterator[Row]:
    """Yield rows of a preset's network, then of DiffuScene's, after the same CPU time.

    Args:
        preset: Preset whose network learns.
        scenes: Scenes of which eight are learned.
        cpu_s: CPU time of each training.

    Raises:
        BenchError: If there are too few scenes that are small enough.
    """
    learned = small_scenes(scenes)
    real = layouts_of(learned)
    drawn, n_steps = _memorised_by_preset(preset, learned, cpu_s)
    yield higher(f"{preset}: steps on {N_SCENES} scenes", n_steps, "")
    yield from _Off.compare(drawn, real).rows(preset, has_target=True)
    drawn, n_steps = _memorised_by_diffuscene(learned, cpu_s)
    yield higher(f"DiffuScene: steps on {N_SCENES} scenes", n_steps, "")
    yield from _Off.compare(drawn, real).rows("DiffuScene", has_target=False)


def _memorised_by_preset(
    preset: Preset, scenes: Sequence[Scene], cpu_s: float
) -> tuple[list[FlatBoxes], int]:
    data = flat_training_set(scenes, has_regions=preset == "progressive")
    sections = preset_sections(preset)
    schedule = Schedule(sections["schedule"])
    # Weights are drawn from torch's global generator, which is restored afterwards.
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(_SEED)
        network = new_denoiser(sections["model"], data.statistics, schedule)
    passes = [data.in_pass(is_second=second) for second in _passes(data)]
    # Without L_guide, because memorising is a test of the reconstruction alone.
    cfg = replace(sections["loss"], guide_weight=0.0)

    def loss(model: Callable[..., Any], batch: Batch, generator: torch.Generator) -> LossTerms:
        assert isinstance(batch, TokenBatch)
        return vars(diffusion_loss(model, batch, schedule, cfg, generator))

    training = _train(network, lambda step: passes[step % len(passes)], loss, cpu_s)
    read = FlatReader(data.statistics)
    sampler = paper_sampler(has_regions=bool(data.statistics.has_regions))
    generator = torch.Generator().manual_seed(_SEED)
    boxes: list[list[FlatBoxes]] = [[] for _ in scenes]
    for batch in passes:
        layout = read(sample(network.eval(), batch, schedule, sampler, generator), batch)
        assert batch.given is not None
        is_drawn = batch.mask & ~batch.given
        yaw = torch.atan2(layout.heading[..., 1], layout.heading[..., 0])
        for i, own in enumerate(is_drawn):
            # In the progressive preset each pass draws a part of the objects; they are joined.
            parts = (layout.category[i], layout.center_enu_m[i], yaw[i], layout.size_m[i])
            boxes[i].append(FlatBoxes(*(part[own].numpy() for part in parts)))
    return [_joined(parts) for parts in boxes], training.step


def _passes(data: FlatTrainingSet) -> tuple[bool, ...]:
    return (False, True) if data.statistics.has_regions else (True,)


def _memorised_by_diffuscene(scenes: Sequence[Scene], cpu_s: float) -> tuple[list[FlatBoxes], int]:
    code = LayoutCode.from_scenes(scenes)
    batch = LayoutSet.from_scenes(scenes, code).in_order(0, len(scenes))
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(_SEED)
        model = DiffuScene(code, BaselineCfg())
    training = _train(model, lambda _: batch, _loss_of_model, cpu_s)
    model.eval()
    generator = torch.Generator().manual_seed(_SEED)
    domain = int(batch.domain[0])
    return [model.draw(domain, generator) for _ in scenes], training.step


def _loss_of_model(
    model: Callable[..., Any], batch: Batch, generator: torch.Generator
) -> LossTerms:
    return model(batch, generator)


def _train(
    network: torch.nn.Module, batches: Batches, loss: LossFunction, cpu_s: float
) -> PartTraining:
    training = PartTraining(network, _TRAINING, torch.device("cpu"))
    budget = Budget(seconds=cpu_s)
    train_steps(training, batches, loss, budget, lambda _: True, time.process_time)
    return training


def _joined(parts: Sequence[FlatBoxes]) -> FlatBoxes:
    columns = (
        np.concatenate([getattr(part, name) for part in parts])
        for name in ("category", "center_enu_m", "yaw_rad", "size_m")
    )
    return FlatBoxes(*columns)


@dataclass(frozen=True)
class _Off:
    """Errors of draws, each against the learned scene that it resembles most."""

    place_cm: Float[np.ndarray, " n"]
    extent_percent: Float[np.ndarray, " n"]
    heading_deg: Float[np.ndarray, " n"]
    missing_percent: float
    """Share of the objects of the learned scenes that the draws lack."""

    @classmethod
    def compare(cls, drawn: Sequence[FlatBoxes], real: Sequence[FlatBoxes | FlatLayout]) -> _Off:
        """Compare each draw with each scene, and keep the most similar one.

        Args:
            drawn: Boxes of the draws.
            real: Boxes of the learned scenes.
        """
        matches = [min((_matched(a, b) for b in real), key=lambda m: m.cost_m) for a in drawn]
        n_lost = sum(match.n_lost for match in matches)
        n = sum(len(match.place_m) for match in matches)
        return cls(
            100 * np.concatenate([match.place_m for match in matches]),
            100 * np.concatenate([match.extent for match in matches]),
            np.degrees(np.concatenate([match.heading_rad for match in matches])),
            100 * n_lost / max(1, n + n_lost),
        )

    def rows(self, who: str, *, has_target: bool) -> Iterator[Row]:
        """Yield medians with their targets, and 90th percentiles.

        Args:
            who: Name of the network.
            has_target: True if the targets apply to it.
        """
        for what, values, unit, most in (
            ("places", self.place_cm, "cm", MOST_PLACE_CM),
            ("extents", self.extent_percent, "%", MOST_EXTENT_PERCENT),
            ("headings", self.heading_deg, "deg", MOST_HEADING_DEG),
        ):
            metric = f"{who}: {what} off, by heart"
            yield lower(
                f"{metric}, median", _quantile(values, 0.5), unit, most * has_target or None
            )
            yield lower(f"{metric}, p90", _quantile(values, 0.9), unit)
        yield lower(f"{who}: objects missing", self.missing_percent, "%")


@dataclass(frozen=True)
class _Match:
    """Objects of a draw beside those of a scene."""

    place_m: Float[np.ndarray, " n"]
    extent: Float[np.ndarray, " n"]
    """Greatest ratio of the three extents, less 1."""
    heading_rad: Float[np.ndarray, " n"]
    n_lost: int
    cost_m: float
    """Sum of distances over all objects, which measures how different the two are."""


def _matched(drawn: FlatBoxes, real: FlatBoxes | FlatLayout) -> _Match:
    """Pair objects of equal category such that the sum of distances is least."""
    # 1 km for unequal categories, so that the assignment avoids them; such pairs are dropped.
    apart_m = np.linalg.norm(drawn.center_enu_m[:, None] - real.center_enu_m, axis=-1)
    is_alike = drawn.category[:, None] == real.category
    own, other = linear_sum_assignment(np.where(is_alike, apart_m, 1e3))
    kept = is_alike[own, other]
    own, other = own[kept], other[kept]
    place_m = apart_m[own, other]
    # The logarithm treats too large and too small alike; `expm1` below turns it into a share.
    ratio = np.abs(np.log(drawn.size_m[own] / real.size_m[other])).max(axis=1)
    turn = drawn.yaw_rad[own] - real.yaw_rad[other]
    turn = np.abs((turn + np.pi) % (2 * np.pi) - np.pi)
    # A two-sided object, such as a fence, looks the same after half a turn.
    two_sided = IS_TWO_SIDED[drawn.category[own]]
    turn = np.where(two_sided, np.minimum(turn, np.pi - turn), turn)
    n_lost = len(real.category) - len(own)
    cost_m = float(place_m.sum()) + _MISSING_M * (n_lost + len(drawn.category) - len(own))
    return _Match(place_m, np.expm1(ratio), turn, n_lost, cost_m)


def _quantile(values: Float[np.ndarray, " n"], share: float) -> float:
    return float(np.quantile(values, share)) if len(values) else float("inf")
