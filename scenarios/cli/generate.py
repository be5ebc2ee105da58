"""`aeroscene generate`."""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from aeroscene.learning import require_torch
from aeroscene.scene import Scene, SceneDomain, SceneError
from aeroscene.scene.io import write_scene
from scenarios.cli.command_line import (
    EXIT_DONE,
    EXIT_NEGATIVE,
    default_hint,
    fail,
    print_json,
)
from scenarios.cli.progress import progress_bar

if TYPE_CHECKING:
    from aeroscene.learning.generation import Generated, Generator, Request

_PROG = "aeroscene generate"
_MOST_SCENES = 100_000
_MOST_STEPS = 1000
_MOST_SEED = 2**63 - 1


class GenerateError(SceneError):
    """A request that `aeroscene generate` cannot fulfil, in one line."""


@dataclass(frozen=True, kw_only=True)
class GenerateCfg:
    """Make scenes with the trained model: the same seed gives the same scene on the same device.

    Each becomes OUT/aeroscene-SEED.json. A draw that cannot be flown is drawn again. Exit status 1
    if a seed gave no scene.
    """

    seed: int = 42
    """Seed of the first scene; the others have the seeds after it."""
    count: int = 1
    """Number of scenes."""
    domain: Literal["any", "outdoor", "indoor", "mixed"] = "any"
    """Domain of the scenes; any draws one for each."""
    objects: Annotated[int | None, default_hint("drawn, 149 on average")] = None
    """Approximate number of objects in each scene."""
    areas: Annotated[int | None, default_hint("drawn")] = None
    """Greatest number of landing areas in each scene."""
    outline: Annotated[str, default_hint("drawn")] = ""
    """The site's sides in metres as EAST,NORTH, or a JSON file with a list of corners
    [[x, y], ...], whose bounding rectangle is taken."""
    complete: Annotated[str, default_hint("none")] = ""
    """Scene whose coarse objects stay; fine ones are made for them. A number or a file."""
    out: Path = Path("scenes")
    """Folder to write into; made where it is missing."""
    checkpoint: Annotated[Path | None, default_hint("the one that ships")] = None
    """File that `aeroscene train` has written."""
    preset: Literal["default", "paper"] = "default"
    """Checkpoint that ships with the package: ours or the paper's."""
    steps: Annotated[int | None, default_hint("the preset's")] = None
    """Denoising steps."""
    batch: int = 1
    """Scenes that are denoised at once: faster on a GPU. Another number gives other scenes."""
    device: str = "auto"
    """auto takes a GPU where there is one; or cpu, cuda, cuda:1, mps."""
    threads: Annotated[int | None, default_hint("1, with --batch all cores")] = None
    """Number of CPU threads. For one scene at a time a second one brings little."""
    progress: Annotated[Path | None, default_hint("none")] = None
    """PNG file for pictures of how the first scene came about."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: scenes (files), seconds_per_scene, device, failed, and for each of the
    stages guided and feasible collision_rate (the paper's, a share) and rejected."""


def run(cfg: GenerateCfg) -> int:
    """Generate; exit status 2 with one line where input, device or memory do not allow it."""
    try:
        return _run(cfg)
    except SceneError as error:
        fail(_PROG, str(error))
    except OSError as error:
        where = f"file {error.filename!r}: " if error.filename else ""
        fail(_PROG, f"{where}{(error.strerror or str(error)).lower()}")


@dataclass
class _Tally:
    """Results of the draws so far."""

    files: list[str] = field(default_factory=list)
    failed: dict[int, str] = field(default_factory=dict)
    """Reason why a seed gave no scene."""
    n_rejected: int = 0
    guided: list[float] = field(default_factory=list)
    """Collision rates of all draws."""
    feasible: list[float] = field(default_factory=list)
    """Collision rates of the finished scenes."""
    seconds: float = 0.0


def _run(cfg: GenerateCfg) -> int:
    _check(cfg)
    require_torch()
    # Imported here because PyTorch takes seconds that no other command should spend.
    from aeroscene.learning.generation import Generator  # noqa: PLC0415

    requests = _requests(cfg)
    generator = Generator.load(
        cfg.checkpoint, preset=cfg.preset, device=cfg.device, n_steps=cfg.steps
    )
    _set_threads(cfg)
    generator.check(requests[0])
    cfg.out.mkdir(parents=True, exist_ok=True)
    tally = _Tally()
    with progress_bar("generating", len(requests)) as advance:
        first = requests
        if cfg.progress is not None:
            _generate_with_pictures(cfg, generator, requests[0], tally)
            advance()
            first = requests[1:]
        _generate(cfg, generator, first, tally, advance)
    _report(cfg, generator, tally)
    return EXIT_NEGATIVE if tally.failed else EXIT_DONE


def _set_threads(cfg: GenerateCfg) -> None:
    import torch  # noqa: PLC0415

    if cfg.threads is not None:
        torch.set_num_threads(cfg.threads)
    elif cfg.batch == 1:
        torch.set_num_threads(1)


def _check(cfg: GenerateCfg) -> None:
    limits = (
        ("seed", cfg.seed, 0, _MOST_SEED - _MOST_SCENES),
        ("count", cfg.count, 1, _MOST_SCENES),
        ("steps", cfg.steps, 1, _MOST_STEPS),
        ("batch", cfg.batch, 1, _MOST_SCENES),
        ("threads", cfg.threads, 1, 1024),
    )
    for name, value, low, high in limits:
        if value is not None and not low <= value <= high:
            raise GenerateError(f"{name} is {value}, valid: {low} to {high}")
    if cfg.progress is not None and cfg.progress.suffix != ".png":
        raise GenerateError(f"progress {str(cfg.progress)!r} is no .png file, valid: NAME.png")


