"""`aeroscene evaluate`: each table of the paper, and further ones, by one command."""

from __future__ import annotations

import platform
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import msgspec
import tyro
from rich.table import Table

from aeroscene.ranges import SEEDS, THREADS, Range
from scenarios.cli.command_line import (
    EXIT_DONE,
    EXIT_INTERRUPTED,
    default_hint,
    fail,
    handling_signals,
    print_json,
)
from scenarios.cli.outputs import OutFolder
from scenarios.cli.progress import progress_bar, share_bar
from scenarios.cli.terminal import terminal

if TYPE_CHECKING:
    from aeroscene.metrics.scorecard import Metric
    from scenarios.evaluation.entrants import Entrant
    from scenarios.evaluation.evaluation import Evaluation
    from scenarios.evaluation.leads import Lead
    from scenarios.evaluation.rows import Row
    from scenarios.evaluation.sources import Data

_PROG = "aeroscene evaluate"
_LEAST_SCENES = 8
"""`frechet.LEAST_PICTURES`, whose module loads SciPy; `--help` should not."""
_OURS = ("ours", "ours_shipped")


@dataclass(frozen=True, kw_only=True)
class EvaluateCfg:
    """Compare methods that make scenes: train each, draw scenes, judge all alike.

    Every method gets the same scenes and the same budget. Ctrl-C leaves the work as it is; the same
    command goes on from there, and so does a larger --scenes. OUT then has TABLE.json, .md and
    .png, pictures in TABLE-scenes.png, learning curves in TABLE-curves.png, and trained models and
    drawn scenes under methods/.
    """

    table: Literal["synthesis", "ablation", "choices", "damage"] = "synthesis"
    """synthesis has the methods; ablation ours and the paper's with parts taken away; choices ours
    trained and sampled otherwise; damage real scenes that are damaged on purpose, which shows to
    what the figures respond."""
    data: Literal["corpus", "front3d", "procthor", "city"] = "corpus"
    """Scenes to learn from and to compare with."""
    path: Annotated[Path | None, default_hint("./corpus for the corpus")] = None
    """Folder that `aeroscene dataset build` has made, or your own file of neutral layouts."""
    protocol: Literal["ours", "diffuscene"] = "ours"
    """Way to take and compare pictures: ours in colour from above and from aside; diffuscene as its
    authors do, from above in class colours, furniture alone."""
    room: Annotated[
        str | None, default_hint("bedroom with --protocol diffuscene, else all rooms")
    ] = None
    """Use only layouts with this attributes.room_type."""
    out: Annotated[Path, OutFolder()] = Path("evaluation")
    """Folder to work in; it is made if it is missing."""
    scenes: Annotated[int, Range(_LEAST_SCENES, 1_000_000)] = 1000
    """Scenes of each method; real ones are at most as many as the test split has."""
    methods: tuple[str, ...] = ()
    """Rows of the table by name. [default: all]"""
    cpu_minutes: Annotated[
        float | None, Range(0.0, unit="minutes", is_above=True), default_hint("60 without --steps")
    ] = None
    """Budget of each method's training in CPU time."""
    steps: Annotated[int | None, Range(1, 1_000_000_000), default_hint("no limit")] = None
    """Budget of each method's training in steps; it ends at whichever comes first."""
    demo: Annotated[int, Range(0, 1_000_000)] = 0
    """Number of draws of each method that the demo flies and should land in."""
    seed: Annotated[int, SEEDS] = 0
    """Seed of trainings, draws and resampling."""
    width: Annotated[int, Range(16, 4096)] = 192
    """Width of the baselines' networks."""
    levels: Annotated[int, Range(1, 64)] = 4
    """Levels or layers of the baselines' networks."""
    denoising_steps: Annotated[int, Range(1, 1000)] = 100
    """Denoising steps of the baselines that diffuse."""
    inception: Annotated[Path | None, default_hint("EfficientNet-Lite0")] = None
    """File inception-2015-12-05.pt. Only distances of its features are called FID and KID."""
    threads: Annotated[int, THREADS] = 1
    """CPU threads."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: settings of the table, files, rows with method, metric, value,
    interval_95 and n, and leads of our methods over the best of the others."""


def run(cfg: EvaluateCfg) -> int:
    """Make the table, going on from earlier work in the folder, and print its main figures.

    Returns:
        0, or 130 if the user stopped it. Input that does not allow a table ends the process with
        status 2 and one line.
    """
    from aeroscene.learning import require_torch
    from aeroscene.metrics.discrepancy import TooFewScenesError
    from aeroscene.scene import SceneError

    try:
        require_torch()
        return _run(cfg)
    except (SceneError, TooFewScenesError) as error:
        fail(_PROG, str(error))


