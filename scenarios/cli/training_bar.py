"""Progress bar of a training on standard error, with losses and remaining time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

from rich.progress import BarColumn, Progress, TaskID, TimeRemainingColumn

from scenarios.cli.terminal import plain_column, terminal

_SHOWN = ("total", "held_out", "learning_rate")


@dataclass
class TrainingBar:
    """Progress bar with a line for each stage."""

    progress: Progress
    _tasks: dict[str, TaskID] = field(default_factory=dict)
    _figures: dict[str, float] = field(default_factory=dict)

    def show(self, stage: str, share: float, figures: Mapping[str, float]) -> None:
        """Move a stage's bar to a share, 0 to 1; old figures stay until there are newer ones."""
        if stage not in self._tasks:
            self._tasks[stage] = self.progress.add_task(stage, total=1.0, losses="")
            self._figures.clear()
        self._figures |= {name: figures[name] for name in _SHOWN if name in figures}
        losses = "  ".join(
            f"{name.replace('_', ' ')} {value:.3g}" for name, value in self._figures.items()
        )
        self.progress.update(self._tasks[stage], completed=min(share, 1.0), losses=losses)


@contextmanager
def training_bar() -> Iterator[TrainingBar]:
    """Show the training bar where standard error is a terminal."""
    columns = (
        plain_column("{task.description}"),
        BarColumn(),
        plain_column("{task.percentage:.0f}%"),
        plain_column("{task.fields[losses]}"),
        TimeRemainingColumn(elapsed_when_finished=True),
    )
    console = terminal(stderr=True)
    with Progress(*columns, console=console, disable=not console.is_terminal) as progress:
        yield TrainingBar(progress)
