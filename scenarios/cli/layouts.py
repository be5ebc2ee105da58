"""`aeroscene layouts`: report how layouts of other projects map to ours, and convert them."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro
from rich.table import Table

from aeroscene.files.names import file_name
from aeroscene.layouts.document import LayoutError, NeutralLayout
from aeroscene.layouts.mapping import MappingReport
from aeroscene.layouts.reader import read_layouts
from aeroscene.scene import SceneError
from aeroscene.scene.io import write_scene
from aeroscene.sources import is_map
from scenarios.cli.command_line import EXIT_DONE, EXIT_NEGATIVE, print_json
from scenarios.cli.outputs import OutFolder
from scenarios.cli.progress import progress_bar
from scenarios.cli.terminal import Terminal, styled, terminal

_SHOWN = 20
"""Entries of a list that the terminal shows."""


@dataclass(frozen=True, kw_only=True)
class LayoutsCfg:
    """Report how a file of layouts maps to our categories, and convert it to scenes.

    Reads JSON lines of neutral layouts, the AeroScene authors' JSON and 3D-FRONT's own, plain or
    gzip; and places on maps as FILE.osm#W,S,E,N. Exit status 0 if everything is valid, 1 if
    something was skipped as invalid.
    """

    file: tyro.conf.Positional[Path]
    """The file of layouts."""
    out: Annotated[Path | None, OutFolder(), tyro.conf.arg(help_behavior_hint="")] = None
    """Folder to write each layout into as a scene, SCENE_ID.json."""
    skip_invalid: bool = False
    """Leave out objects and scenes that break a rule, name and count them, and continue."""
    json: bool = False
    """Print one JSON object: scenes, objects, mapped, unmapped, dropped, invalid, written."""


def run(cfg: LayoutsCfg) -> int:
    """Report the mapping, and convert the layouts if asked to.

    Returns:
        0, or 1 if something was skipped as invalid.

    Raises:
        SceneError: If the file breaks a rule and nothing is to be skipped.
    """
    if is_map(str(cfg.file)):
        return _run_map(cfg)
    faults: list[str] = []
    total = MappingReport()
    written: dict[str, str] = {}
    for layout in _with_progress(cfg, faults):
        try:
            report = _take(layout, cfg, written)
        except SceneError as error:
            if not cfg.skip_invalid:
                raise error.within(f"layout file {str(cfg.file)!r}") from None
            faults.append(str(error))
            continue
        total += report
    total += MappingReport(invalid=tuple(faults))
    if cfg.json:
        print_json(total.to_plain() | {"written": list(written)})
    else:
        _print_report(total, written, cfg)
    return EXIT_NEGATIVE if total.invalid else EXIT_DONE


def _run_map(cfg: LayoutsCfg) -> int:
    """Report what a place on a map was turned into, and write its scene if asked to."""
    from aeroscene.maps import open_map

    # Bounds are part of the name, as in `FILE.osm#W,S,E,N`.
    path, _, bounds = str(cfg.file).partition("#")
    scene, report = open_map(path, bounds or None)
    written: list[str] = []
    if cfg.out is not None:
        _make_folder(cfg.out)
        name = f"{file_name(scene.scene_id)}.json"
        with _named_failures(cfg.out / name):
            write_scene(scene, cfg.out / name)
        written.append(name)
    counts = Counter(obj.category for obj in scene.objects)
    if cfg.json:
        facts = {"features": report.n_features, "objects": report.n_objects}
        more = {"by_category": dict(counts), "dropped": report.dropped, "notes": report.notes}
        print_json({"scenes": 1, **facts, **more, "written": written})
        return EXIT_DONE
    console = terminal()
    figures = f": {report.n_features} features, {report.n_objects} objects"
    console.print(styled((scene.scene_id, "bold"), figures), soft_wrap=True)
    listed = ", ".join(f"{name} {count}" for name, count in counts.most_common())
    console.print(listed, soft_wrap=True)
    for line in report.lines:
        console.print(line, soft_wrap=True)
    if cfg.out is not None:
        console.print(f"1 scene written to {cfg.out}", soft_wrap=True)
    return EXIT_DONE


def _with_progress(cfg: LayoutsCfg, faults: list[str]) -> Iterator[NeutralLayout]:
    """Yield the layouts of the file, with a progress bar while they are converted."""
    if cfg.out is None:
        yield from read_layouts(cfg.file, cfg.skip_invalid, faults)
        return
    # The file is read twice, so that one with a fault further down is refused before anything is
    # written.
    count = sum(1 for _ in read_layouts(cfg.file, cfg.skip_invalid, faults))
    _make_folder(cfg.out)
    with progress_bar("converting", count, "layouts") as advance:
        for layout in read_layouts(cfg.file, cfg.skip_invalid):
            yield layout
            advance()


def _take(layout: NeutralLayout, cfg: LayoutsCfg, written: dict[str, str]) -> MappingReport:
    # Imported here because shapely is slow to import and a bad command line should fail fast.
    from aeroscene.layouts.flyable import make_flyable, map_layout

    if cfg.out is None:
        return map_layout(layout)
    scene, report = make_flyable(layout)
    path = cfg.out / _new_name(scene.scene_id, written)
    with _named_failures(path):
        write_scene(scene, path)
    written[path.name] = scene.scene_id
    return report


def _new_name(scene_id: str, written: Mapping[str, str]) -> str:
    """Return a free name for a scene's file, because `a/b` and `a b` both become `a-b`."""
    name = clean = file_name(scene_id)
    number = 1
    while f"{name}.json" in written:
        number += 1
        name = f"{clean}-{number}"
    return f"{name}.json"


