"""Graphs of a flight over time: heights and position errors, with the pilot's phases behind."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float

from scenarios.pictures import style
from scenarios.pictures.story import FlightStory, Track

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_HEADROOM_M = 2.0
"""Height above the flight up to which obstacles overhead are drawn."""
_BANDS = ("#eef2f6", "#ffffff")
_LABELLED_SHARE = 0.028
"""Share of the width below which a phase has no room for its name."""
_TAIL_QUANTILE = 0.995  # A single outlier must not set the scale of the errors.


def draw_profile(
    axes: Axes,
    story: FlightStory,
    below_m: Float[np.ndarray, " n"],
    above_m: Float[np.ndarray, " n"],
    flown: Track,
) -> None:
    """Draw the height over time, between the surfaces below and overhead.

    Args:
        axes: Panel to draw into.
        story: Flight, with its plans.
        below_m: Height of the next surface below each point of `flown`; NaN if there is none.
        above_m: Height of the next surface above each point of `flown`; NaN if there is none.
        flown: Thinned track.
    """
    style.plain(axes)
    style.heading(axes, "height")
    time_s, height_m = flown.time_s, flown.true_enu_m[:, 2]
    low = min(float(np.nanmin(np.append(below_m, height_m))), float(height_m.min())) - 0.5
    high = float(height_m.max()) + _HEADROOM_M
    # Steps, because surfaces below are flat boxes and not slopes between two samples.
    solid: dict[str, Any] = {"linewidth": 0, "step": "mid"}
    axes.fill_between(time_s, low, below_m, color="#a39382", label="below", **solid)
    if (above_m < high).any():
        axes.fill_between(time_s, above_m, high, color="#c9ced4", label="overhead", **solid)
    for number, (begin_s, end_s, points) in enumerate(_legs(story)):
        at_s = np.linspace(begin_s, end_s, len(points))
        # One entry of the legend stands for all legs.
        broad = {"linewidth": 6.0, "solid_capstyle": "butt", "label": None if number else "planned"}
        axes.plot(at_s, points[:, 2], color=style.PLANNED, **broad)
    axes.plot(time_s, height_m, color=style.INK, linewidth=1.6, label="flown")
    if story.touchdown_enu_m is not None:
        looks = {"linewidth": 1.2, "linestyle": "dotted", "label": "touchdown point"}
        axes.axhline(story.touchdown_enu_m[2], color=style.AREA, **looks)
    _explain(axes)
    axes.set_ylim(low, high)
    axes.set_xlim(*_span(story.track.time_s, np.isfinite(story.track.ref_enu_m[:, 0])))
    axes.set_xlabel("simulated time, s", color=style.INK)
    axes.set_ylabel("height, m", color=style.INK)


def _legs(story: FlightStory) -> list[tuple[float, float, np.ndarray]]:
    """Return begin, end and points of the part of each plan that was flown."""
    end_s = float(story.track.time_s[-1])
    legs = []
    for number, leg in enumerate(story.plans):
        is_last = number == len(story.plans) - 1
        until_s = end_s if is_last else story.plans[number + 1].time_s
        # Points are even in time, so the time until the next plan gives their number.
        n_flown = max(2, min(len(leg.points_enu_m), 1 + round((until_s - leg.time_s) / leg.step_s)))
        points = leg.points_enu_m[:n_flown]
        legs.append((leg.time_s, leg.time_s + leg.step_s * (n_flown - 1), points))
    return legs


def draw_errors(axes: Axes, story: FlightStory) -> None:
    """Draw the distances between truth, estimate and set point over the pilot's phases.

    Three curves separate two causes: the controller's error is the estimate's distance from the set
    point, and the estimator's is the truth's distance from the estimate.

    Args:
        axes: Panel to draw into.
        story: Flight, with track and phases.
    """
    style.plain(axes)
    style.heading(axes, "position errors")
    track = story.track
    is_flying = np.isfinite(track.ref_enu_m[:, 0])
    begin_s, end_s = _span(track.time_s, is_flying)
    top_m = 0.0
    for name, colour, error_m in (
        ("truth from setpoint", "#a9b0b8", _distance(track.true_enu_m, track.ref_enu_m)),
        ("estimate from truth", style.ESTIMATE, _distance(track.est_enu_m, track.true_enu_m)),
        ("estimate from setpoint", style.TRUE, _distance(track.est_enu_m, track.ref_enu_m)),
    ):
        # Without a set point, on the ground, errors mean nothing; NaN leaves a gap.
        error_cm = 100 * np.where(is_flying, error_m, np.nan)
        axes.plot(track.time_s, error_cm, color=colour, linewidth=1.5, label=name)
        if is_flying.any():
            top_m = max(top_m, float(np.nanquantile(error_cm, _TAIL_QUANTILE)))
    # At least 5 cm, so that the noise of a good flight does not look like an error.
    axes.set_ylim(0.0, max(5.0, 1.5 * top_m))
    axes.set_xlim(begin_s, end_s)
    _draw_phases(axes, story, begin_s, end_s)
    _explain(axes)
    axes.set_xlabel("simulated time, s", color=style.INK)
    axes.set_ylabel("error, cm", color=style.INK)


def _explain(axes: Axes) -> None:
    """Add a legend in one line above a graph, right of its heading."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.01, 0.99), fontsize=9, ncols=5, frameon=False)


def _draw_phases(axes: Axes, story: FlightStory, begin_s: float, end_s: float) -> None:
    borders = [*story.phases, (end_s, "")]
    for number, ((since_s, name), (until_s, _)) in enumerate(pairwise(borders)):
        left, right = max(since_s, begin_s), min(until_s, end_s)
        if right <= left:
            continue
        axes.axvspan(left, right, color=_BANDS[number % 2], zorder=0, linewidth=0)
        if right - left > _LABELLED_SHARE * (end_s - begin_s):
            # x in seconds, y as a share of the height: names stay at the top at any scale.
            place = {"transform": axes.get_xaxis_transform(), "ha": "center", "va": "top"}
            looks = {"fontsize": 9, "color": style.PALE, "rotation": 90}
            axes.text((left + right) / 2, 0.96, name, **place, **looks)


def _span(time_s: np.ndarray, is_flying: np.ndarray) -> tuple[float, float]:
    """Return the time span from a second before the rotors turn to a second after they stop."""
    shown = time_s[is_flying] if is_flying.any() else time_s
    first_s, *_, last_s = time_s.tolist()
    return max(first_s, float(shown[0]) - 1.0), min(last_s, float(shown[-1]) + 1.0)


def _distance(a_m: np.ndarray, b_m: np.ndarray) -> np.ndarray:
    return np.linalg.norm(a_m - b_m, axis=1)
