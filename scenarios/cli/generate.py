"""`aeroscene generate`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from aeroscene.corpus.districts.request import HOUSES, STOREYS
from aeroscene.corpus.districts.request import OBJECTS as DISTRICT_OBJECTS
from aeroscene.learning import require_torch
from aeroscene.learning.wishes import CLUTTER, DENSITY, OBJECTS, PASSAGE_M
from aeroscene.ranges import THREADS, Range
from aeroscene.scene import Scene, SceneDomain, SceneError
from scenarios.baselines.named import NamedPilot, PilotError, pilot_of
from scenarios.cli.command_line import EXIT_DONE, EXIT_NEGATIVE, default_hint, fail
from scenarios.cli.generate_district import district_requests, run_districts
from scenarios.cli.generate_prompt import print_understood, prompt_wishes, prompted
from scenarios.cli.generate_words import print_generated
from scenarios.cli.outputs import OutFile, OutFolder
from scenarios.cli.progress import progress_bar
from scenarios.generation.asked import (
    GenerateError,
    asked_areas,
    asked_region,
    outline_sides_m,
)
from scenarios.generation.prompts.parsing.reading import plain
from scenarios.generation.prompts.wishes import Wishes
from scenarios.generation.worst import ORDER, Flight, Tries, worst_first

if TYPE_CHECKING:
    from aeroscene.learning.generation import Generator, Request
    from scenarios.generation.draws import Tally

_PROG = "aeroscene generate"
_MOST_SCENES = 100_000
_MOST_STEPS = 1000


@dataclass(frozen=True, kw_only=True)
class GenerateCfg:
    """Make scenes with the trained model: the same seed gives the same scene on the same device.

    Each becomes OUT/aeroscene-SEED.json. A draw that cannot be flown is drawn again. Exit status 1
    if a seed gave no scene.
    """

    seed: Annotated[int, Range(0, 2**63 - 1 - _MOST_SCENES)] = 42
    """Seed of the first scene; the others have the seeds after it."""
    count: Annotated[int, Range(1, _MOST_SCENES)] = 1
    """Number of scenes."""
    domain: Literal["any", "outdoor", "indoor", "mixed"] = "any"
    """Domain of the scenes; any draws one for each."""
    theme: Annotated[str | None, default_hint("drawn")] = None
    """What the places are. Outdoor: car_park, hillside, industrial_yard, park, residential_street,
    urban_block, waterfront. Indoor: apartments, fair, office, school, sports, station, supermarket,
    warehouse. Mixed: hillside, industrial_yard, residential_street, urban_block, waterfront. With
    --domain any, one of the domains that have the theme is drawn. A checkpoint of your own knows
    the themes of its corpus; the paper's knows none."""
    prompt: Annotated[str, default_hint("none")] = ""
    """Wishes in English, such as "a crowded harbour street with two cafes and no cars". What was
    understood is printed first. A seed is drawn until it meets all wishes, 8 times at most, and the
    best draw is kept. Options that are given beside it win."""
    prompt_endpoint: Annotated[str, default_hint("none")] = ""
    """Address of a server that speaks OpenAI's chat/completions, such as http://127.0.0.1:8080/v1,
    whose model reads the prompt. Without it nothing is sent anywhere. The key is that of the
    environment variable OPENAI_API_KEY, if it is set."""
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
    all are asked for. With --redo on the number that goes."""
    clutter: Annotated[float | None, CLUTTER, default_hint("1")] = None
    """Factor on the loose things (crates, barrels, pallets, bins, boxes) on ground and floors."""
    min_passage: Annotated[float | None, PASSAGE_M, default_hint("none")] = None
    """Least clear width of doors and corridors: doors are widened, and a scene that still has a
    narrower passage is drawn again."""
    difficulty: Literal["any", "easy", "medium", "hard"] = "any"
    """Class of the planner's ways to landing areas, by thirds of the shipped scenes; drawn until a
    scene is of it, 24 times at most."""
    worst_for: Annotated[str, default_hint("none")] = ""
    """Keep the scenes in which this pilot does worst: demo, mueller, potential, straight, or
    MODULE:CLASS of your own. Scenes and flights lie in OUT/tried; what is there is not done
    again."""
    of: Annotated[int | None, Range(1, _MOST_SCENES), default_hint("four times count")] = None
    """Number of scenes, from seed on, of which --worst-for keeps --count."""
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
    """Scene that stays exactly as it is but for the fine objects with their middles in --region,
    which go with all that they bear; about as many are drawn anew there. Coarse objects (site,
    buildings, storeys, rooms, walls, roads) and the pad of the start stay."""
    region: Annotated[str, default_hint("none")] = ""
    """Region of --redo in metres, ENU, as X0,Y0,X1,Y1 or X0,Y0,X1,Y1,Z0,Z1."""
    out: Annotated[Path, OutFolder()] = Path("scenes")
    """Folder to write into; made where it is missing."""
    checkpoint: Annotated[Path | None, default_hint("the one that ships")] = None
    """File that `aeroscene train` has written."""
    preset: Literal["default", "paper", "progressive"] = "default"
    """Checkpoint that ships with the package: ours, the paper's, or the paper's in two passes."""
    steps: Annotated[int | None, Range(1, _MOST_STEPS), default_hint("the preset's")] = None
    """Denoising steps."""
    batch: Annotated[int, Range(1, _MOST_SCENES)] = 1
    """Scenes that are denoised at once: faster on a GPU. Another number gives other scenes."""
    device: str = "auto"
    """auto takes a GPU where there is one; or cpu, cuda, cuda:1, mps."""
    threads: Annotated[int | None, THREADS, default_hint("1, with --batch all cores")] = None
    """Number of CPU threads. For one scene at a time a second one brings little."""
    strict: bool = False
    """Keep only scenes that are as asked for: objects and density within a fifth, each side of the
    outline within a tenth. Others are drawn again; a seed that gives none is named, exit status
    1."""
    progress: Annotated[Path | None, OutFile((".png",)), default_hint("none")] = None
    """PNG file for pictures of how the first scene came about."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: scenes (files), seconds_per_scene, device, failed, stages; with wishes
    also wishes (asked, got and met by file), missed (files) and measured; with --prompt
    understood; with --worst-for order and worst. docs/model.md says more."""


def run(cfg: GenerateCfg) -> int:
    """Generate; exit status 2 with one line where input, device or memory do not allow it."""
    try:
        return _run(cfg)
    except (SceneError, PilotError) as error:
        fail(_PROG, str(error))


def _run(cfg: GenerateCfg) -> int:
    _check(cfg)
    if (districts := district_requests(cfg)) is not None:
        return run_districts(cfg, districts)
    wishes = prompt_wishes(cfg, _own_themes(cfg))
    requests = _requests(prompted(cfg, wishes)[0])
    require_torch()
    if cfg.checkpoint is not None:
        from aeroscene.learning.training.presets import read_sections

        read_sections(cfg.checkpoint)
    # Imported here because PyTorch takes seconds that no other command should spend.
    from aeroscene.learning.generation import Generator

    pilot = pilot_of(cfg.worst_for, "worst-for") if cfg.worst_for else None
    generator = Generator.load(
        cfg.checkpoint, preset=cfg.preset, device=cfg.device, n_steps=cfg.steps
    )
    _set_threads(cfg)
    cfg, understanding = prompted(cfg, wishes, generator.themes)
    requests = _requests(cfg)
    generator.check(requests[0])
    more: dict[str, Any] = {}
    if understanding is not None:
        more["understood"] = understanding.to_plain()
        if not cfg.json:
            print_understood(understanding)
    if pilot is not None:
        return _run_worst(cfg, generator, requests, pilot, wishes, more)
    cfg.out.mkdir(parents=True, exist_ok=True)
    tally = _tally(cfg, cfg.out, wishes)
    _draw(cfg, generator, requests, tally)
    print_generated(cfg.out, generator.device, tally, more, as_json=cfg.json)
    return EXIT_NEGATIVE if tally.failed else EXIT_DONE


def _own_themes(cfg: GenerateCfg) -> frozenset[str]:
    """Themes of a checkpoint of the user's own, by whose names a prompt may call them."""
    if not cfg.prompt or cfg.checkpoint is None:
        return frozenset()
    require_torch()
    from aeroscene.learning.training.checkpoint import read_checkpoint

    themes = getattr(read_checkpoint(cfg.checkpoint).known, "themes", {})
    return frozenset(theme for group in themes.values() for theme in group)