def _make_folder(folder: Path) -> None:
    with _named_failures(folder):
        folder.mkdir(parents=True, exist_ok=True)


@contextmanager
def _named_failures(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        reason = (error.strerror or type(error).__name__).lower()
        raise LayoutError(
            f"out {str(path)!r} cannot be written ({reason}); valid: a folder to write to"
        ) from None


def _print_report(report: MappingReport, written: Mapping[str, str], cfg: LayoutsCfg) -> None:
    console = terminal()
    counts = (
        f": {report.n_scenes} scenes, {report.n_objects} objects, "
        f"{report.n_mapped} mapped, {sum(report.unmapped.values())} unmapped, "
        f"{sum(report.dropped.values())} dropped, {len(report.invalid)} invalid"
    )
    console.print(styled((cfg.file.name, "bold"), counts))
    if report.by_fit:
        fits = ", ".join(f"{count} {fit}" for fit, count in report.by_fit.items())
        console.print(f"How they were mapped: {fits}")
        console.print(_categories_table(report))
    _print_counts(console, "unmapped", report.unmapped)
    _print_counts(console, "dropped", report.dropped)
    _warn("unmapped", report.unmapped_lines)
    _warn("invalid", report.invalid)
    if cfg.out is not None:
        console.print(f"{len(written)} scenes written to {cfg.out}", soft_wrap=True)


def _warn(kind: str, lines: Sequence[str]) -> None:
    for line in lines[:_SHOWN]:
        sys.stderr.write(f"aeroscene layouts: {kind}: {line}\n")
    if len(lines) > _SHOWN:
        sys.stderr.write(f"aeroscene layouts: {kind}: and {len(lines) - _SHOWN} more\n")


def _categories_table(report: MappingReport) -> Table:
    table = Table("our category", "objects", "from the source's (* stand-in)")
    for category, count in report.by_category.items():
        names = [
            f"{name} {n}{'*' if fit == 'stand-in' else ''}"
            for (name, ours, fit), n in sorted(report.mapped.items(), key=lambda item: -item[1])
            if ours == category
        ]
        more = f", and {len(names) - 6} more" if len(names) > 6 else ""
        table.add_row(category, str(count), ", ".join(names[:6]) + more)
    return table


def _print_counts(console: Terminal, title: str, counts: Mapping[str, int]) -> None:
    if counts:
        ranked = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
        listed = ", ".join(f"{name} {count}" for name, count in ranked[:_SHOWN])
        more = f", and {len(ranked) - _SHOWN} more" if len(ranked) > _SHOWN else ""
        console.print(f"{title}: {listed}{more}")
