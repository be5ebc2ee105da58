"""Rows of a table: every figure of a method with its interval, kept once it is measured.

Some figures take long, so they are kept in a file with a key. The key covers the data, the
network, the protocol and the draws. A figure is read again only while all of these are the same.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
from jaxtyping import Float

from aeroscene.files import replacing
from aeroscene.learning.baselines.fitting import Spent
from aeroscene.metrics.appearance.features import FeatureNetwork
from aeroscene.metrics.appearance.frechet import frechet_figure
from aeroscene.metrics.appearance.kernel_distance import kernel_figure
from aeroscene.metrics.classifier import accuracy_figure
from aeroscene.metrics.intervals import Figure, mean_figure
from aeroscene.metrics.scorecard import METRICS, Metric, Yardstick, layout_figures
from scenarios.evaluation.drawing import SAMPLED, Draw

COSTS: Mapping[str, Metric] = {
    "flies": Metric(
        title="draws in which an Iris can fly to a landing area", unit="%", better="higher"
    ),
    "areas": Metric(
        title="landing areas that can be reached, of all draws", unit="areas", better=None
    ),
    "lands": Metric(title="draws in which the demo lands", unit="%", better="higher"),
    "failed": Metric(title="draws without a scene", unit="%"),
    "sample_cpu_s": Metric(title="sampling of a scene", unit="CPU s"),
    "sample_mb": Metric(title="peak memory while sampling", unit="MB"),
    "parameters": Metric(title="parameters", unit="millions", better=None),
    "training_best_at": Metric(
        title="when its held-out loss was least, of its training", unit="%", better=None
    ),
    "training_steps": Metric(title="training steps", unit="steps", better=None),
    "training_cpu_s": Metric(title="training", unit="CPU s", better=None),
    "training_tflop": Metric(title="training", unit="TFLOP", better=None),
}
"""Metrics of a method's costs, and of whether its scenes can be flown in."""


_VERSION = 3
"""Version of the figures. Raise it when they are computed otherwise, so that kept ones are measured
anew."""


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """One figure of one method."""

    method: str
    metric: str
    value: float | None
    """The figure; None if there is nothing to judge."""
    interval_95: tuple[float, float] | None
    n: int
    """Number of scenes that it was measured on."""


@dataclass(frozen=True, eq=False)
class Judge:
    """Judge of scenes: the training scenes as the reference, and the settings of the figures."""

    yardstick: Yardstick
    pictures: np.ndarray
    """Features of the training scenes' pictures, (scenes, views, features)."""
    views: tuple[str, ...]
    """Names of the pictures of a scene."""
    network: FeatureNetwork
    seed: int
    key: str
    """Digest of all that figures depend on beside the scenes."""

    def metrics(self) -> dict[str, Metric]:
        """Return all metrics by key, in the order of the table."""
        near, kernel = self.network.frechet_name, self.network.kernel_name
        found = {near: Metric(title="Fréchet distance of pictures, all views", unit="-")}
        found[kernel] = Metric(title="kernel distance of pictures, all views", unit="-")
        found["SCA"] = Metric(title="pictures that a classifier tells from real ones", unit="%")
        for view in self._own_views:
            found[f"{near}-{view}"] = Metric(title=f"Fréchet distance, {view} view", unit="-")
            found[f"{kernel}-{view}"] = Metric(title=f"kernel distance, {view} view", unit="-")
        return found | dict(METRICS) | dict(COSTS)

    @property
    def _own_views(self) -> tuple[str, ...]:
        """Views with figures of their own; none for a single view, which equals the mean."""
        return self.views if len(self.views) > 1 else ()

    def rows(self, method: str, stage: str, draws: Sequence[Draw], kept: Path) -> list[Row]:
        """Return the figures of the scenes of a stage, read from a file if they were measured.

        Args:
            method: Name of the row.
            stage: One of `drawing.STAGES`.
            draws: Draws of the method.
            kept: File that keeps the figures.

        Raises:
            TooFewScenesError: If there are too few scenes.
            OSError: If a file cannot be written.
        """
        there = [draw for draw in draws if (draw.stem.with_suffix(f".{stage}.json.gz")).exists()]
        key = self._key(there)
        known = _read(kept, key)
        if known is not None:
            return known
        scenes = [scene for draw in there if (scene := draw.scene(stage)) is not None]
        found = [features for draw in there if (features := draw.features(stage)) is not None]
        # One seed for all methods, so that they get the same folds and resamples.
        rng = np.random.default_rng(self.seed)
        pictures = np.stack(found) if found else np.zeros((0, *self.pictures.shape[1:]))
        figures = self._picture_figures(pictures, rng)
        figures |= layout_figures(scenes, self.yardstick, rng)
        rows = [_row(method, metric, figure) for metric, figure in figures.items()]
        with replacing(kept) as file:
            file.write(msgspec.json.encode({"key": key, "rows": rows}))
        return rows

    def _key(self, draws: Sequence[Draw]) -> str:
        # Draws are written once and never changed, so names and seeds identify them.
        digest = hashlib.sha256(f"{_VERSION} {self.key}".encode())
        for draw in draws:
            digest.update(f"{draw.stem.name} {draw.facts.seed}".encode())
        return digest.hexdigest()[:16]

    def _picture_figures(self, pictures: np.ndarray, rng: np.random.Generator) -> dict[str, Figure]:
        name, kernel = self.network.frechet_name, self.network.kernel_name
        figures: dict[str, Figure] = {}
        for number, view in enumerate(self.views):
            pair = pictures[:, number], self.pictures[:, number]
            figures[f"{name}-{view}"] = frechet_figure(*pair, rng)
            figures[f"{kernel}-{view}"] = kernel_figure(*pair, rng)
        means = {
            metric: _mean([figures[f"{metric}-{view}"] for view in self.views])
            for metric in (name, kernel)
        }
        own = {key: figures[key] for key in self.metrics() if key in figures}
        return means | own | {"SCA": classification_accuracy(pictures, self.pictures, rng)}


