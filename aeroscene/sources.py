"""Sources of scenes: shipped, curated, generated, the field, a file, a layout, a map.

Every command opens scenes by the names that are defined here, and heavy packages are loaded only
for the kind of scene that was asked for.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Literal

from aeroscene.corpus.corpus import CORPUS_SIZE
from aeroscene.corpus.field import FIELD_NAME, HILLS_NAME, field_scene
from aeroscene.corpus.provenance import curation_digest
from aeroscene.files import cache_folder
from aeroscene.scene import InteractionArea, Scene, SceneError
from aeroscene.scene.io import FORMAT, read_scene, write_scene

_log = logging.getLogger(__name__)

NUMBERS_NAME: Literal["corpus", "shipped"] = "shipped"
"""Source of a bare number: the corpus, or the scenes that come with the package."""

_DISTRICT_M = (320.0, 320.0)
"""Sides of a district that is opened by its seed."""

# ASCII digits only: int() would also take signs, blanks and other scripts.
_NUMBER = re.compile(r"(?:(?P<source>corpus|gen|district):)?(?P<number>[0-9]{1,9})")
# The names that these scenes have themselves, as a run prints them.
_SCENE_ID = re.compile(r"(?P<source>aeroscene|corpus|district)-(?P<number>[0-9]{4,9})")
_FILE = re.compile(r"(?P<path>.+?\.jsonl?(?:\.gz)?)(?:#(?P<scene_id>.*))?", re.DOTALL)
_MAP = re.compile(
    r"(?P<path>.+?\.(?:osm(?:\.gz|\.xml|\.pbf)?|pbf|geojson(?:\.gz)?))(?:#(?P<bounds>.*))?",
    re.DOTALL,
)
_GEOJSON_KEY = b'"FeatureCollection"'
# Keys by which a layout is known even where its JSON is cut short.
_LAYOUT_KEYS = (
    (b'"outdoor_scene"',),
    (b'"furniture"', b'"scene"'),
    (b'"rooms"', b'"walls"', b'"objects"'),
    (b'"floor"', b'"objects"'),
)


class UnknownSceneError(SceneError):
    """Raised if no scene has that name."""


def load_scene(spec: str, *, skip_invalid: bool = False) -> Scene:
    """Open the scene that a user names.

    Args:
        spec: Name of the scene, one of: a number from 0 to 1015 for a scene of the AeroScene
            dataset, or its name, such as `aeroscene-0042`; `corpus:N`, or `corpus-0042`, for one of
            the training corpus, which has no last; `gen:SEED` for one that the model makes anew;
            `district:SEED` for one of 320 by 320 m that is composed of blocks; `field` for an open,
            flat field; `hills` for a hillside with houses and trees; the path of a `.json` or
            `.json.gz` file that holds a scene of ours, the AeroScene authors' JSON, or a house of
            3D-FRONT, ProcTHOR or Holodeck; `FILE.jsonl#ID`, also gzip, for a scene of a file of
            neutral layouts or such houses, where ID is its scene_id, the part after its last slash,
            or its number in the file from 0; `FILE.osm#W,S,E,N`, also `.osm.gz`, `.osm.pbf` and
            `.geojson`, for a place on a map, where W,S,E,N are degrees and may be left out for a
            small map.
        skip_invalid: Leave out objects of a layout that break a rule, instead of raising.

    Raises:
        SceneError: If there is no such scene or the file is not valid; one line.
    """
    if spec == FIELD_NAME:
        return field_scene()
    if spec == HILLS_NAME:
        from aeroscene.corpus.hills import hills_scene

        return hills_scene()
    file = _FILE.fullmatch(spec)
    if file:
        return _open_file(file["path"], file["scene_id"], skip_invalid=skip_invalid)
    if place := _MAP.fullmatch(spec):
        return _open_map(place["path"], place["bounds"])
    named = _NUMBER.fullmatch(canonical_name(spec))
    if named is None or (named["source"] is None and int(named["number"]) >= CORPUS_SIZE):
        raise UnknownSceneError(
            f"scene {spec!r} is unknown; valid: a number from 0 to {CORPUS_SIZE - 1}, corpus:N, "
            "gen:SEED, district:SEED, field, hills, FILE.json, FILE.jsonl#ID or FILE.osm#W,S,E,N, "
            "also with .gz"
        )
    return _open_number(named["source"] or NUMBERS_NAME, int(named["number"]))


def canonical_name(spec: str) -> str:
    """The shortest name of the same scene: `42` for `aeroscene-0042`, `corpus:7` for `corpus-0007`.

    Draws depend on a scene's name, so that a scene needs one name wherever trials are named.
    """
    own = _SCENE_ID.fullmatch(spec)
    if own is None:
        return spec
    number = str(int(own["number"]))
    return number if own["source"] == "aeroscene" else f"{own['source']}:{number}"


def _open_number(source: str, number: int) -> Scene:
    if source == "corpus":
        return _kept(f"corpus-{number:04d}", partial(_curated, number))
    if source == "district":
        return _kept(f"district-{number:04d}", partial(_composed, number))
    if source == "shipped":
        from aeroscene.corpus.shipped import read_shipped

        return read_shipped(number)
    from aeroscene.learning import require_torch

    require_torch()
    from aeroscene.learning.generation import generate_scene

    return generate_scene(number)


def is_map(spec: str) -> bool:
    """Return true if a name is that of a map file, with or without bounds."""
    return _MAP.fullmatch(spec) is not None


def _open_map(path: str, bounds: str | None) -> Scene:
    from aeroscene.maps import open_map

    scene, report = open_map(path, bounds)
    for line in report.lines:
        _log.warning("scene %r: %s", scene.scene_id, line)
    return scene


def _open_file(path: str, scene_id: str | None, *, skip_invalid: bool) -> Scene:
    if _is_geojson(path):
        return _open_map(path, scene_id)
    if _is_layout(path):
        return _open_layout(path, scene_id, skip_invalid=skip_invalid)
    scene = read_scene(path, _derived_areas)
    if scene_id not in {None, "0", scene.scene_id}:
        raise UnknownSceneError(
            f"scene file {path!r} has no scene {scene_id!r}; valid: {scene.scene_id!r}"
        )
    return scene


def _derived_areas(scene: Scene) -> tuple[InteractionArea, ...]:
    """Areas of a scene whose file lists none."""
    from aeroscene.areas.landing import derive_interaction_areas

    return derive_interaction_areas(scene)


def _is_geojson(path: str) -> bool:
    """Return true if a JSON file is a map, by its first bytes."""
    # Reading a pipe would block, and take these bytes from the next reader.
    if ".jsonl" in path[-9:] or not Path(path).is_file():
        return False
    try:
        with Path(path).open("rb") as file:
            return _GEOJSON_KEY in file.read(512)
    except OSError:
        return False


def _is_layout(path: str) -> bool:
    """Return true if a file holds layouts, by its name or its content; a damaged scene does not."""
    from aeroscene.layouts.text_file import read_bytes

    if ".jsonl" in path[-9:]:
        return True
    try:
        data = read_bytes(Path(path))
    except SceneError:
        if path.endswith(".gz"):
            raise
        return False  # scenes have an error of their own for that
    if f'"{FORMAT}"'.encode() in data:
        return False
    return any(all(key in data for key in keys) for keys in _LAYOUT_KEYS)


def _open_layout(path: str, scene_id: str | None, *, skip_invalid: bool) -> Scene:
    from aeroscene.layouts import read_layout

    scene, report = read_layout(path, scene_id, skip_invalid)
    for reason, count in report.dropped.items():
        _log.warning("scene %r: %d objects left out: %s", scene.scene_id, count, reason)
    for line in (*report.unmapped_lines, *report.invalid):
        _log.warning("%s", line)
    return scene


def _kept(scene_id: str, make: Callable[[], Scene]) -> Scene:
    """A scene that takes a second or more to make, from the cache if exactly this code made it."""
    folder = cache_folder("scenes")
    # Scenes of exactly this code: another version of it has another folder.
    path = folder and folder / curation_digest() / f"{scene_id}.json"
    if path is not None:
        with suppress(SceneError, OSError):
            return read_scene(path)
    scene = make()
    if path is not None:
        with suppress(OSError):  # A cache that cannot be written costs time, not the scene.
            path.parent.mkdir(parents=True, exist_ok=True)
            write_scene(scene, path)
    return scene


def _curated(index: int) -> Scene:
    from aeroscene.corpus.curation import curate_scene

    return curate_scene(index)


def _composed(seed: int) -> Scene:
    from aeroscene.corpus.districts import DistrictRequest, compose_district

    request = DistrictRequest(seed=seed, outline_m=_DISTRICT_M)
    return compose_district(request, scene_id=f"district-{seed:04d}")
