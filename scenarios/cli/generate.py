"""`aeroscene generate`: scenes from the trained model, or districts from the grammar.

The order of the steps in `_run` matters. Everything that can be refused without PyTorch is refused
first, because loading PyTorch and the model takes seconds. The prompt is joined with the options
twice: before loading, to check the request, and after it, when the model's own themes are known.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aeroscene.learning import require_torch
from aeroscene.scene import Scene, SceneDomain, SceneError
from scenarios.baselines.named import NamedPilot, PilotError, pilot_of
from scenarios.cli.command_line import EXIT_DONE, EXIT_NEGATIVE, fail
from scenarios.cli.generate_cfg import MOST_SCENES, GenerateCfg
from scenarios.cli.generate_district import district_requests, run_districts
from scenarios.cli.generate_prompt import print_understood, prompt_wishes, prompted
from scenarios.cli.generate_words import print_generated
from scenarios.cli.progress import progress_bar
from scenarios.generation.prompts.parsing.prompt_reader import plain
from scenarios.generation.prompts.wishes import Wishes
from scenarios.generation.text_options import (
    GenerateError,
    asked_areas,
    asked_region,
    outline_sides_m,
)
from scenarios.generation.worst_scenes import ORDER, Flight, Tries, worst_first

if TYPE_CHECKING:
    from aeroscene.learning.generation import Generator, Request
    from scenarios.generation.draws import Tally

_PROG = "aeroscene generate"


def run(cfg: GenerateCfg) -> int:
    """Make the scenes that the options ask for, and print what was made.

    Returns:
        0, or 1 if a seed gave no scene. Input, device or memory that do not allow it end the
        process with status 2 and one line.
    """
    try:
        return _run(cfg)
    except (SceneError, PilotError) as error:
        fail(_PROG, str(error))


def _run(cfg: GenerateCfg) -> int:
    _check(cfg)
    if (districts := district_requests(cfg)) is not None:
        return run_districts(cfg, districts)
    wishes = prompt_wishes(cfg, _own_themes(cfg))
    # Checks the request before the model is loaded; the result is made again below.
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
    """Return the themes of the user's own checkpoint, so that a prompt may name them."""
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
            # Only the first scene has pictures, and it is drawn alone, outside of any batch.
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
    """Make the scenes and fly them, unless the folder has them already, and keep the worst."""
    # Options that leave a seed's scene as it is, so that work of another call can be taken over.
    # The prompt counts by the wishes in it, which are added below.
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

    # For one scene at a time, a second thread brings little.
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
        count = min(4 * count, MOST_SCENES) if cfg.of is None else cfg.of
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
            has_relief=cfg.relief,
        )
        for seed in range(cfg.seed, cfg.seed + count)
    ]
