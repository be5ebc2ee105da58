"""The page of a campaign: one file without a server, which holds everything that it shows.

It can be sent or kept with the results, and opens in any browser.
"""

from __future__ import annotations

import functools
import shlex
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aeroscene.corpus.shipped import shipped_digest
from aeroscene.files import replacing
from scenarios.campaigns.campaign import read_manifest
from scenarios.campaigns.store import read_results
from scenarios.campaigns.summary import summarise_trials
from scenarios.reports.findings import (
    MOST_FAILURES,
    PAGE_COLUMNS,
    distributions,
    failures,
    plan_views,
    shown_scenes,
)

if TYPE_CHECKING:
    import jinja2

PAGE = "report.html"
_MOST_ROWS = 50
"""Most scenes that the table of groups names."""


def write_report(folder: Path, on_part: Callable[[str, float], None]) -> dict[str, Any]:
    """Write the page of a campaign into its folder.

    Args:
        folder: Folder of the campaign; it may still be flown.
        on_part: Called with the title of each part and the share of the work that is done.

    Returns:
        The summary of the campaign.

    Raises:
        StoreError: If the folder holds no results, or damaged ones.
        CampaignError: If its manifest cannot be read.
        OSError: If the page cannot be written.
    """
    on_part("results", 0.0)
    table = read_results(folder, PAGE_COLUMNS)
    summary = summarise_trials(table)
    on_part("figures", 0.3)
    found = distributions(table)
    # A large campaign's table takes much memory, and the parts below read their own.
    del table
    on_part("failures", 0.4)
    failed = failures(folder)
    scenes = shown_scenes(summary)

    def on_scene(name: str) -> None:
        on_part(f"scene {name}", 0.5 + 0.5 * scenes.index(name) / len(scenes))

    manifest = read_manifest(folder)
    # In other scenes the paths would be drawn over the wrong plans.
    has_scenes = manifest["scenes_sha256"] in (None, shipped_digest())
    views = plan_views(folder, scenes, on_scene) if has_scenes else []
    write_page(
        folder / PAGE,
        "report.html",
        folder=folder,
        command=shlex.join(["aeroscene", "report", str(folder)]),
        manifest=manifest,
        has_scenes=has_scenes,
        summary=summary,
        groups=telling_groups(summary),
        distributions=found,
        failures=failed,
        n_failures=summary["trials"] - summary["successes"],
        most_failures=MOST_FAILURES,
        most_rows=_MOST_ROWS,
        views=views,
        has_plans=any(way.planned for view in views for way in view.ways),
        n_scenes=len(summary["groups"]["scene"]),
    )
    return summary


def telling_groups(summary: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    """Return the groupings of a summary, or of a comparison, with more than one group."""
    return {name: members for name, members in summary["groups"].items() if len(members) > 1}


def write_page(path: Path, template: str, **facts: Any) -> None:
    """Render a template of this package into a file, whole or not at all.

    Args:
        path: The file, which is replaced.
        template: Name of the template.
        facts: Variables of the template; a missing one is an error.

    Raises:
        OSError: If it cannot be written.
    """
    text = _environment().get_template(template).render(**facts)
    with replacing(path) as file:
        file.write(text.encode())


@functools.cache
def _environment() -> jinja2.Environment:
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("scenarios.reports"),
        # Names and reasons come from results that may be anybody's.
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["percent"] = lambda share: "" if share is None else f"{share:.1%}"
    environment.filters["figure"] = _three_digits
    return environment


def _three_digits(value: float) -> str:
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"
