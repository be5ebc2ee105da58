"""`aeroscene train`: the training of a model that generates scenes."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenarios.cli.command_line import (
    EXIT_DONE,
    EXIT_INTERRUPTED,
    fail,
    handling_signals,
    print_json,
)
from scenarios.cli.train_options import TrainCfg
from scenarios.cli.training_bar import TrainingBar, training_bar
from scenarios.cli.training_plan import require_usable, training_plan, warn_of_missing_scenes

if TYPE_CHECKING:
    from aeroscene.learning.training.checkpoint_facts import Part
    from aeroscene.learning.training.procedure import Plan, Training

_PROG = "aeroscene train"


def run(cfg: TrainCfg) -> int:
    """Train until the budget is used up or the user stops it, and save.

    Returns:
        0 if the training is done, 130 if it was stopped and saved. Input, device or memory that do
        not allow it end the process with status 2 and one line.
    """
    from aeroscene.learning import require_torch
    from aeroscene.scene import SceneError

    try:
        require_torch()
        head = require_usable(cfg)
        # Imported here because PyTorch takes seconds that no other command should spend.
        from aeroscene.learning.training.procedure import Training
        from aeroscene.learning.training.state import read_state
        from aeroscene.learning.training.state_head import STATE

        # From here on a signal asks for an orderly stop, also while state and data are read.
        with _asked_to_stop() as stop:
            state = None if head is None else read_state(cfg.out / STATE)
            plan = training_plan(cfg, head)
            warn_of_missing_scenes(cfg.data)
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
        # The first signal waits for the end of a step, to save. The second does not wait.
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
    """Return how long a part was trained, and to which losses, in words."""
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
