"""Two pilots compared by the trials that both have flown.

Tasks differ much in difficulty, so that the rates of two campaigns vary more by the tasks than by
the pilots. Comparing trial by trial removes that: only trials in which the pilots differ say which
one is better.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from jaxtyping import Int

from scenarios.campaigns.campaign import read_manifest
from scenarios.campaigns.store import read_results
from scenarios.campaigns.summary import GROUPS, natural, share, wilson_interval
from scenarios.reports.findings import FIGURE_COLUMNS, FIGURES, Figure

# Columns in which a pair must agree to be the same task.
_TASK = (
    *("seed", "start", "start_yaw_rad", "area", "time_limit_s", "wind_mps", "wind_from_deg"),
    *("gust_mps", "turbulence", "traffic", "gnss", "depth_camera", "map", "aiding", "failures"),
    "text",
    "navigation_limit_s",
)
_COLUMNS = tuple(
    dict.fromkeys(
        (
            *("trial_id", "success", "code", "family", "goal", "scene", "vehicle", "difficulty"),
            *_TASK,
            *FIGURE_COLUMNS,
        )
    )
)


class CompareError(ValueError):
    """Two campaigns cannot be compared; one line says why, and what would be valid."""


def newcombe_interval(both: int, a_alone: int, b_alone: int, neither: int) -> tuple[float, float]:
    """Return the interval that covers the difference of two rates with 95%, for pairs.

    Args:
        both: Pairs in which both succeeded.
        a_alone: Pairs in which only the first did.
        b_alone: Pairs in which only the second did.
        neither: Pairs in which neither did.

    Source: Newcombe 1998, "Improved confidence intervals for the difference between binomial
    proportions based on paired data", method 10: Wilson's intervals squared and added, with the
    correlation of the pairs.
    """
    n = both + a_alone + b_alone + neither
    if n == 0:
        return -1.0, 1.0
    n_a, n_b = both + a_alone, both + b_alone
    p_a, p_b = n_a / n, n_b / n
    (low_a, high_a), (low_b, high_b) = wilson_interval(n_a, n), wilson_interval(n_b, n)
    product = both * neither - a_alone * b_alone
    # Newcombe's continuity correction of the correlation.
    if product > 0:
        product = max(product - n / 2, 0.0)
    margins = n_a * (n - n_a) * n_b * (n - n_b)
    phi = product / math.sqrt(margins) if margins else 0.0

    def reach(a: float, b: float) -> float:
        return math.sqrt(max(0.0, a * a - 2.0 * phi * a * b + b * b))

    below, above = reach(p_a - low_a, high_b - p_b), reach(high_a - p_a, p_b - low_b)
    return max(-1.0, p_a - p_b - below), min(1.0, p_a - p_b + above)


def compare(folder_a: Path, folder_b: Path) -> dict[str, Any]:
    """Compare two campaigns by their trials of the same tasks.

    Args:
        folder_a: Folder of a campaign.
        folder_b: Folder of another one.

    Returns:
        `pairs`; for each of `a` and `b` its rate over the pairs, `folder`, `pilot`, and trials
        `without_pair`; `both`, `a_alone`, `b_alone`, `neither`; `difference` of the rates, a less
        b, with its `interval_95`, and `p_value` by the exact test of McNemar; `groups`; `figures`,
        medians over pairs; `differing`, trials in which only one succeeded.

    Raises:
        CompareError: If they share no trial, or a trial is not the same task in both.
        StoreError: If a folder holds no results.
        CampaignError: If a manifest cannot be read.
    """
    a, b, whole = _pairs(folder_a, folder_b)
    good_a, good_b = (table["success"].to_numpy() for table in (a, b))
    sides = {
        name: {
            "folder": str(folder),
            "pilot": read_manifest(folder)["suite"]["pilot"],
            **share(int(good.sum()), len(good)),
            "without_pair": n - len(good),
        }
        for name, folder, good, n in zip(
            "ab", (folder_a, folder_b), (good_a, good_b), whole, strict=True
        )
    }
    return {
        "pairs": len(a),
        **sides,
        **_counts(_cells(good_a, good_b, np.zeros(len(a), int))[0]),
        "p_value": _p_value(good_a, good_b),
        "groups": _groups(a, good_a, good_b),
        "figures": _figures(a, b),
        "differing": _differing(a, b),
    }


def _pairs(folder_a: Path, folder_b: Path) -> tuple[pa.Table, pa.Table, tuple[int, int]]:
    """The rows of trials with a verdict in both, in one order, and each one's verdicts in all."""
    digests = [read_manifest(folder)["scenes_sha256"] for folder in (folder_a, folder_b)]
    if None not in digests and digests[0] != digests[1]:
        raise CompareError(
            f"{str(folder_a)!r} and {str(folder_b)!r} were flown in other versions of the scenes; "
            "valid: two campaigns in the same ones"
        )
    judged = pc.field("success").is_valid()
    a, b = (
        read_results(folder, _COLUMNS, where=judged).sort_by("trial_id")
        for folder in (folder_a, folder_b)
    )
    ids_a, ids_b = (table["trial_id"].combine_chunks() for table in (a, b))
    common_a = a.filter(pc.field("trial_id").isin(ids_b))
    common_b = b.filter(pc.field("trial_id").isin(ids_a))
    if not len(common_a):
        raise CompareError(
            f"{str(folder_a)!r} and {str(folder_b)!r} share no trial; valid: two campaigns with "
            "trials of the same scenes and vehicles"
        )
    _check_tasks(common_a, common_b)
    return common_a, common_b, (len(a), len(b))


