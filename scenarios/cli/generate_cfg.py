"""Options of `aeroscene generate`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from aeroscene.corpus.districts.request import HOUSES, STOREYS
from aeroscene.corpus.districts.request import OBJECTS as DISTRICT_OBJECTS
from aeroscene.learning.wishes import CLUTTER, DENSITY, OBJECTS, PASSAGE_M
from aeroscene.ranges import THREADS, Range
from scenarios.cli.command_line import default_hint
from scenarios.cli.outputs import OutFile, OutFolder

MOST_SCENES = 100_000
"""Scenes of one command."""
_MOST_STEPS = 1000


@dataclass(frozen=True, kw_only=True)
class GenerateCfg:
    """Make scenes with the trained model: the same seed gives the same scene on the same device.

    Each becomes OUT/aeroscene-SEED.json. A draw that cannot be flown is drawn again. Exit status 1
    if a seed gave no scene.
    """

    # The seed of the last scene, seed + count - 1, must fit into a signed 64-bit integer.
    seed: Annotated[int, Range(0, 2**63 - 1 - MOST_SCENES)] = 42
    """Seed of the first scene; the others have the seeds after it."""
    count: Annotated[int, Range(1, MOST_SCENES)] = 1
    """Number of scenes."""
    domain: Literal["any", "outdoor", "indoor", "mixed"] = "any"
    """Domain of the scenes; any draws one for each."""
    theme: Annotated[str | None, default_hint("drawn")] = None
    """Kind of place. Outdoor: hillside, industrial_yard, old_town, park, residential_street,
    retail_park, urban_block, village, waterfront. Indoor: apartments, clinic, fair, hotel, library,
    office, restaurant, school, sports, station, supermarket, warehouse. Mixed: campus, hillside,
    industrial_yard, residential_street, urban_block, waterfront. With --domain any, one of the
    domains that have the theme is drawn. A checkpoint of your own knows the themes of its corpus;
    the paper's knows none."""
    prompt: Annotated[str, default_hint("none")] = ""
    """Wishes in English, such as "a crowded harbour street with two cafes and no cars". The wishes
    that were understood are printed first. A seed is drawn until it meets all wishes, 8 times at
    most, and the best draw is kept. Options that you also pass override the prompt."""
    prompt_endpoint: Annotated[str, default_hint("none")] = ""
    """Address of a server that speaks OpenAI's chat/completions, such as http://127.0.0.1:8080/v1,
    whose model reads the prompt. Without it nothing is sent anywhere. The environment variable
    OPENAI_API_KEY is the key, if it is set."""
    prompt_model: Annotated[str, default_hint("default")] = "default"
    """Name of the model at --prompt-endpoint."""
    objects: Annotated[
        int | None, Range(OBJECTS.low, DISTRICT_OBJECTS.high), default_hint("drawn, 149 on average")
    ] = None
    """Approximate number of objects in each scene; above 250 it is a district."""
    houses: Annotated[int | None, HOUSES, default_hint("drawn")] = None
    """Number of buildings of a district, within a tenth."""
    storeys: Annotated[int | None, STOREYS, default_hint("no tower")] = None
    """Storeys of a tower in a district: they repeat one floor plan, and each is furnished anew."""
    areas: Annotated[str, default_hint("drawn")] = ""
    """Greatest number of landing areas in each scene: 1 to 200 in all, or 0 to 200 of a class, such
    as small=20,medium=5,large=2."""
    density: Annotated[float | None, DENSITY, default_hint("1")] = None
    """Factor on the number of fine objects that a scene of its domain has; at most 250 objects in
    all are asked for. With --redo, factor on the number of objects that are removed."""
    clutter: Annotated[float | None, CLUTTER, default_hint("1")] = None
    """Factor on the loose things (crates, pallets, bins, boxes) on ground and floors."""
    min_passage: Annotated[float | None, PASSAGE_M, default_hint("none")] = None
    """Least clear width of doors and corridors: doors are widened, and a scene that still has a
    narrower passage is drawn again."""
    difficulty: Literal["any", "easy", "medium", "hard"] = "any"
    """Difficulty of the planner's paths to landing areas, by thirds of the shipped scenes. A scene
    is drawn until it has this difficulty, 24 times at most."""
    worst_for: Annotated[str, default_hint("none")] = ""
    """Keep the scenes in which this pilot does worst: demo, mueller, potential, straight, or
    MODULE:CLASS of your own. Scenes and flights lie in OUT/tried; those in it are not made
    again."""
    of: Annotated[int | None, Range(1, MOST_SCENES), default_hint("four times count")] = None
    """Number of scenes, from seed on, from which --worst-for keeps --count."""
    outline: Annotated[str, default_hint("drawn")] = ""
    """The site's sides as EAST,NORTH, 15 to 150 m each, or a JSON file with a list of corners
    [[x, y], ...], whose bounding rectangle is taken. With a side above 150 m it is a district of 60
    to 400 m a side: blocks along streets that meet, composed by the grammar of the corpus without
    the model."""
    complete: Annotated[str, default_hint("none")] = ""
    """Scene whose coarse objects stay; fine ones are made for them: a number, gen:SEED, corpus:N or
    a file."""
    plan: Annotated[str, default_hint("none")] = ""
    """Floor plan to furnish: rooms with a use and doors as GeoJSON, or a file of layouts with
    rooms, whose furniture is left out."""
    redo: Annotated[str, default_hint("none")] = ""
    """Scene of which one region is drawn anew. Fine objects with their middles in --region are
    removed with everything that they carry, and about as many are drawn there. All else stays
    exactly as it is: coarse objects (site, buildings, storeys, rooms, walls, roads) and the pad of
    the start, too."""
    region: Annotated[str, default_hint("none")] = ""
    """Region of --redo in metres, ENU, as X0,Y0,X1,Y1 or X0,Y0,X1,Y1,Z0,Z1."""
    relief: bool = True
    """Give outdoor sites gentle land in their green and around them; otherwise they are flat.
    --complete and --redo keep the ground of their scene."""
    out: Annotated[Path, OutFolder()] = Path("scenes")
    """Folder to write into; it is made if it is missing."""
    checkpoint: Annotated[Path | None, default_hint("the one that ships")] = None
    """Checkpoint that `aeroscene train` has written."""
    preset: Literal["default", "paper", "progressive"] = "default"
    """Checkpoint that ships with the package: ours, the paper's, or the paper's in two passes."""
    steps: Annotated[int | None, Range(1, _MOST_STEPS), default_hint("the preset's")] = None
    """Denoising steps."""
    batch: Annotated[int, Range(1, MOST_SCENES)] = 1
    """Scenes that are denoised at once, which is faster on a GPU. Another number gives other
    scenes."""
    device: str = "auto"
    """auto takes a GPU if there is one; or cpu, cuda, cuda:1, mps."""
    threads: Annotated[int | None, THREADS, default_hint("1, with --batch all cores")] = None
    """Number of CPU threads. For one scene at a time a second one brings little."""
    strict: bool = False
    """Keep only scenes that are as asked for: objects and density within a fifth, each side of the
    outline within a tenth. Others are drawn again. A seed that gives none is named, and the exit
    status is 1."""
    progress: Annotated[Path | None, OutFile((".png",)), default_hint("none")] = None
    """PNG file for pictures of the stages of the first scene."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: scenes (files), seconds_per_scene, device, failed, stages; with wishes
    also wishes (asked, got and met by file), missed (files) and measured; with --prompt
    understood; with --worst-for order and worst. docs/model.md says more."""
