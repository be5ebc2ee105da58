"""Figures with the interval in which 95% of repetitions would lie, by resampling the scenes.

The scenes of a group are resampled with replacement (bootstrap, Efron 1979); the reference stays.
Means over scenes take the percentiles of the resampled means. Figures about a set as a whole
(distances, divergences) shift if scenes come twice. Of these the resampled figures give the
standard error alone, about the value of the set itself.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

# Enough for a standard error; more draws would change it by a few per cent.
N_DRAWS = 200
_SHARES = (0.025, 0.975)
_Z_95 = 1.959964
"""Half width of a normal distribution's central 95%, standard deviations."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """A figure of a group of scenes with its interval; nan if there is nothing to judge."""

    value: float
    low: float
    """Lower end of the 95% interval."""
    high: float
    """Upper end of the 95% interval."""
    n: int
    """Number of scenes, or of other judged things."""


def resamples(
    n: int, rng: np.random.Generator, n_draws: int = N_DRAWS
) -> Int[np.ndarray, "draws n"]:
    """Return how often each scene is taken in each draw with replacement.

    Args:
        n: Number of scenes, and of scenes in a draw.
        rng: Source of the draws.
        n_draws: Number of draws.
    """
    return rng.multinomial(n, np.full(n, 1 / n), n_draws)


def mean_figure(values: Float[np.ndarray, " n"], rng: np.random.Generator) -> Figure:
    """Mean over scenes; those without a value (nan) are left out."""
    return ratio_figure(values, np.ones(len(values)), rng)


def ratio_figure(
    values: Float[np.ndarray, " n"], weights: Float[np.ndarray, " n"], rng: np.random.Generator
) -> Figure:
    """Mean over objects that come in scenes.

    Scenes are resampled whole, because objects of one scene are not independent.

    Args:
        values: Mean of each scene; nan leaves it out.
        weights: Number of objects of each scene.
        rng: Draws the bootstrap.
    """
    is_known = np.isfinite(values) & (weights > 0)
    values, weights = values[is_known], weights[is_known]
    if not len(values):
        return nothing()
    times = resamples(len(values), rng) * weights
    # Weights go into both sums: a draw without large scenes has a smaller total.
    draws = (times @ values) / times.sum(axis=1)
    low, high = np.quantile(draws, _SHARES).tolist()
    value = float((weights * values).sum() / weights.sum())
    return Figure(value=value, low=low, high=high, n=len(values))


def median_figure(per_scene: Sequence[np.ndarray], rng: np.random.Generator) -> Figure:
    """Median over all objects of all scenes together, with scenes resampled whole.

    Args:
        per_scene: Values of the objects of each scene; may be empty.
        rng: Draws the bootstrap.
    """
    kept = [values for values in per_scene if len(values)]
    if not kept:
        return nothing()
    pooled = np.concatenate(kept)
    scene = np.repeat(np.arange(len(kept)), [len(values) for values in kept])
    # Sorted once, so that each draw only repeats entries.
    order = np.argsort(pooled, kind="stable")
    pooled, scene = pooled[order], scene[order]
    draws = [
        float(np.median(np.repeat(pooled, times[scene]))) for times in resamples(len(kept), rng)
    ]
    low, high = np.quantile(draws, _SHARES).tolist()
    return Figure(value=float(np.median(pooled)), low=low, high=high, n=len(kept))


def set_figure(
    value: float, draws: Float[np.ndarray, " draws"], n: int, least: float | None = 0.0
) -> Figure:
    """Return a figure about a set as a whole, with the spread of its draws on both sides.

    Args:
        value: Figure of the set itself.
        draws: Figures of resampled sets.
        n: Scenes in the set.
        least: Value below which it cannot be; None if it can be anything.
    """
    return normal_figure(value, float(np.std(draws, ddof=1)), n, least)


def normal_figure(value: float, error: float, n: int, least: float | None = 0.0) -> Figure:
    """Return a figure with a known standard error and a normal interval.

    Args:
        value: The figure.
        error: Its standard error.
        n: Scenes, or other judged things.
        least: Value below which it cannot be; None if it can be anything.
    """
    low = value - _Z_95 * error
    return Figure(
        value=value, low=low if least is None else max(low, least), high=value + _Z_95 * error, n=n
    )


def nothing() -> Figure:
    """Return a figure about nothing: nan, over 0 scenes."""
    return Figure(value=float("nan"), low=float("nan"), high=float("nan"), n=0)


def resampled_figure(
    figure: Callable[[Int[np.ndarray, " n"]], float],
    n: int,
    rng: np.random.Generator,
    *,
    n_draws: int = N_DRAWS,
    least: float | None = 0.0,
) -> Figure:
    """Return a figure of a set that is a function of how often each of its scenes counts.

    Args:
        figure: Figure for the counts of each scene.
        n: Number of scenes.
        rng: Draws the bootstrap.
        n_draws: Number of draws.
        least: Value below which it cannot be; None if it can be anything.
    """
    draws = np.array([figure(times) for times in resamples(n, rng, n_draws)])
    return set_figure(figure(np.ones(n, dtype=int)), draws, n, least)
