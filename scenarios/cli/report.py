"""`aeroscene report`: the results of a campaign as tables and as a page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro
from rich.table import Table

from scenarios.cli.command_line import EXIT_DONE, default_hint, fail, print_json
from scenarios.cli.outputs import OutFile
from scenarios.cli.progress import share_bar
from scenarios.cli.terminal import Terminal, terminal

_PROG = "aeroscene report"
_MOST_SCENES = 12
"""Scenes that a table names one by one."""


@dataclass(frozen=True, kw_only=True)
class ReportCfg:
    """Print the results of a campaign so far, and write the full report as DIR/report.html.

    Success by groups and phases, each rate with the interval that covers the true one with 95%
    (Wilson). The page needs no server: charts, paths over the scenes, failures with their replays.
    """

    folder: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="DIR")]
    """Folder of a campaign, also of one that is being flown."""
    leaderboard: Annotated[Path | None, OutFile(), default_hint("none")] = None
    """JSON file to which this campaign's entry is added, with a table in Markdown beside it. Only a
    campaign that flew a whole fixed suite has an entry, see docs/campaigns.md."""
    stack: Annotated[str | None, default_hint("the pilot's")] = None
    """Name of the flight stack in the leaderboard."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object instead: trials, success_rate, interval_95, without_task, phases,
    groups, codes, cpu_seconds_per_trial, page."""


def run(cfg: ReportCfg) -> int:
    """Write the page, print the tables, and add to a leaderboard if asked to.

    Returns:
        0. A folder without a campaign ends the process with status 2 and one line.
    """
    # pyarrow and the simulator: half a second that `--help` does not need.
    from scenarios.campaigns.campaign import CampaignError
    from scenarios.campaigns.store import StoreError
    from scenarios.reports.leaderboard import LeaderboardError, update_leaderboard
    from scenarios.reports.page import PAGE, write_report

    try:
        with share_bar() as on_part:
            summary = write_report(cfg.folder, on_part)
        if cfg.leaderboard is not None:
            update_leaderboard(cfg.leaderboard, cfg.folder, cfg.stack)
    except (CampaignError, LeaderboardError, StoreError) as error:
        fail(_PROG, str(error))
    page = cfg.folder / PAGE
    if cfg.json:
        print_json({"folder": str(cfg.folder), **summary, "page": str(page)})
    else:
        print_summary(terminal(), summary)
        print(f"With charts, ways and replays: {page}")
    return EXIT_DONE


def print_summary(console: Terminal, summary: Mapping[str, Any]) -> None:
    """Print the summary of a campaign as tables.

    Args:
        console: Terminal to print on.
        summary: Summary as `Campaign.summary` returns it, and as OUT/summary.json holds it.
    """
    rates = Table(
        "", "trials", "success", "95% interval", "grade", "95% interval", title_justify="left"
    )
    _add_rate(rates, "all", summary)
    for phase, rate in summary["phases"].items():
        _add_rate(rates, phase, rate)
    for name, members in summary["groups"].items():
        # A group of one member repeats the line of all trials.
        if len(members) < 2 or (name == "scene" and len(members) > _MOST_SCENES):
            continue
        rates.add_section()
        for value, rate in members.items():
            _add_rate(rates, f"{name} {value}", rate)
    console.print(rates)
    if (words := summary["words"]) is not None:
        console.print(_words_table(words))
    codes = Table("code", "trials")
    for code, count in summary["codes"].items():
        codes.add_row(code, str(count))
    console.print(codes)
    if summary["without_task"]:
        console.print(f"{summary['without_task']} trials had no task and count nowhere.")


def _words_table(words: Mapping[str, Any]) -> Table:
    """Return the table of scores of goals in words."""
    table = Table("goals in words", "trials", "", "95% interval")
    for name, score in words.items():
        is_rate = "success_rate" in score
        # Shares are printed as percentages, means such as SPL and errors as numbers.
        value, form = (
            score["success_rate" if is_rate else "mean"],
            "{:.1%}" if is_rate else "{:.2f}",
        )
        ends = score["interval_95"] or []
        table.add_row(
            name.replace("_", " "),
            str(score["trials"]),
            "" if value is None else form.format(value),
            " to ".join(form.format(end) for end in ends),
        )
    return table


def _add_rate(table: Table, name: str, rate: Mapping[str, Any]) -> None:
    if not rate["trials"]:
        table.add_row(name, "0", "", "", "", "")
        return
    low, high = rate["interval_95"]
    mean, ends = rate.get("grade"), rate.get("grade_interval_95")
    table.add_row(
        name,
        str(rate["trials"]),
        f"{rate['success_rate']:.1%}",
        f"{low:.1%} to {high:.1%}",
        "" if mean is None else f"{mean:.2f}",
        "" if ends is None else f"{ends[0]:.2f} to {ends[1]:.2f}",
    )
