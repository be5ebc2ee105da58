"""Bars on standard error: for work in parts, and for work that goes scene by scene."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeRemainingColumn,
)
from rich.text import Text


class Advance(Protocol):
    """Moves a bar on."""

    def __call__(self, count: int = 1, /) -> None:
        """By one item, or by several."""


class _Rate(ProgressColumn):
    """Items a second."""

    def render(self, task: Task) -> Text:
        speed = task.finished_speed or task.speed
        return Text("" if speed is None else f"{speed:.1f} {task.fields['unit']}/s")


@contextmanager
def share_bar() -> Iterator[Callable[[str, float], None]]:
    """A bar for work in parts where standard error is a terminal, gone when all is done.

    Yields:
        What to call with the title of a part and the share that is done, 0 to 1.
    """
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task("", total=1.0)
        yield lambda title, share: progress.update(task, description=title, completed=share)


@contextmanager
def progress_bar(title: str, total: int, unit: str = "scenes") -> Iterator[Advance]:
    """A bar with rate and time left, gone when all is done.

    Yields:
        What to call when an item is done, or with how many.
    """
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        _Rate(),
        TimeRemainingColumn(elapsed_when_finished=True),
        TextColumn("left"),
    )
    console = Console(stderr=True)
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as progress:
        task = progress.add_task(title, total=total, unit=unit)
        yield lambda count=1: progress.advance(task, count)
