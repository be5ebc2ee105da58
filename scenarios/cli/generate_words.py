"""The report that `aeroscene generate` prints at its end."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.table import Table
from rich.text import Text

from scenarios.cli.command_line import print_json
from scenarios.cli.terminal import styled, terminal

if TYPE_CHECKING:
    from scenarios.generation.draws import Tally
    from scenarios.generation.wish_outcomes import WishOutcome

_PROG = "aeroscene generate"
_MOST_ROWS = 20
"""Scenes whose figures the terminal shows beside the wishes."""
_MOST_COLUMNS = 5
"""Wishes that have a column each; with more of them each has a row."""
_MOST_SCENES = 2
"""Scenes beside each other in a table with a row for each wish."""
_UNITS = {"outline": "m", "min_passage": "m"}
_MISSED = "*"  # The colour alone would be lost in a pipe.
_AGAIN = "--strict draws those again"


def print_generated(
    out: Path, device: str, tally: Tally, more: Mapping[str, Any], *, as_json: bool
) -> None:
    """Print the results, and the seeds that gave no scene on standard error.

    Args:
        out: Folder of the scenes.
        device: Where the model computed.
        tally: Results of the draws.
        more: Further facts, such as the flights of the worst scenes.
        as_json: True prints one JSON object instead of text.
    """
    for seed, reason in tally.failed.items():
        sys.stderr.write(f"{_PROG}: seed {seed} gave no scene: {reason}\n")
    if as_json:
        print_json({**_facts(device, tally), **more})
        return
    for each in more.get("worst", ()):
        print(f"{each['scene']}: {each['reason']}")
    if tally.wishes:
        _print_wishes(tally.wishes, "--strict keeps none" if tally.prompt else _AGAIN)
    print(
        f"{out}: {len(tally.files)} scenes, {_seconds(tally):.2f} s each on {device}, "
        f"{tally.n_rejected} draws rejected"
    )


def _facts(device: str, tally: Tally) -> dict[str, Any]:
    # Collision rates before and after the projection; docs/model.md describes both.
    stages = {
        "sampled": {"collision_rate": _mean(tally.sampled), "rejected": 0},
        "feasible": {"collision_rate": _mean(tally.feasible), "rejected": tally.n_rejected},
    }
    facts: dict[str, Any] = {
        "scenes": sorted(tally.files),
        "seconds_per_scene": _seconds(tally),
        "device": device,
        "failed": sorted(tally.failed),
        "stages": stages,
    }
    if tally.wishes:
        facts["wishes"] = {
            file: {name: wish.to_plain() for name, wish in wishes.items()}
            for file, wishes in sorted(tally.wishes.items())
        }
        facts["missed"] = _missed(tally.wishes)
    return facts | ({"measured": tally.measured} if tally.measured else {})


def _print_wishes(all_wishes: Mapping[str, Mapping[str, WishOutcome]], again: str = _AGAIN) -> None:
    """Print a table of the figures of each scene below the wishes.

    Args:
        all_wishes: Wish and measured figure, by file and name of the wish.
        again: Remark about scenes that are not as asked for.
    """
    files = sorted(all_wishes)
    is_wide = len(all_wishes[files[0]]) > _MOST_COLUMNS
    most = _MOST_SCENES if is_wide else _MOST_ROWS
    console = terminal()
    console.print((_by_wish if is_wide else _by_scene)(all_wishes, files[:most]))
    if len(files) > most:
        console.print(f"and {len(files) - most} more; --json lists them")
    if missed := _missed(all_wishes):
        console.print(
            f"{_MISSED} {len(missed)} of {len(files)} scenes are not as asked for; {again}",
            soft_wrap=True,
        )


def _by_scene(all_wishes: Mapping[str, Mapping[str, WishOutcome]], files: Sequence[str]) -> Table:
    """Return a table with a row for each scene."""
    first = all_wishes[files[0]]
    table = Table("", *map(_titled, first))
    table.add_row("asked for", *(str(wish.requested) for wish in first.values()))
    table.add_section()
    for file in files:
        table.add_row(Path(file).name, *map(_cell, all_wishes[file].values()))
    return table


def _by_wish(all_wishes: Mapping[str, Mapping[str, WishOutcome]], files: Sequence[str]) -> Table:
    """Return a table with a row for each wish, for more wishes than a terminal has columns."""
    table = Table("", "asked for", *(Path(file).stem for file in files), "met in")
    for name, wish in all_wishes[files[0]].items():
        n_met = sum(wishes[name].is_met for wishes in all_wishes.values())
        measured = (_cell(all_wishes[file][name]) for file in files)
        table.add_row(
            _titled(name), str(wish.requested), *measured, f"{n_met} of {len(all_wishes)}"
        )
    return table


def _titled(name: str) -> str:
    return f"{name}, {_UNITS[name]}" if name in _UNITS else name


def _cell(wish: WishOutcome) -> Text:
    measured = "none" if wish.measured is None else str(wish.measured)
    return styled(measured) if wish.is_met else styled((f"{measured} {_MISSED}", "bold red"))


def _missed(all_wishes: Mapping[str, Mapping[str, WishOutcome]]) -> list[str]:
    """Return the files of the scenes that miss a wish."""
    return sorted(
        file
        for file, wishes in all_wishes.items()
        if not all(wish.is_met for wish in wishes.values())
    )


def _seconds(tally: Tally) -> float:
    return tally.seconds / max(1, len(tally.files))


def _mean(values: Sequence[float]) -> float | None:
    return sum(values) / len(values) if values else None
