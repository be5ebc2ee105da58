"""`aeroscene compare`: two pilots compared by the trials that both have flown."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro
from rich.table import Column, Table

from scenarios.cli.command_line import EXIT_DONE, default_hint, fail, print_json
from scenarios.cli.outputs import OutFile
from scenarios.cli.terminal import Terminal, styled, terminal

_PROG = "aeroscene compare"
# Words of the terminal, and the keys that hold the counts of pairs by who succeeded.
_COUNTS = {"A alone": "a_alone", "B alone": "b_alone", "both": "both", "neither": "neither"}
_MOST_ROWS = 20
"""Trials and members of a group that the terminal shows one by one."""


@dataclass(frozen=True, kw_only=True)
class CompareCfg:
    """Compare two pilots by the trials that both have flown, pair by pair.

    Only trials of the same task count: same scene, start, area, wind, sensors and seed. The
    interval of the difference is Newcombe's for pairs, the p value that of McNemar's exact test.
    """

    first: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="DIR_A")]
    """Folder of a campaign."""
    second: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="DIR_B")]
    """Folder of another campaign, with the same recipe and another pilot or version."""
    html: Annotated[Path | None, OutFile(), default_hint("none")] = None
    """File for a page of the comparison."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object instead: pairs, a, b, both, a_alone, b_alone, neither, difference,
    interval_95, p_value, groups, figures, differing."""


def run(cfg: CompareCfg) -> int:
    """Print the comparison, and write the page if one is asked for.

    Returns:
        0. Folders without a pair of trials end the process with status 2 and one line.
    """
    # pyarrow and the simulator: half a second that `--help` does not need.
    from scenarios.campaigns.campaign import CampaignError
    from scenarios.campaigns.store import StoreError
    from scenarios.reports.page import telling_groups, write_page
    from scenarios.reports.paired_comparison import CompareError, compare

    try:
        found = compare(cfg.first, cfg.second)
        if cfg.html is not None:
            write_page(cfg.html, "compare.html", found=found, groups=telling_groups(found))
    except (CampaignError, CompareError, StoreError) as error:
        fail(_PROG, str(error))
    if cfg.json:
        print_json(found)
    else:
        _print(terminal(), found, telling_groups(found))
        if cfg.html is not None:
            print(f"Page: {cfg.html}")
    return EXIT_DONE


def _print(
    console: Terminal, found: Mapping[str, Any], groups: Mapping[str, Mapping[str, Any]]
) -> None:
    for side in "ab":
        facts = found[side]
        console.print(
            styled(
                (side.upper(), "bold"),
                f" {facts['pilot']}, {facts['folder']}: {found['pairs']} pairs, "
                f"{facts['without_pair']} trials without",
            ),
            soft_wrap=True,
        )
    rates = Table(Column(no_wrap=True), "pairs", "A", "B", "A - B", "95% interval")
    _add(rates, "all", found)
    for name, members in groups.items():
        if len(members) > _MOST_ROWS:
            continue  # --json has the long groups too.
        rates.add_section()
        for value, member in members.items():
            _add(rates, f"{name} {value}", member)
    console.print(rates)
    # McNemar's test needs nothing but these counts: pairs that agree say nothing of a difference.
    counts = (f"{says} {found[name]}" for says, name in _COUNTS.items())
    console.print(f"{', '.join(counts)}; p = {found['p_value']:.3g} (McNemar, exact)")
    figures = Table("median of pairs", "pairs", "A", "B", "A - B", "95% interval")
    for row in found["figures"]:
        low, high = ("" if end is None else f"{end:.3g}" for end in row["interval_95"])
        figures.add_row(
            ", ".join(filter(None, (row["figure"], row["unit"]))),
            str(row["pairs"]),
            *(f"{row[name]:.3g}" for name in ("a", "b", "difference")),
            f"{low} to {high}" if low and high else "",
        )
    console.print(figures)
    if not found["differing"]:
        return
    trials = Table("one alone", "difficulty", "A", "B")
    for row in found["differing"][:_MOST_ROWS]:
        trials.add_row(row["trial_id"], row["difficulty"] or "", row["a"], row["b"])
    console.print(trials)
    if (n_more := len(found["differing"]) - _MOST_ROWS) > 0:
        console.print(f"and {n_more} more; --json and --html list them")


def _add(table: Table, name: str, member: Mapping[str, Any]) -> None:
    low, high = member["interval_95"]
    table.add_row(
        name,
        str(member["a"]["trials"]),
        f"{member['a']['success_rate']:.1%}",
        f"{member['b']['success_rate']:.1%}",
        f"{member['difference']:+.1%}",
        f"{low:+.1%} to {high:+.1%}",
    )
