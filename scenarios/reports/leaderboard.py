"""A leaderboard: an entry for each flight stack that flew a fixed suite, as JSON and as a table.

Only whole fixed suites count, because rates over different tasks cannot be compared.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc

from aeroscene.files import read_bounded, replacing
from scenarios.campaigns.campaign import read_manifest
from scenarios.campaigns.fixed import FixedSuite, fixed_suites
from scenarios.campaigns.store import read_results
from scenarios.campaigns.summary import summarise_trials
from scenarios.reports.findings import PAGE_COLUMNS, distributions
from scenarios.tasks.recipe import recipe_from

_FORMAT = "aeroscene-leaderboard"
_MOST_BYTES = 4 << 20
_KEY = ("suite", "suite_version", "stack", "version")
"""Fields that identify an entry: only one entry of a leaderboard has the same values in all of
them."""


class LeaderboardError(ValueError):
    """A campaign or a file is not fit for a leaderboard; one line says why, and what would be."""


def update_leaderboard(path: Path, folder: Path, stack: str | None = None) -> dict[str, Any]:
    """Add the entry of a campaign to a leaderboard, or replace its earlier one.

    Args:
        path: JSON file, created if it is missing; the table is beside it, as Markdown.
        folder: Folder of a campaign that flew a whole fixed suite.
        stack: Name of the flight stack; None is that of the pilot.

    Returns:
        The entry.

    Raises:
        LeaderboardError: If the campaign flew no fixed suite, or not all of it, or the file is not
            a leaderboard.
        CampaignError: If the campaign's manifest cannot be read.
        StoreError: If the folder holds no results.
        OSError: If a file cannot be written.
    """
    if path.suffix != ".json":
        raise LeaderboardError(f"leaderboard {str(path)!r} is no .json file; valid: NAME.json")
    # Read before the campaign is summarised: a file that is no leaderboard fails at once.
    entries = _read(path)
    entry = _entry(folder, stack)
    others = [each for each in entries if any(each[name] != entry[name] for name in _KEY)]
    entries = sorted([*others, entry], key=_rank)
    with replacing(path) as file:
        document = {"format": _FORMAT, "entries": entries}
        file.write(json.dumps(document, indent=2).encode() + b"\n")
    with replacing(path.with_suffix(".md")) as file:
        file.write(_markdown(entries).encode())
    return entry


def _entry(folder: Path, stack: str | None) -> dict[str, Any]:
    manifest = read_manifest(folder)
    suite = _suite_of(folder, manifest)
    # Further trials in the folder do not count.
    wanted = pa.array([trial.id for trial in suite.all_trials()], pa.string())
    columns = ("trial_id", *PAGE_COLUMNS)
    table = read_results(folder, columns, where=pc.field("trial_id").isin(wanted))
    if (n_left := len(wanted) - len(table)) > 0:
        raise LeaderboardError(
            f"{str(folder)!r} lacks {n_left} of the {len(wanted)} trials of {suite.name}; valid: "
            f"the whole suite, as `aeroscene campaign --suite {suite.name}` flies it"
        )
    summary = summarise_trials(table)
    phases = summary["phases"]
    return {
        "suite": suite.name,
        "suite_version": suite.version,
        "stack": stack or manifest["suite"]["pilot"],
        "version": manifest["version"],
        "began": manifest["began"],
        **{name: summary[name] for name in ("trials", "successes", "success_rate", "interval_95")},
        "navigation_rate": phases["navigation"]["success_rate"],
        "interaction_rate": phases["interaction"]["success_rate"],
        "medians": {
            " over ".join(each.figure.columns): round(each.median, 4)
            for each in distributions(table)
        },
    }


def _suite_of(folder: Path, manifest: Mapping[str, Any]) -> FixedSuite:
    found = manifest["suite"]
    recipes = {name: recipe_from(plain) for name, plain in found["families"].items()}
    # Recognised by its recipes and scenes, not by a name that anybody could write into a manifest.
    flown = (recipe_from(found["recipe"]), recipes, manifest["scenes_sha256"])
    suites = fixed_suites()
    for suite in suites:
        if (suite.recipe, suite.families, suite.scenes_sha256) == flown:
            return suite
    raise LeaderboardError(
        f"{str(folder)!r} has another recipe or other scenes than a fixed suite; valid: a campaign "
        f"of --suite {' or '.join(suite.name for suite in suites)}"
    )


def _read(path: Path) -> list[dict[str, Any]]:
    if not path.exists():
        return []
    try:
        document = json.loads(read_bounded(path, _MOST_BYTES))
        entries = document["entries"]
        if document["format"] == _FORMAT and all(set(_KEY) <= set(each) for each in entries):
            return entries
    except (ValueError, KeyError, TypeError, RecursionError):
        pass
    raise LeaderboardError(
        f"leaderboard {str(path)!r} is none; valid: what `aeroscene report --leaderboard` has "
        "written, or a new file"
    )


def _rank(entry: Mapping[str, Any]) -> tuple[str, int, float, str]:
    rate = entry["success_rate"] or 0.0
    return entry["suite"], -entry["suite_version"], -rate, entry["stack"]


def _markdown(entries: Sequence[Mapping[str, Any]]) -> str:
    """Return the entries as a Markdown table, the best of each suite first."""
    figures = list(dict.fromkeys(name for entry in entries for name in entry["medians"]))
    heads = ["suite", "stack", "version", "begun", "trials", "success", "95% interval"]
    heads += ["navigation", "interaction", *(f"median {name}" for name in figures)]
    rows = []
    for entry in entries:
        low, high = entry["interval_95"]
        rows.append(
            [
                f"{entry['suite']} {entry['suite_version']}",
                *(str(entry[name]) for name in ("stack", "version", "began", "trials")),
                _percent(entry["success_rate"]),
                f"{low:.1%} to {high:.1%}",
                _percent(entry["navigation_rate"]),
                _percent(entry["interaction_rate"]),
                *(f"{entry['medians'].get(name, '')}" for name in figures),
            ]
        )
    lines = [heads, ["---"] * len(heads), *rows]
    # A name may contain the character that separates cells.
    cells = ([cell.replace("|", "\\|") for cell in line] for line in lines)
    return "".join(f"| {' | '.join(line)} |\n" for line in cells)


def _percent(share: float | None) -> str:
    return "" if share is None else f"{share:.1%}"
