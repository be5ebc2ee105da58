"""`aeroscene train`: a model that generates scenes, trained step by step."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from aeroscene.ranges import THREADS, Range
from scenarios.cli.command_line import (
    EXIT_DONE,
    EXIT_INTERRUPTED,
    default_hint,
    fail,
    handling_signals,
    print_json,
)
from scenarios.cli.outputs import OutFolder
from scenarios.cli.training_bar import TrainingBar, training_bar
from scenarios.cli.training_plan import require_usable, say_what_lacks, training_plan

if TYPE_CHECKING:
    from aeroscene.learning.training.checkpoint_facts import Part
    from aeroscene.learning.training.procedure import Plan, Training

_PROG = "aeroscene train"
_MOST_STEPS = 1_000_000_000


@dataclass(frozen=True, kw_only=True)
class TrainCfg:
    """Train a model that generates scenes: first what writes them, then what places it.

    Ctrl-C saves and leaves; the same command with --resume goes on from there. The folder then
    holds checkpoint.safetensors for `aeroscene generate`, state.safetensors to go on from,
    log.jsonl and curves.png.
    """

    preset: Annotated[
        Literal["default", "paper", "progressive"] | None, default_hint("default")
    ] = None
    """Model and training: default is ours, paper follows the paper to the letter."""
    config: Annotated[Path | None, default_hint("none")] = None
    """TOML file that changes fields of the preset; see docs/model.md."""
    data: Path = Path("corpus")
    """Folder that `aeroscene dataset build` has made, or a file of neutral layouts."""
    stream: bool = False
    """Go on beyond the folder's last scene: processes make scene after scene while the network
    learns. The folder's training scenes fix vocabulary and statistics, its test scenes are held
    out."""
    workers: Annotated[
        int | None, Range(1, 512), default_hint("cores less one with --stream, at least 1")
    ] = None
    """Number of processes that make scenes for --stream; the weights do not depend on it."""
    out: Annotated[Path, OutFolder()] = Path("training")
    """Folder to write to; it is made where there is none."""
    steps: Annotated[int | None, Range(1, _MOST_STEPS), default_hint("no limit")] = None
    """Training steps of writer and denoiser each; the weights do not depend on whether the training
    was resumed."""
    minutes: Annotated[
        float | None, Range(0.0, unit="minutes", is_above=True), default_hint("60 without --steps")
    ] = None
    """Minutes of training, half for the writer and half for the denoiser, or all for the one
    that is trained; it ends at steps or minutes, whichever comes first."""
    resume: bool = False
    """Continue the training in the folder."""
    device: str = "auto"
    """auto takes a GPU where there is one; or cpu, cuda, cuda:1, mps."""
    threads: Annotated[int | None, THREADS, default_hint("all cores")] = None
    """Number of CPU threads."""
    parts: Annotated[
        tuple[Literal["writer", "prior", "denoiser"], ...] | None,
        default_hint("all of these", metavar="{writer,prior,denoiser} ..."),
    ] = None
    """Parts of the model to train. The default preset has writer and denoiser, paper has prior (a
    minute) and denoiser."""
    take: Annotated[Path | None, default_hint("none")] = None
    """Checkpoint from which the parts that are not trained are copied; it must be of the same
    data."""
    begin: Annotated[str | None, default_hint("random weights")] = None
    """Checkpoint with whose weights the parts begin that are trained, or `shipped` for the one that
    ships: a model of other scenes learns these in less time."""
    keep_language: bool = False
    """Keep the kinds and statistics of --begin, rather than learn them from the data: its model
    goes on with more scenes of one grammar. Parts that are not trained stay as they are there, and
    scenes of a kind that it does not know are left out."""
    save_minutes: Annotated[float, Range(0.0, unit="minutes", is_above=True)] = 5.0
    """Minutes between two saves."""
    json: bool = False
    """Print one JSON object: folder, checkpoint, preset, device, done, and figures of the
    training."""


def run(cfg: TrainCfg) -> int:
    """Train; exit status 2 with one line where input, device or memory do not allow it."""
    from aeroscene.learning import require_torch
    from aeroscene.scene import SceneError

    try:
        require_torch()
        head = require_usable(cfg)
        # Imported here because PyTorch takes seconds that no other command should spend.
        from aeroscene.learning.training.procedure import Training
        from aeroscene.learning.training.state import read_state
        from aeroscene.learning.training.state_head import STATE

        with _asked_to_stop() as stop:
            state = None if head is None else read_state(cfg.out / STATE)
            plan = training_plan(cfg, head)
            say_what_lacks(cfg.data)
            with training_bar() as bar:
                training = Training(plan, _Watcher(bar, stop))
                is_done = training.run(state)
    except SceneError as error:
        fail(_PROG, str(error))
    _report(cfg, plan, training, is_done=is_done)
    return EXIT_DONE if is_done else EXIT_INTERRUPTED


@dataclass(frozen=True)
class _Watcher:
    """Moves the progress bar, and stops the training when the user asks for it."""

    bar: TrainingBar
    stop: threading.Event

    def on_progress(self, stage: str, share: float, figures: Mapping[str, float]) -> None:
        self.bar.show(stage, share, figures)

    def wants_stop(self) -> bool:
        return self.stop.is_set()


@contextmanager
def _asked_to_stop() -> Iterator[threading.Event]:
    """Yield an event that SIGINT or SIGTERM sets; a second one ends the process at once."""
    event = threading.Event()

    def ask(number: int, _frame: Any) -> None:
        event.set()
        signal.signal(number, signal.default_int_handler)

    with handling_signals(ask):
        yield event


def _report(cfg: TrainCfg, plan: Plan, training: Training, *, is_done: bool) -> None:
    from aeroscene.learning.training.procedure import CHECKPOINT

    path = plan.folder / CHECKPOINT
    figures = training.figures
    if cfg.json:
        facts = {
            "folder": str(plan.folder),
            "checkpoint": str(path),
            "preset": plan.preset,
            "device": str(plan.device),
            "done": is_done,
        }
        print_json(facts | figures)
        return
    said = "; ".join(_said(part, figures) for part in training.trainings)
    said = said or f"parts {', '.join(training.parts)}"
    print(f"{path}: {said}")
    if not is_done:
        sys.stderr.write(f"{_PROG}: stopped and saved; --resume goes on from here\n")


def _said(part: Part, figures: Mapping[str, Any]) -> str:
    """How long a part was trained, and to which losses."""
    from aeroscene.learning.training.course import figure_prefix

    prefix = figure_prefix(part)
    names = [name for name in ("loss", "held_out_loss") if prefix + name in figures]
    losses = ", ".join(f"{name.replace('_', ' ')} {figures[prefix + name]:.4f}" for name in names)
    minutes = figures[f"{prefix}seconds"] / 60
    said = f"{part} {figures[f'{prefix}steps']:,} steps in {minutes:.1f} min, {losses}"
    if f"{prefix}held_out_least" not in figures:
        return said
    least, step = figures[f"{prefix}held_out_least"], figures[f"{prefix}held_out_least_step"]
    return f"{said} (least {least:.4f} at step {step:,})"
