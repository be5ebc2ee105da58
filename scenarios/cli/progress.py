"""Progress bars on standard error, for work in parts and for work item by item.

The bars show only on a terminal, and are removed at the end. Standard output belongs to results, so
that it can be piped.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TaskProgressColumn,
    TimeRemainingColumn,
)
from rich.text import Text

from scenarios.cli.terminal import plain_column, terminal


class Advance(Protocol):
    """Function that advances a progress bar."""

    def __call__(self, count: int = 1, /, title: str | None = None) -> None:
        """Advance the bar by one item or by several.

        Args:
            count: Number of items that are done since the last call.
            title: New title of the bar; None keeps the present one.
        """


class _Rate(ProgressColumn):
    """Column with the items done per second."""

    def render(self, task: Task) -> Text:
        speed = task.finished_speed or task.speed
        if speed is None:
            return Text("")
        # Below one item a second, one decimal would be too coarse.
        return Text(f"{speed:.{1 if speed >= 1.0 else 2}f} {task.fields['unit']}/s")


@contextmanager
def share_bar() -> Iterator[Callable[[str, float], None]]:
    """Show a progress bar for work in parts on a terminal, and remove it at the end.

    Yields:
        Function to call with the title of a part and the share done, 0 to 1.
    """
    console = terminal(stderr=True)
    columns = (
        plain_column("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeRemainingColumn(),
    )
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as progress:
        task = progress.add_task("", total=1.0)
        yield lambda title, share: progress.update(task, description=title, completed=share)


@contextmanager
def progress_bar(title: str, total: int, unit: str = "scenes") -> Iterator[Advance]:
    """Show a progress bar with rate and remaining time, and remove it at the end.

    Args:
        title: Text before the bar.
        total: Number of items.
        unit: Name of the items in the plural, for the rate.

    Yields:
        Function to call when an item is done, or with the number of items done.
    """
    columns = (
        plain_column("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        _Rate(),
        TimeRemainingColumn(elapsed_when_finished=True),
        plain_column("left"),
    )
    console = terminal(stderr=True)
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as progress:
        task = progress.add_task(title, total=total, unit=unit)
        yield lambda count=1, /, title=None: progress.update(task, advance=count, description=title)