def _tally(cfg: GenerateCfg, folder: Path, wishes: Wishes) -> Tally:
    from scenarios.generation.draws import Tally

    prompt = plain(cfg.prompt) if cfg.prompt else ""
    return Tally(folder, is_strict=cfg.strict, prompt=prompt, demands=wishes.demands)


def _draw(
    cfg: GenerateCfg, generator: Generator, requests: Sequence[Request], tally: Tally
) -> None:
    from aeroscene.learning.generation.generator import MOST_ATTEMPTS
    from scenarios.generation.draws import AnyScene, OfDifficulty, draw_all, draw_with_pictures

    judge = AnyScene(MOST_ATTEMPTS) if cfg.difficulty == "any" else OfDifficulty(cfg.difficulty)
    with progress_bar("generating", len(requests)) as advance:
        if cfg.progress is not None:
            draw_with_pictures(generator, requests[0], judge, tally, cfg.progress)
            advance()
            requests = requests[1:]
        draw_all(generator, requests, judge, tally, batch_size=cfg.batch, advance=advance)


def _run_worst(
    cfg: GenerateCfg,
    generator: Generator,
    requests: Sequence[Request],
    pilot: NamedPilot,
    wishes: Wishes,
    understood: Mapping[str, Any],
) -> int:
    """Make the scenes and fly them, as far as that is not done, and keep the worst."""
    left_open = {"seed", "count", "of", "out", "threads", "progress", "json"}
    left_open |= {"prompt", "prompt_endpoint", "prompt_model"}
    asked = {name: str(v) for name, v in asdict(cfg).items() if name not in left_open}
    asked |= {each.title: each.number for each in wishes.demands}
    tries = Tries(cfg.out / "tried", asked)
    tally = _tally(cfg, tries.folder, wishes)
    missing = [each for each in requests if not tries.scene_path(each.seed).exists()]
    if missing:
        _draw(cfg, generator, missing, tally)
    seeds = [each.seed for each in requests if tries.scene_path(each.seed).exists()]
    flights: list[Flight] = []
    with progress_bar("flying", len(seeds), "flights") as advance:
        for seed in seeds:
            flights.append(tries.flight(seed, pilot))
            advance()
    worst = worst_first(flights)
    files = [
        str(tries.keep(flight, cfg.worst_for, len(flights), cfg.out))
        for flight in worst[: cfg.count]
    ]
    kept = [{"scene": str(path), **asdict(f)} for path, f in zip(files, worst, strict=False)]
    more = {**understood, "scenes": files, "order": ORDER, "worst": kept}
    print_generated(cfg.out, generator.device, tally, more, as_json=cfg.json)
    return EXIT_NEGATIVE if tally.failed else EXIT_DONE


