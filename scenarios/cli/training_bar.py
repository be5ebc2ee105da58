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
    """Progress bar with a line for each stage of a training."""

    progress: Progress
    _tasks: dict[str, TaskID] = field(default_factory=dict)
    _figures: dict[str, float] = field(default_factory=dict)

    def show(self, stage: str, share: float, figures: Mapping[str, float]) -> None:
        """Move the bar of a stage, and update its figures.

        Args:
            stage: Name of the stage; a new one gets a line of its own.
            share: Share of the stage that is done, 0 to 1; more counts as 1.
            figures: Losses and learning rate. Those that are missing keep their last value, because
                held-out losses are measured less often.
        """
        if stage not in self._tasks:
            self._tasks[stage] = self.progress.add_task(stage, total=1.0, losses="")
            # Losses of one stage cannot be compared with those of another.
            self._figures.clear()
        self._figures |= {name: figures[name] for name in _SHOWN if name in figures}
        losses = "  ".join(
            f"{name.replace('_', ' ')} {value:.3g}" for name, value in self._figures.items()
        )
        self.progress.update(self._tasks[stage], completed=min(share, 1.0), losses=losses)


@contextmanager
def training_bar() -> Iterator[TrainingBar]:
    """Show the training bar if standard error is a terminal."""
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
