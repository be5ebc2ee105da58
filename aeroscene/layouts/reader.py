"""Layout files of any known form, distinguished by their content."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal

from aeroscene.layouts.aeroscene_json import aeroscene_layout
from aeroscene.layouts.document import LayoutError, NeutralLayout
from aeroscene.layouts.front3d import front3d_layout, house_value, read_model_info
from aeroscene.layouts.mapping import MappingReport
from aeroscene.layouts.neutral_format import neutral_layout, read_each, read_neutral
from aeroscene.layouts.text_file import parse_json, read_bytes, source_name
from aeroscene.layouts.thor import KEYS, read_asset_sizes, thor_layout
from aeroscene.scene import Scene

LINE_SUFFIXES = (".jsonl", ".jsonl.gz")

Dialect = Literal["aeroscene", "front3d", "neutral", "thor"]

DIALECTS: Mapping[Dialect, tuple[frozenset[str], str]] = {
    "aeroscene": (frozenset({"outdoor_scene"}), "the AeroScene authors' JSON"),
    "front3d": (frozenset({"furniture", "scene"}), "3D-FRONT's JSON"),
    "thor": (KEYS, "a house of ProcTHOR or Holodeck"),
    "neutral": (frozenset({"floor", "objects"}), "one line of the neutral layouts"),
}
"""Keys by which each form of JSON object is recognised, and its description."""


def read_layouts(
    path: str | Path, skip_invalid: bool = False, faults: list[str] | None = None
) -> Iterator[NeutralLayout]:
    """Read all layouts of a file: JSON lines, or one JSON of a form that `DIALECTS` lists.

    Args:
        path: File, plain or gzip.
        skip_invalid: Leave out objects and scenes that break a rule, instead of raising.
        faults: Receives one line for every scene left out.

    Raises:
        LayoutError: If the file breaks a rule; it names file, scene, object and field.
    """
    path = Path(path)
    if path.name.endswith(LINE_SUFFIXES):
        yield from read_neutral(path, skip_invalid, faults)
        return
    try:
        layout = _read_one(path, skip_invalid=skip_invalid)
    except LayoutError as error:
        if not skip_invalid:
            raise
        if faults is not None:
            faults.append(str(error))
        return
    yield layout


def _read_one(path: Path, *, skip_invalid: bool) -> NeutralLayout:
    where = source_name(path)
    data = read_bytes(path)
    # Houses of 3D-FRONT are tens of megabytes of meshes, of which few are needed.
    value = house_value(data, where)
    value = parse_json(data, where) if value is None else value
    # Tens of megabytes that are no longer needed.
    del data
    try:
        match dialect_of(value):
            case "aeroscene":
                return aeroscene_layout(value, skip_invalid=skip_invalid)
            case "front3d":
                info = read_model_info(path.parent)
                return front3d_layout(value, skip_invalid=skip_invalid, model_info=info)
            case "thor":
                sizes = read_asset_sizes(path.parent)
                name = path.name.partition(".json")[0]
                return thor_layout(value, name, skip_invalid=skip_invalid, asset_sizes=sizes)
            case "neutral":
                return neutral_layout(value, skip_invalid=skip_invalid)
    except LayoutError as error:
        raise error.within(where) from None
    except RecursionError:
        raise LayoutError(f"{where}: JSON is nested too deeply; valid: a scene") from None


def dialect_of(value: Any) -> Dialect:
    """Return the form of a JSON value.

    Raises:
        LayoutError: If it has none of the known forms; the message lists these.
    """
    keys = value.keys() if isinstance(value, dict) else set()
    for dialect, (needed, _) in DIALECTS.items():
        if needed <= keys:
            return dialect
    forms = "; ".join(f"{name} ({', '.join(sorted(keys))})" for keys, name in DIALECTS.values())
    found = ", ".join(map(str, list(keys)[:6])) if keys else "none"
    raise LayoutError(f"JSON of an unknown form (its keys: {found}); valid: {forms}")


def pick_layout(
    path: str | Path, scene_id: str | None = None, skip_invalid: bool = False
) -> NeutralLayout:
    """Read one layout of a file; faults of its other lines do not matter.

    Args:
        path: File.
        scene_id: Id of the layout, the part of it after the last slash, or its number in the file
            from 0. None takes the first one.
        skip_invalid: Leave out objects that break a rule, instead of raising.

    Raises:
        LayoutError: If there is none by that name, or the file breaks a rule.
    """
    path = Path(path)
    # An id may look like a number, so an equal id counts before a position.
    number = int(scene_id) if scene_id and re.fullmatch("[0-9]{1,9}", scene_id) else None
    numbered: NeutralLayout | LayoutError | None = None
    fault: LayoutError | None = None
    first, count = "", 0
    # A file may have thousands of scenes; only those that the answer needs are kept.
    for count, entry in enumerate(_each(path, skip_invalid=skip_invalid), 1):
        if scene_id is None or (isinstance(entry, NeutralLayout) and _is_called(entry, scene_id)):
            return _unless_fault(entry)
        if count - 1 == number:
            numbered = entry
        if isinstance(entry, NeutralLayout):
            first = first or entry.scene_id
        else:
            fault = fault or entry
    if numbered is not None:
        return _unless_fault(numbered)
    if fault is not None:
        # The scene that cannot be read may be the one that was asked for.
        raise fault
    where = source_name(path)
    if not first:
        raise LayoutError(f"{where} has no scene; valid: at least one")
    raise LayoutError(
        f"{where} has no scene {scene_id!r}; valid: a number from 0 to {count - 1} or an id "
        f"such as {first!r}"
    )


def _each(path: Path, *, skip_invalid: bool) -> Iterator[NeutralLayout | LayoutError]:
    if path.name.endswith(LINE_SUFFIXES):
        yield from read_each(path, skip_invalid=skip_invalid)
    else:
        yield _read_one(path, skip_invalid=skip_invalid)


def _is_called(layout: NeutralLayout, scene_id: str) -> bool:
    return scene_id in {layout.scene_id, layout.scene_id.rpartition("/")[2]}


def _unless_fault(entry: NeutralLayout | LayoutError) -> NeutralLayout:
    if isinstance(entry, LayoutError):
        raise entry
    return entry


def read_layout(
    path: str | Path, scene_id: str | None = None, skip_invalid: bool = False
) -> tuple[Scene, MappingReport]:
    """Open one layout of a file as a scene to fly in, with a report on its objects.

    Arguments and errors are those of `pick_layout`. A LayoutError is also raised if nothing of the
    layout can be used.
    """
    from aeroscene.layouts.flyable import make_flyable

    layout = pick_layout(path, scene_id, skip_invalid)
    try:
        return make_flyable(layout)
    except LayoutError as error:
        raise error.within(source_name(Path(path))) from None