def _set_threads(cfg: GenerateCfg) -> None:
    import torch

    n_threads = 1 if cfg.threads is None and cfg.batch == 1 else cfg.threads
    if n_threads is not None:
        torch.set_num_threads(n_threads)


def _check(cfg: GenerateCfg) -> None:
    if cfg.of is not None and cfg.of < cfg.count:
        raise GenerateError(f"of is {cfg.of} beside count {cfg.count}; valid: {cfg.count} or more")
    if cfg.of is not None and not cfg.worst_for:
        raise GenerateError(f"of is {cfg.of} without --worst-for; valid: --worst-for demo")
    if bool(cfg.redo) != bool(cfg.region):
        given, missing = ("redo", "region") if cfg.redo else ("region", "redo")
        raise GenerateError(
            f"{given} is {getattr(cfg, given)!r} without --{missing}; valid: the two together, "
            "such as --redo 42 --region -10,0,5,12.5"
        )
    if cfg.worst_for and cfg.progress is not None:
        raise GenerateError(
            f"progress is {str(cfg.progress)!r} beside --worst-for; valid: one of the two"
        )


def _requests(cfg: GenerateCfg) -> list[Request]:
    from aeroscene.learning.generation import Redo, Request

    domain: SceneDomain | None = None if cfg.domain == "any" else cfg.domain
    complete: Scene | None = None
    redo: Redo | None = None
    if cfg.plan:
        from aeroscene.maps.floor_plan import open_plan

        if cfg.complete or cfg.redo:
            fail(_PROG, f"plan {cfg.plan!r} stands beside --complete or --redo; valid: one of them")
        complete = open_plan(cfg.plan)
    if cfg.complete or cfg.redo:
        from aeroscene.sources import load_scene

        complete = load_scene(cfg.complete) if cfg.complete else None
        if cfg.redo:
            redo = Redo(scene=load_scene(cfg.redo), region=asked_region(cfg.region))
    outline_m = outline_sides_m(cfg.outline) if cfg.outline else None
    count = cfg.count
    if cfg.worst_for:
        count = min(4 * count, _MOST_SCENES) if cfg.of is None else cfg.of
    return [
        Request(
            seed=seed,
            domain=domain,
            theme=cfg.theme,
            n_objects=cfg.objects,
            n_areas=asked_areas(cfg.areas) if cfg.areas else None,
            outline_m=outline_m,
            complete=complete,
            redo=redo,
            density=cfg.density,
            clutter=cfg.clutter,
            min_passage_m=cfg.min_passage,
        )
        for seed in range(cfg.seed, cfg.seed + count)
    ]