def _check_tasks(a: pa.Table, b: pa.Table) -> None:
    """Refuse pairs that are not the same task; a trial that died has no task to compare."""
    # Rows of trials that ended without a flight have no conditions.
    is_known = pa.array(np.asarray(a["seed"].is_valid()) & np.asarray(b["seed"].is_valid()))
    a, b = a.filter(is_known), b.filter(is_known)
    for name in _TASK:
        if a[name].equals(b[name]):
            continue
        columns = (a["trial_id"], a[name], b[name])
        pairs = zip(*(column.to_pylist() for column in columns), strict=True)
        trial, first, second = next(pair for pair in pairs if pair[1] != pair[2])
        raise CompareError(
            f"trial {trial} is another task in the second campaign: {name} is {second!r} instead "
            f"of {first!r}; valid: two campaigns of one recipe"
        )


_CELLS = ("neither", "b_alone", "a_alone", "both")


def _cells(good_a: np.ndarray, good_b: np.ndarray, places: np.ndarray) -> Int[np.ndarray, "n 4"]:
    """Count the pairs of each place by `_CELLS`."""
    # Two bits give the cell: a succeeded, b succeeded.
    cells = np.bincount(4 * places + 2 * good_a + good_b, minlength=4 * (places.max() + 1))
    return cells.reshape(-1, len(_CELLS))


def _counts(cells: Int[np.ndarray, 4]) -> dict[str, Any]:
    table: dict[str, int] = dict(zip(_CELLS, cells.tolist(), strict=True))
    difference = (table["a_alone"] - table["b_alone"]) / sum(table.values())
    return {**table, "difference": difference, "interval_95": list(newcombe_interval(**table))}


def _p_value(good_a: np.ndarray, good_b: np.ndarray) -> float:
    """Return the chance of an outcome as one-sided or more, if neither pilot were the better.

    This is McNemar's exact test: differing pairs are tosses of a fair coin.
    """
    from scipy.stats import binomtest

    n_differ = int(np.sum(good_a != good_b))
    return float(binomtest(int(np.sum(good_a & ~good_b)), n_differ).pvalue) if n_differ else 1.0


def _groups(a: pa.Table, good_a: np.ndarray, good_b: np.ndarray) -> dict[str, Any]:
    found: dict[str, dict[str, Any]] = {}
    for name, group_of in GROUPS.items():
        labels = np.array(group_of(a).to_pylist(), dtype=str)
        values, places = np.unique(labels, return_inverse=True)
        counts = map(_counts, _cells(good_a, good_b, places))
        members = {
            value: {side: _rate(each, side) for side in "ab"} | each
            for value, each in zip(values.tolist(), counts, strict=True)
        }
        found[name] = {value: members[value] for value in sorted(members, key=natural)}
    return found


def _rate(counts: Mapping[str, Any], side: str) -> dict[str, Any]:
    """Return the rate of one side over the pairs that were counted."""
    n_successes = counts["both"] + counts[f"{side}_alone"]
    return share(n_successes, sum(counts[name] for name in _CELLS))


def _figures(a: pa.Table, b: pa.Table) -> list[dict[str, Any]]:
    """Medians over pairs with a figure; for most figures both flights must have succeeded."""
    both = np.asarray(a["success"]) & np.asarray(b["success"])
    return [row for figure in FIGURES if (row := _medians(figure, a, b, both)) is not None]


def _medians(figure: Figure, a: pa.Table, b: pa.Table, both: np.ndarray) -> dict[str, Any] | None:
    from scipy.stats import quantile_test

    first, second = figure.values(a), figure.values(b)
    counts = np.isfinite(first) & np.isfinite(second) & (both | figure.is_of_failures)
    if not counts.any():
        return None
    away = (first - second)[counts]
    low, high = quantile_test(away).confidence_interval()
    return {
        "figure": figure.title,
        "unit": figure.unit,
        "pairs": int(counts.sum()),
        "a": float(np.median(first[counts])),
        "b": float(np.median(second[counts])),
        "difference": float(np.median(away)),
        # Too few pairs bound it on no side.
        "interval_95": [None if math.isnan(end) else float(end) for end in (low, high)],
    }


def _differing(a: pa.Table, b: pa.Table) -> list[Mapping[str, Any]]:
    differ = pa.array(np.asarray(a["success"]) != np.asarray(b["success"]))
    rows = a.select(["trial_id", "code", "difficulty"]).filter(differ).to_pylist()
    codes = b.filter(differ)["code"].to_pylist()
    return [
        {"trial_id": row["trial_id"], "a": row["code"], "b": code, "difficulty": row["difficulty"]}
        for row, code in zip(rows, codes, strict=True)
    ]