def _run(cfg: EvaluateCfg) -> int:
    # Imported here because PyTorch takes seconds that no other command should spend.
    import torch

    from aeroscene.learning.baselines.model import BaselineCfg
    from aeroscene.learning.training.config import Budget, require
    from aeroscene.metrics.appearance.features import open_network
    from scenarios.evaluation.entrants import entrants_of
    from scenarios.evaluation.evaluation import Evaluation, EvaluationCfg, StoppedError

    # Refuse bad options before reading the scenes.
    require(ok=0 <= cfg.demo <= cfg.scenes, name="demo", value=cfg.demo, valid="0 to --scenes")
    baseline = BaselineCfg(width=cfg.width, levels=cfg.levels, steps=cfg.denoising_steps)
    minutes = 60.0 if cfg.cpu_minutes is None and cfg.steps is None else cfg.cpu_minutes
    # Made for its check of the values alone.
    Budget(steps=cfg.steps, seconds=None if minutes is None else 60.0 * minutes)
    torch.set_num_threads(cfg.threads)
    room = cfg.room or ("bedroom" if cfg.protocol == "diffuscene" else None)
    require(
        ok=cfg.data != "corpus" or room is None,
        name="data",
        value=cfg.data,
        valid="front3d or procthor with --protocol diffuscene or --room",
    )
    network = open_network(cfg.inception)
    data = _read(cfg, room)
    entrants = entrants_of(cfg.table, data, cfg.methods)
    asked = EvaluationCfg(
        data=data.name,
        data_digest=data.digest,
        network=f"{network.name} {network.digest}",
        seed=cfg.seed,
        cpu_minutes=minutes,
        steps=cfg.steps,
        baseline=baseline,
        protocol=cfg.protocol,
        room=room,
    )
    with _asked_to_stop() as stop:
        evaluation = Evaluation(asked, data, network, cfg.out, stop.is_set)
        try:
            with share_bar() as on_progress:
                rows = evaluation.run(entrants, cfg.scenes, cfg.demo, on_progress)
        except StoppedError:
            sys.stderr.write(f"{_PROG}: stopped; the same command goes on from here\n")
            return EXIT_INTERRUPTED
    _tell(cfg, evaluation, data, entrants, rows)
    return EXIT_DONE


def _read(cfg: EvaluateCfg, room: str | None) -> Data:
    from scenarios.evaluation.sources import count_scenes, open_data

    title = "reading scenes" if cfg.data == "corpus" else "mapping layouts"
    with progress_bar(title, count_scenes(cfg.data, cfg.path)) as advance:
        return open_data(cfg.data, cfg.path, advance, room)


@contextmanager
def _asked_to_stop() -> Iterator[threading.Event]:
    """Yield an event that SIGINT or SIGTERM sets; a second one ends the process at once."""
    event = threading.Event()

    def ask(number: int, _frame: Any) -> None:
        event.set()
        # The first signal waits for the end of a step. The second does not wait.
        signal.signal(number, signal.default_int_handler)

    with handling_signals(ask):
        yield event


def _tell(
    cfg: EvaluateCfg,
    evaluation: Evaluation,
    data: Data,
    entrants: Sequence[Entrant],
    rows: Sequence[Row],
) -> None:
    from scenarios.evaluation.curves import CURVES, draw_learning_curves
    from scenarios.evaluation.drawing import PROJECTED
    from scenarios.evaluation.gallery import GALLERY, draw_gallery, shown_stage
    from scenarios.evaluation.rows import stage_name
    from scenarios.evaluation.table import to_plain, write_table

    titles: dict[str, str] = {}
    for entrant in entrants:
        titles[entrant.name] = entrant.title
        titles[stage_name(entrant.name, PROJECTED)] = f"{entrant.title}, projected"
    head = {
        "table": cfg.table,
        "data": data.name,
        "protocol": cfg.protocol,
        "room": evaluation.cfg.room,
        "train_scenes": len(data.train),
        "test_scenes": len(data.test),
        "seed": cfg.seed,
        "cpu_minutes": evaluation.cfg.cpu_minutes,
        "steps": cfg.steps,
        "machine": f"{platform.machine()}, {cfg.threads} thread(s), Python "
        f"{platform.python_version()}",
    }
    metrics = evaluation.judge.metrics()
    leads = _leads(entrants, rows, metrics) if cfg.table == "synthesis" else {}
    files = write_table(cfg.out, cfg.table, head, rows, metrics, titles, leads)
    named = {name for row in rows for name in (row.method,)}
    shown = {
        titles[name]: (evaluation.draws(entrant, cfg.scenes), shown_stage(name))
        for entrant in entrants
        for name in (entrant.name, stage_name(entrant.name, PROJECTED))
        if name in named
    }
    gallery = cfg.out / f"{cfg.table}-{GALLERY}"
    draw_gallery(
        gallery,
        {title: draws for title, (draws, _) in shown.items()},
        {title: stage for title, (_, stage) in shown.items()},
        evaluation.camera,
    )
    curves = cfg.out / f"{cfg.table}-{CURVES}"
    looks = [evaluation.curves(entrant) for entrant in entrants]
    files += [gallery]
    if draw_learning_curves(curves, {title: each for one in looks for title, each in one.items()}):
        files += [curves]
    if cfg.json:
        said = {"rows": to_plain(rows), "leads": msgspec.to_builtins(leads)}
        print_json({**head, "files": [str(path) for path in files], **said})
        return
    _print_table(rows, [*list(evaluation.judge.metrics())[:2], "CR", "CFC", "SP", "OP", "flies"])
    print(f"All figures: {', '.join(str(path) for path in files)}")


def _leads(
    entrants: Sequence[Entrant], rows: Sequence[Row], metrics: Mapping[str, Metric]
) -> dict[str, list[Lead]]:
    """Return, for each of our methods, its leads over the best of the others."""
    from scenarios.evaluation.leads import leads_of

    drawn = {row.method for row in rows}
    ours = [each.name for each in entrants if each.name in _OURS and each.name in drawn]
    others = [each.name for each in entrants if each.name not in _OURS and not each.is_real]
    found = {name: leads_of(name, others, rows, metrics) for name in ours}
    return {name: leads for name, leads in found.items() if leads}


def _print_table(rows: Sequence[Row], shown: Sequence[str]) -> None:
    cells = {(row.method, row.metric): row.value for row in rows}
    table = Table("method", *shown)
    say: Callable[[float | None], str] = lambda value: "" if value is None else f"{value:.3g}"  # noqa: E731
    for method in dict.fromkeys(row.method for row in rows):
        table.add_row(method, *(say(cells.get((method, metric))) for metric in shown))
    terminal().print(table)
