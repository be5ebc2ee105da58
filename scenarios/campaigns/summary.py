"""Summary of a campaign: success with its interval, overall and by groups, and codes."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import pyarrow as pa

from scenarios.campaigns.flyer import Row

_Z_95 = 1.959963984540054
"""Quantile of the normal law for an interval of 95%."""
_WINDS_MPS = (2.0, 4.0, 6.0)
"""Where one class of wind ends and the next begins."""
GROUPS: Mapping[str, Callable[[Row], str]] = {
    "vehicle": lambda row: row["vehicle"],
    "scene": lambda row: row["scene"],
    "difficulty": lambda row: row["difficulty"] or "unknown",
    "wind": lambda row: _wind(row["wind_mps"]),
    "map": lambda row: row["map"] or "unknown",
}
"""What trials are grouped by, and the group of a row."""
_COLUMNS = ("success", "code", "navigated", "wind_mps", "trial_cpu_seconds", *GROUPS)


def wilson_interval(n_successes: int, n: int) -> tuple[float, float]:
    """Interval that covers a rate with 95%.

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
    """Summary of results as plain data.

    Args:
        table: Rows of `store.SCHEMA`.

    Returns:
        `trials`, `success_rate`, `interval_95`; `without_task`, trials that a scene has no task
        for, which count nowhere else; `phases`, of which interaction counts only flights that came
        to their area; `groups` by name and value; `codes` with their counts, most frequent first.
    """
    columns = [name for name in dict.fromkeys(_COLUMNS) if name in table.column_names]
    rows = table.select(columns).to_pylist()
    judged = [row for row in rows if row["success"] is not None]
    came = [row for row in judged if row["navigated"] or row["success"]]
    groups = {}
    for name, group_of in GROUPS.items():
        members: dict[str, list[Row]] = {}
        for row in judged:
            members.setdefault(group_of(row), []).append(row)
        groups[name] = {value: _rate(members[value]) for value in sorted(members, key=_natural)}
    return {
        **_rate(judged),
        "without_task": len(rows) - len(judged),
        "phases": {
            "navigation": _share(len(came), len(judged)),
            "interaction": _rate(came),
        },
        "groups": groups,
        "codes": dict(Counter(row["code"] for row in rows).most_common()),
        "cpu_seconds_per_trial": _mean(row["trial_cpu_seconds"] for row in rows),
    }


def _rate(rows: list[Row]) -> dict[str, Any]:
    return _share(sum(row["success"] for row in rows), len(rows))


def _share(n_successes: int, n: int) -> dict[str, Any]:
    low, high = wilson_interval(n_successes, n)
    return {
        "trials": n,
        "successes": n_successes,
        "success_rate": n_successes / n if n else None,
        "interval_95": [low, high],
    }


def _mean(values: Iterable[float | None]) -> float | None:
    present = [value for value in values if value is not None]
    return sum(present) / len(present) if present else None


def _wind(speed_mps: float | None) -> str:
    if speed_mps is None:
        return "unknown"
    low = max((edge for edge in (0.0, *_WINDS_MPS) if edge <= speed_mps), default=0.0)
    high = next((edge for edge in _WINDS_MPS if edge > speed_mps), None)
    return f"{low:g} m/s and more" if high is None else f"{low:g} to {high:g} m/s"


def _natural(text: str) -> tuple[int, float, str]:
    """Order of names: numbers by value, before words; grades from easy to hard."""
    grades = ("easy", "medium", "hard")
    if text in grades:
        return (1, grades.index(text), "")
    return (0, float(text), "") if text.isdecimal() else (2, 0.0, text)
