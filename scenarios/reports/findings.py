"""Findings of a campaign for a page, read from its folder.

A folder may hold a million trials, so a page reads only the columns that it shows and lists at most
a few hundred failures.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from jaxtyping import Float

from aeroscene.sources import load_scene
from scenarios.campaigns.recordings import RECORDINGS, Recordings
from scenarios.campaigns.store import TRACKS, read_results
from scenarios.campaigns.summary import SUMMARY_COLUMNS, natural
from scenarios.reports.charts import Histogram, histogram
from scenarios.reports.plan_view import PlanView, plan_view
from scenarios.trials.limits import LIMITS

MOST_SCENES, MOST_WAYS, MOST_FAILURES = 8, 60, 500
"""Limits of a page: scenes, paths over each of them, and failures."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Figure:
    """A figure that compares flights; it may be the quotient of two columns."""

    title: str
    unit: str
    column: str
    over: str | None = None
    """Column to divide by."""
    limit: float | None = None
    """Limit of the verdict."""
    is_of_failures: bool = False
    """True if it is meaningful for failed flights too."""

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns from which it is computed."""
        return (self.column,) if self.over is None else (self.column, self.over)

    def values(self, table: pa.Table) -> Float[np.ndarray, " n"]:
        """Return the value for each row; NaN if there is none."""
        values = table[self.column].cast(pa.float64()).to_numpy()
        return values if self.over is None else values / table[self.over].to_numpy()


FIGURES: Sequence[Figure] = (
    Figure(
        title="time against the least possible",
        unit="times",
        column="navigation_s",
        over="least_navigation_s",
    ),
    Figure(
        title="touchdown error",
        unit="m",
        column="touchdown_error_m",
        limit=LIMITS.touchdown_error_m,
    ),
    Figure(
        title="least clearance",
        unit="m",
        column="least_clearance_m",
        limit=0.0,
        is_of_failures=True,
    ),
    Figure(title="jerk, root mean square", unit="m/s³", column="jerk_rms_mps3"),
    Figure(title="time from lift-off to touchdown", unit="s", column="flight_s"),
    Figure(title="electrical energy", unit="J", column="energy_j"),
    Figure(title="plans made anew", unit="", column="replans"),
)
"""Figures of a page; the first four have a chart."""
N_CHARTS = 4
FIGURE_COLUMNS = tuple(dict.fromkeys(name for figure in FIGURES for name in figure.columns))
PAGE_COLUMNS = tuple(dict.fromkeys((*SUMMARY_COLUMNS, *FIGURE_COLUMNS)))
"""Columns from which the figures and the summary of a page are computed."""
_FAILURE_COLUMNS = (
    *("trial_id", "scene", "vehicle", "trial", "code", "reason", "difficulty", "way_m"),
    *("wind_mps", "navigated"),
)
_WAY_COLUMNS = ("trial_id", "success", "code", "reason", "start", "area", *TRACKS)


@dataclass(frozen=True, kw_only=True, slots=True)
class Distribution:
    """A figure over the trials of a campaign."""

    figure: Figure
    n: int
    low: float
    """Value that 10% of the trials are below."""
    median: float
    high: float
    """Value that 10% of the trials are above."""
    chart: Histogram | None


def distributions(table: pa.Table) -> list[Distribution]:
    """Return all figures that any row of a table has; failures count only for some figures."""
    succeeded = table.filter(pc.field("success"))
    failed = table.filter(~pc.field("success"))
    found = []
    for place, figure in enumerate(FIGURES):
        good = _present(figure.values(succeeded))
        # The touchdown error of a flight that never landed, for example, would mean nothing.
        bad = _present(figure.values(failed)) if figure.is_of_failures else np.empty(0)
        values = np.concatenate([good, bad])
        if not values.size:
            continue
        low, median, high = np.quantile(values, [0.1, 0.5, 0.9]).tolist()
        chart = histogram(good, bad, figure.limit) if place < N_CHARTS else None
        found.append(
            Distribution(
                figure=figure, n=values.size, low=low, median=median, high=high, chart=chart
            )
        )
    return found


def _present(values: np.ndarray) -> np.ndarray:
    return values[np.isfinite(values)]


@dataclass(frozen=True, kw_only=True, slots=True)
class Failure:
    """A trial that failed, with the command to see it."""

    row: Mapping[str, Any]
    recording: str | None
    """Its recording, relative to the folder of the campaign; None if there is none."""
    command: str
    """Command that replays it, or flies it again with a recording."""


def failures(folder: Path) -> list[Failure]:
    """Return the first trials of a campaign that failed, by scene, vehicle and number."""
    table = read_results(folder, _FAILURE_COLUMNS, where=~pc.field("success"))
    # Cut before rows become Python objects.
    rows = table.slice(0, MOST_FAILURES).to_pylist()
    rows.sort(key=lambda row: (natural(row["scene"]), row["vehicle"], row["trial"]))
    return [_failure(folder, row) for row in rows]


def _failure(folder: Path, row: Mapping[str, Any]) -> Failure:
    recording = Recordings(folder=folder / RECORDINGS).path(row["trial_id"])
    if recording.is_file():
        # Only a file that is there; the row's own word may be old.
        command = ["aeroscene", "replay", str(recording)]
    else:
        trial = ("--scene", row["scene"], "--vehicle", row["vehicle"], "--trial", str(row["trial"]))
        command = ["aeroscene", "fly", "--out", str(folder), *trial]
    return Failure(
        row=row,
        recording=recording.relative_to(folder).as_posix() if recording.is_file() else None,
        command=shlex.join(command),
    )


def shown_scenes(summary: Mapping[str, Any]) -> list[str]:
    """Return the scenes with most failures, the others by their names."""
    rates = summary["groups"]["scene"]

    def order(name: str) -> tuple[int, tuple[int, float, str]]:
        return rates[name]["successes"] - rates[name]["trials"], natural(name)

    return sorted(rates, key=order)[:MOST_SCENES]


def plan_views(
    folder: Path, scenes: Sequence[str], on_scene: Callable[[str], None]
) -> list[PlanView]:
    """Return the paths over the plans of some scenes: failures first, as many as a page shows.

    Args:
        folder: Folder of the campaign.
        scenes: Names of the scenes.
        on_scene: Called with the name of each scene before it is drawn.

    Raises:
        SceneError: If a scene is no longer there.
    """
    views = []
    for name in scenes:
        if not (name.isascii() and name.isdecimal()):
            continue  # Campaigns fly numbered scenes; a file or a model is not opened for a row.
        on_scene(name)
        flown = pc.field("flown_enu_m").is_valid()
        table = read_results(folder, _WAY_COLUMNS, where=(pc.field("scene") == name) & flown)
        # False sorts first; a row with a path always has a verdict.
        chosen = table.sort_by("success").slice(0, MOST_WAYS)
        if len(chosen):
            views.append(plan_view(load_scene(name), name, chosen.to_pylist(), len(table)))
    return views