def _requests(cfg: GenerateCfg) -> list[Request]:
    from aeroscene.learning.generation import Request  # noqa: PLC0415 - PyTorch

    domain: SceneDomain | None = None if cfg.domain == "any" else cfg.domain
    complete: Scene | None = None
    if cfg.complete:
        from aeroscene.sources import open_scene  # noqa: PLC0415 - only where it is asked for

        complete = open_scene(cfg.complete)
    outline_m = outline_sides_m(cfg.outline) if cfg.outline else None
    return [
        Request(
            seed=seed,
            domain=domain,
            n_objects=cfg.objects,
            n_areas=cfg.areas,
            outline_m=outline_m,
            complete=complete,
        )
        for seed in range(cfg.seed, cfg.seed + cfg.count)
    ]


def outline_sides_m(text: str) -> tuple[float, float]:
    """Sides of the site that a user asks for.

    Args:
        text: `EAST,NORTH` in metres, or the path of a JSON file with corners.

    Raises:
        GenerateError: If the text is neither.
    """
    valid = "EAST,NORTH in metres such as 60,45, or a JSON file with [[x, y], ...]"
    parts = text.split(",")
    try:
        sides = [float(part) for part in parts]
    except ValueError:
        sides = _bounding_sides_m(Path(text), valid)
    if len(sides) != 2 or not all(math.isfinite(side) and side > 0 for side in sides):
        raise GenerateError(f"outline is {text!r}, valid: {valid}")
    return sides[0], sides[1]


def _bounding_sides_m(path: Path, valid: str) -> list[float]:
    try:
        corners = json.loads(path.read_text(encoding="utf-8"))
        columns = list(zip(*((float(x), float(y)) for x, y in corners), strict=True))
    except OSError as error:
        reason = (error.strerror or type(error).__name__).lower()
        raise GenerateError(
            f"outline {str(path)!r} cannot be read ({reason}), valid: {valid}"
        ) from None
    except (ValueError, TypeError) as error:
        raise GenerateError(
            f"outline {str(path)!r} is no list of corners ({error}), valid: {valid}"
        ) from None
    return [max(column) - min(column) for column in columns]


def _generate(
    cfg: GenerateCfg, generator: Generator, requests: Sequence[Request], tally: _Tally, advance: Any
) -> None:
    """Draw every request until it gives a scene or the attempts are used up."""
    from aeroscene.learning.generation.generator import MOST_ATTEMPTS  # noqa: PLC0415 - PyTorch

    pending = list(requests)
    for attempt in range(MOST_ATTEMPTS):
        drawn, pending = pending, []
        began_s = time.perf_counter()
        for found in generator.generate(drawn, batch_size=cfg.batch, attempt=attempt):
            tally.seconds += time.perf_counter() - began_s
            if not _keep(cfg, found, tally):
                pending.append(found.request)
            if found.scene is not None or attempt == MOST_ATTEMPTS - 1:
                advance()
            began_s = time.perf_counter()


def _generate_with_pictures(
    cfg: GenerateCfg, generator: Generator, request: Request, tally: _Tally
) -> None:
    from aeroscene.learning.generation.generator import MOST_ATTEMPTS  # noqa: PLC0415 - PyTorch
    from scenarios.pictures.generation.recorder import Recorder  # noqa: PLC0415 - the renderer

    assert cfg.progress is not None
    for attempt in range(MOST_ATTEMPTS):
        recorder = Recorder()
        began_s = time.perf_counter()
        found = next(generator.generate([request], attempt=attempt, on_step=recorder))
        tally.seconds += time.perf_counter() - began_s
        is_kept = _keep(cfg, found, tally)
        if is_kept or attempt == MOST_ATTEMPTS - 1:
            recorder.draw(found, cfg.progress)
            return


def _keep(cfg: GenerateCfg, found: Generated, tally: _Tally) -> bool:
    """Write the scene of a draw; return whether the draw gave one."""
    from aeroscene.metrics.collision import collision_rate  # noqa: PLC0415 - SciPy

    tally.guided.append(collision_rate(found.raw))
    if found.scene is None:
        tally.n_rejected += 1
        tally.failed[found.request.seed] = str(found.report.rejection)
        return False
    tally.failed.pop(found.request.seed, None)
    tally.feasible.append(collision_rate(found.scene))
    path = cfg.out / f"{found.scene.scene_id}.json"
    write_scene(found.scene, path)
    tally.files.append(str(path))
    return True


def _report(cfg: GenerateCfg, generator: Generator, tally: _Tally) -> None:
    seconds = tally.seconds / max(1, len(tally.files))
    files = sorted(tally.files)
    stages = {
        "guided": {"collision_rate": _mean(tally.guided), "rejected": 0},
        "feasible": {"collision_rate": _mean(tally.feasible), "rejected": tally.n_rejected},
    }
    for seed, reason in tally.failed.items():
        sys.stderr.write(f"{_PROG}: seed {seed} gave no scene: {reason}\n")
    if cfg.json:
        facts = {
            "scenes": files,
            "seconds_per_scene": seconds,
            "device": generator.device,
            "failed": sorted(tally.failed),
            "stages": stages,
        }
        print_json(facts)
        return
    print(
        f"{cfg.out}: {len(files)} scenes, {seconds:.2f} s each on {generator.device}, "
        f"{tally.n_rejected} draws rejected"
    )


def _mean(values: Sequence[float]) -> float | None:
    return sum(values) / len(values) if values else None
