"""Leads of one method over the best of the others, column by column.

A table of dozens of columns is hard to read. A lead states for each column which other method is
best, by how many percent ours is ahead or behind, and whether the intervals are apart.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import msgspec

from aeroscene.metrics.scorecard import Metric
from scenarios.evaluation.rows import Row

_DIGITS = 3


class Lead(msgspec.Struct, frozen=True, kw_only=True):
    """A method in one column, beside the best of the others."""

    metric: str
    value: float
    other: str
    """Name of the best of the other methods."""
    other_value: float
    lead_percent: float | None
    """Difference as a percentage of the other's value, positive if this method is better; None if
    the other has 0."""
    is_apart: bool
    """True if it is better, and the two 95% intervals do not overlap."""


def leads_of(
    method: str, others: Collection[str], rows: Sequence[Row], metrics: Mapping[str, Metric]
) -> list[Lead]:
    """Compare a method with the best of others in every column that has a better direction.

    Args:
        method: Name of the method.
        others: Names of the methods to compare with.
        rows: Figures of all of them.
        metrics: Metrics of the columns, in the order of the table.

    Returns:
        One lead for each column in which the method and at least one other have a figure.
    """
    cells = {(row.method, row.metric): row for row in rows if row.value is not None}
    found: list[Lead] = []
    for key, metric in metrics.items():
        own = cells.get((method, key))
        rivals = [row for name in others if (row := cells.get((name, key))) is not None]
        if own is None or metric.better is None or not rivals:
            continue
        # With the sign, more is better in every column.
        sign = 1.0 if metric.better == "higher" else -1.0
        best = max(rivals, key=lambda row: sign * _value(row))
        ahead = sign * (_value(own) - _value(best))
        found.append(
            Lead(
                metric=key,
                value=_value(own),
                other=best.method,
                other_value=_value(best),
                lead_percent=100.0 * ahead / abs(_value(best)) if best.value else None,
                is_apart=ahead > 0 and _are_apart(own, best),
            )
        )
    return found


def _value(row: Row) -> float:
    assert row.value is not None
    return row.value


def _are_apart(own: Row, other: Row) -> bool:
    if own.interval_95 is None or other.interval_95 is None:
        return False
    return own.interval_95[0] > other.interval_95[1] or own.interval_95[1] < other.interval_95[0]


def leads_markdown(leads: Sequence[Lead], titles: Mapping[str, str]) -> str:
    """Return a Markdown table of leads, with a line for each column.

    Args:
        leads: Leads of one method.
        titles: Titles of the methods, by name.
    """
    lines = [["metric", "value", "best of the others", "its value", "ahead by, %", "intervals"]]
    lines.append(["---"] * len(lines[0]))
    for lead in leads:
        ahead = "" if lead.lead_percent is None else f"{round(lead.lead_percent)}"
        apart = "apart" if lead.is_apart else "overlap or behind"
        values = f"{lead.value:.{_DIGITS}g}", f"{lead.other_value:.{_DIGITS}g}"
        other = titles.get(lead.other, lead.other)
        lines.append([f"`{lead.metric}`", values[0], other, values[1], ahead, apart])
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)
