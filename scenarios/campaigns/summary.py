"""Summary of a campaign: success with its interval, overall and by groups, and codes.

A rate from a few dozen trials says little without its uncertainty, so every rate has an interval of
95%.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from jaxtyping import Bool, Float

from aeroscene.corpus.corpus import scene_domain
from scenarios.trials.verdict import Fate
from scenarios.words.goal import GRADES as GOAL_GRADES

_Z_95 = 1.959963984540054
"""Quantile of the normal law for an interval of 95%."""
_WINDS_MPS = (2.0, 4.0, 6.0)
"""Bounds between the classes of wind."""
_UNKNOWN = "unknown"


def _named(name: str) -> Callable[[pa.Table], pa.Array]:
    return lambda table: table[name].combine_chunks().fill_null(_UNKNOWN)


def _kinds(table: pa.Table) -> pa.Array:
    # A million rows have a few hundred scenes: each name is looked up once.
    scenes = table["scene"].combine_chunks().dictionary_encode()
    kinds = pa.array([scene_kind(name) for name in scenes.dictionary.to_pylist()], pa.string())
    return pa.DictionaryArray.from_arrays(scenes.indices, kinds).dictionary_decode()


def _winds(table: pa.Table) -> pa.Array:
    edges = (0.0, *_WINDS_MPS)
    # Names in the order of the classes, the last one for trials whose wind is unknown.
    names = [f"{low:g} to {high:g} m/s" for low, high in pairwise(edges)]
    names += [f"{edges[-1]:g} m/s and more", _UNKNOWN]
    speeds_mps = table["wind_mps"].to_numpy()
    places = np.where(np.isnan(speeds_mps), len(edges), np.digitize(speeds_mps, _WINDS_MPS))
    return pa.array(names, pa.string()).take(pa.array(places))


GROUPS: Mapping[str, Callable[[pa.Table], pa.Array]] = {
    "family": _named("family"),
    "goal": _named("goal"),
    "vehicle": _named("vehicle"),
    "kind": _kinds,
    "scene": _named("scene"),
    "difficulty": _named("difficulty"),
    "wind": _winds,
    **{
        name: _named(name)
        for name in ("map", "gnss", "aiding", "depth_camera", "traffic", "failures")
    },
}
"""Functions that give the group of each row of a table, by the name of the grouping."""
SUMMARY_COLUMNS = (
    *(
        "success",
        "grade",
        "code",
        "navigated",
        "trial_cpu_seconds",
        "vehicle",
        "scene",
        "difficulty",
    ),
    *("goal", "navigation_error_m", "oracle_error_m", "spl", "fate"),
    *("wind_mps", "map", "gnss", "aiding", "depth_camera", "traffic", "failures", "family"),
)
"""Columns that a summary is made of."""


def scene_kind(name: str) -> str:
    """Return the kind of a scene by its name: the domain of a shipped one, else `own`."""
    return scene_domain(int(name)) if name.isdecimal() else "own"


def wilson_interval(n_successes: int, n: int) -> tuple[float, float]:
    """Return the interval that covers a rate with 95%.

    It stays within 0 and 1 and is right for rates near either end, where the normal law gives an
    interval of no width.

    Args:
        n_successes: Number of successes.
        n: Number of trials; without any, the rate may be anything from 0 to 1.

    Source: Wilson 1927, "Probable inference, the law of succession, and statistical inference".
    """
    if n == 0:
        return 0.0, 1.0
    rate, z2 = n_successes / n, _Z_95**2
    middle = (rate + z2 / (2 * n)) / (1 + z2 / n)
    half = _Z_95 * math.sqrt(rate * (1 - rate) / n + z2 / (4 * n * n)) / (1 + z2 / n)
    return max(0.0, middle - half), min(1.0, middle + half)


def summarise_trials(table: pa.Table) -> dict[str, Any]:
    """Return the summary of results as plain data.

    Args:
        table: Rows with at least `SUMMARY_COLUMNS`.

    Returns:
        `trials`, `success_rate`, `interval_95`; `grade` and `grade_interval_95`, the mean of
        `scenarios.trials.grade`; `without_task`, trials for which a scene has no task and which
        count nowhere else; `phases`, whose interaction counts only flights that came to their area;
        `words`, scores of the trials with goals in words; `groups` by name and value; `codes` with
        their counts, most frequent first.
    """
    judged = table.filter(pc.field("success").is_valid())
    # A success counts as having come to the area, even if `navigated` is null.
    came = judged.filter(pc.field("navigated") | pc.field("success"))
    codes = table.group_by("code").aggregate([([], "count_all")]).to_pylist()
    # By name among equals, so that the order does not depend on the rows.
    codes.sort(key=lambda row: (-row["count_all"], row["code"]))
    cpu_seconds = table["trial_cpu_seconds"].drop_null().to_numpy()
    return {
        **_rate(judged),
        "without_task": len(table) - len(judged),
        "phases": {
            "navigation": share(len(came), len(judged)),
            "interaction": _rate(came),
        },
        "groups": {name: _group(judged, group_of(judged)) for name, group_of in GROUPS.items()},
        "words": _words(judged),
        "codes": {row["code"]: row["count_all"] for row in codes},
        "cpu_seconds_per_trial": float(cpu_seconds.mean()) if cpu_seconds.size else None,
    }


WITHIN_M = (5.0, 20.0)
"""Distances from the place within which flights to goals in words are counted."""


def _words(judged: pa.Table) -> dict[str, Any] | None:
    """Return the scores of the trials with goals in words; None if there are none.

    A trial without a flight, such as one whose pilot raised an error, counts as far from its goal.
    """
    rows = judged.filter(pc.field("goal").isin(list(GOAL_GRADES)))
    if not len(rows):
        return None
    near_m, oracle_m, weights = (
        rows[name].to_numpy() for name in ("navigation_error_m", "oracle_error_m", "spl")
    )
    collided = np.array([fate == Fate.COLLIDED.value for fate in rows["fate"].to_pylist()])
    found: dict[str, Any] = {"success": _rate(rows)}
    for within_m in WITHIN_M:
        # Comparisons with NaN are false.
        found[f"within_{within_m:g}_m"] = _share_of(near_m <= within_m)
        found[f"oracle_within_{within_m:g}_m"] = _share_of(oracle_m <= within_m)
    return {
        **found,
        "collided": _share_of(collided),
        "spl": mean_with_interval(np.nan_to_num(weights)),
        "navigation_error_m": mean_with_interval(near_m[np.isfinite(near_m)]),
    }


def _share_of(holds: Bool[np.ndarray, " n"]) -> dict[str, Any]:
    return share(int(np.count_nonzero(holds)), len(holds))


def mean_with_interval(values: Float[np.ndarray, " n"]) -> dict[str, Any]:
    """Return the mean of some figures as plain data, with its interval by the normal law."""
    n = len(values)
    mean = float(values.mean()) if n else None
    half = _Z_95 * float(values.std(ddof=1)) / math.sqrt(n) if n > 1 else None
    ends = None if mean is None or half is None else [max(0.0, mean - half), mean + half]
    return {"trials": n, "mean": mean, "interval_95": ends}


def _group(judged: pa.Table, groups: pa.Array) -> dict[str, Any]:
    """Return the rate of each group, in the order of their names."""
    coded = groups.dictionary_encode()
    # Groups as numbers, so that a comparison of arrays selects the rows of each.
    codes, names = coded.indices.to_numpy(), coded.dictionary.to_pylist()
    found = {name: _rate(judged.filter(pa.array(codes == i))) for i, name in enumerate(names)}
    return {name: found[name] for name in sorted(found, key=natural)}


def _rate(judged: pa.Table) -> dict[str, Any]:
    n_successes = int(np.count_nonzero(judged["success"].to_numpy()))
    return {**share(n_successes, len(judged)), **_grades(judged["grade"].drop_null().to_numpy())}


def _grades(grades: Float[np.ndarray, " n"]) -> dict[str, Any]:
    """Return the mean grade with its interval by the normal law; None without two trials."""
    if len(grades) == 0:
        return {"grade": None, "grade_interval_95": None}
    mean = float(grades.mean())
    if len(grades) == 1:
        return {"grade": mean, "grade_interval_95": None}
    # Sample deviation over the root of the number: the deviation of the mean.
    half = _Z_95 * float(grades.std(ddof=1)) / math.sqrt(len(grades))
    return {"grade": mean, "grade_interval_95": [max(0.0, mean - half), min(1.0, mean + half)]}


def share(n_successes: int, n: int) -> dict[str, Any]:
    """Return a rate as plain data, with its counts and its interval; None without any trial."""
    low, high = wilson_interval(n_successes, n)
    return {
        "trials": n,
        "successes": n_successes,
        "success_rate": n_successes / n if n else None,
        "interval_95": [low, high],
    }


def natural(text: str) -> tuple[int, float, str]:
    """A key that sorts names: numbers by value, then grades from easy to hard, then words."""
    grades = ("easy", "medium", "hard")
    if text in grades:
        return (1, grades.index(text), "")
    return (0, float(text), "") if text.isdecimal() else (2, 0.0, text)