def classification_accuracy(
    pictures: Float[np.ndarray, "n views f"],
    reference: Float[np.ndarray, "m views f"],
    rng: np.random.Generator,
) -> Figure:
    """Return how well a classifier tells pictures from the reference's, as an accuracy in percent.

    The accuracy is 50 if they cannot be told apart, and 100 if they always can.

    Args:
        pictures: Features of the pictures to judge.
        reference: Features of real scenes' pictures.
        rng: Source of the folds and of the bootstrap.
    """
    both = np.concatenate([pictures, reference]).reshape(len(pictures) + len(reference), -1)
    both = both - both.mean(axis=0)
    # The classifier's penalty is meant for features of norm two or so; see `metrics.classifier`.
    both *= 2.0 / max(float(np.linalg.norm(both, axis=1).mean()), 1e-9)
    return accuracy_figure(both[: len(pictures)], both[len(pictures) :], rng)


def _mean(figures: Sequence[Figure]) -> Figure:
    """Return the mean of figures of the same scenes, with the mean of their interval ends.

    The interval does not shrink, because errors of two views of one scene go together.
    """
    value, low, high = (
        float(np.mean([getattr(figure, name) for figure in figures]))
        for name in ("value", "low", "high")
    )
    return Figure(value=value, low=low, high=high, n=figures[0].n)


def cost_rows(
    method: str,
    draws: Sequence[Draw],
    spent: Spent | None,
    best_at: float | None,
    seed: int,
    *,
    is_real: bool,
) -> list[Row]:
    """Return the costs of a method's draws and training, and how many draws can be flown in.

    Args:
        method: Name of the row.
        draws: Draws of the method.
        spent: Steps, time and size of its training; None if it was not trained here.
        best_at: Share of the training at which its held-out loss was least.
        seed: Seed of the bootstrap.
        is_real: True for real scenes, which cost nothing to draw.
    """
    rng = np.random.default_rng(seed)
    facts = [draw.facts for draw in draws]
    is_sound = [fact.failure is None and fact.rejection is None for fact in facts]
    values: dict[str, list[float]] = {
        "flies": [100.0 * sound for sound in is_sound],
        "areas": [float(fact.n_areas) for fact in facts],
    }
    flown = [fact for fact in facts if fact.lands is not None]
    if flown:
        values["lands"] = [100.0 * bool(fact.lands) for fact in flown]
    if not is_real:
        # A draw that failed has no scene whose time and memory could count.
        drawn = [fact for fact in facts if fact.failure is None]
        values["failed"] = [100.0 * (fact.failure is not None) for fact in facts]
        values["sample_cpu_s"] = [fact.sample_cpu_s for fact in drawn]
        values["sample_mb"] = [fact.peak_mb for fact in drawn]
    rows = [_row(method, name, mean_figure(np.array(each), rng)) for name, each in values.items()]
    if spent is not None:
        figures: dict[str, float | None] = {
            "training_best_at": None if best_at is None else 100.0 * best_at,
            "parameters": spent.parameters / 1e6,
            "training_steps": float(spent.steps),
            "training_cpu_s": spent.cpu_s,
            "training_tflop": spent.flop / 1e12,
        }
        rows += [
            Row(method=method, metric=name, value=value, interval_95=None, n=1)
            for name, value in figures.items()
            if value is not None
        ]
    return rows


def _row(method: str, metric: str, figure: Figure) -> Row:
    # NaN means that there was nothing to judge; JSON has no NaN.
    if math.isnan(figure.value):
        return Row(method=method, metric=metric, value=None, interval_95=None, n=0)
    interval = (float(figure.low), float(figure.high))
    return Row(
        method=method, metric=metric, value=float(figure.value), interval_95=interval, n=figure.n
    )


def _read(path: Path, key: str) -> list[Row] | None:
    try:
        kept = msgspec.json.decode(path.read_bytes(), type=_Kept)
    except (FileNotFoundError, msgspec.DecodeError):
        return None  # Figures of an older form are measured anew, too.
    return kept.rows if kept.key == key else None


class _Kept(msgspec.Struct):
    key: str
    rows: list[Row]


def stage_name(method: str, stage: str) -> str:
    """Return the name of a row of the table for a method and a stage of its scenes.

    Args:
        method: Name of the method.
        stage: One of `drawing.STAGES`; projected scenes have a row of their own.
    """
    return method if stage == SAMPLED else f"{method}+projection"
