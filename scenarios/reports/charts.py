"""Charts as shares of their own width and height; the templates draw them.

A chart knows no pixels and no SVG, so that a page may draw it at any size.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

_N_BINS, _N_TICKS = 24, 5  # bins and ticks that are aimed at; round steps decide
_OUTLIERS = 0.02
"""Share of the values at each end that may lie far from the others."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Bar:
    """Bin of a histogram: its place, and the number of trials in it."""

    left: float
    width: float
    landed: float
    """Height of the trials that succeeded, as a share of the highest bin."""
    failed: float
    """Height of the trials that failed, on top of the others."""
    says: str
    """Range and counts in words."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Histogram:
    """Distribution of a figure over trials; failed trials stand on top of successful ones."""

    bars: Sequence[Bar]
    ticks: Sequence[tuple[float, str]]
    """Places and numbers on the axis."""
    most: int
    """Number of trials in the highest bin."""
    limit: float | None
    """Place of the verdict's limit; None if it is not on the axis."""


def histogram(
    landed: Float[np.ndarray, " n"], failed: Float[np.ndarray, " m"], limit: float | None = None
) -> Histogram | None:
    """Bin a figure; the outermost bins also hold values far outside.

    Args:
        landed: Values of trials that succeeded.
        failed: Values of trials that failed.
        limit: Value to mark.

    Returns:
        The histogram; None without any value.
    """
    values = np.concatenate([landed, failed])
    if not values.size:
        return None
    low, high = _range(values)
    step = nice_step((high - low) / _N_BINS)
    # Edges are whole multiples of the step, so that they have short numbers; at least one bin.
    first, last = math.floor(low / step), max(math.ceil(high / step), math.floor(low / step) + 1)
    edges = np.arange(first, last + 1) * step
    parts = [np.clip(part, edges[0], edges[-1]) for part in (landed, failed)]
    counts = [np.histogram(part, edges)[0] for part in parts]
    most, n = int(max(1, np.max(counts[0] + counts[1]))), len(edges) - 1
    bars = [
        Bar(
            left=index / n,
            width=1 / n,
            landed=good / most,
            failed=bad / most,
            says=f"{edges[index]:.4g} to {edges[index + 1]:.4g}: {good} succeeded, {bad} failed",
        )
        for index, (good, bad) in enumerate(zip(*(part.tolist() for part in counts), strict=True))
    ]
    is_open = (bool(values.min() < edges[0]), bool(values.max() > edges[-1]))
    place = None if limit is None else (limit - edges[0]) / (edges[-1] - edges[0])
    return Histogram(
        bars=bars,
        ticks=_ticks(float(edges[0]), float(edges[-1]), is_open),
        most=most,
        limit=place if place is not None and 0 <= place <= 1 else None,
    )


def nice_step(least: float) -> float:
    """Return the least of 1, 2 and 5 times a power of ten that is not below a positive number."""
    power = 10.0 ** math.floor(math.log10(least))
    # Rounding must not turn a step of exactly 0.2 into 0.5.
    return next(power * factor for factor in (1, 2, 5, 10) if power * factor >= least * (1 - 1e-9))


def _range(values: np.ndarray) -> tuple[float, float]:
    """Return the range to show: all values, or without outliers that would squeeze the others."""
    low, high = float(values.min()), float(values.max())
    near_low, near_high = np.quantile(values, [_OUTLIERS, 1 - _OUTLIERS]).tolist()
    width = max(near_high - near_low, 1e-3 * max(abs(high), abs(low), 1e-3))
    return (
        near_low if near_low - low > width / 2 else low,
        max(near_high if high - near_high > width / 2 else high, low + width),
    )


def _ticks(low: float, high: float, is_open: tuple[bool, bool]) -> list[tuple[float, str]]:
    step = nice_step((high - low) / _N_TICKS)
    places = np.arange(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1) * step
    ticks = [((place - low) / (high - low), f"{place:.6g}") for place in places.tolist()]
    at_ends = [(0.0, "≤")] * is_open[0] + [(1.0, "≥")] * is_open[1]
    # An end with a number gets its sign before it; an end without one gets number and sign.
    for place, sign in at_ends:
        number = f"{low if place == 0.0 else high:.6g}"
        ticks = [tick for tick in ticks if abs(tick[0] - place) > 0.08]
        ticks.append((place, f"{sign} {number}"))
    return sorted(ticks)
