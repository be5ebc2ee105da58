"""The one place where terminals are made, which print every text as it is.

rich reads `[bold]` in a text as markup, and `:car:` as a picture. Names of files, categories and
reasons of failures come from users and may hold either, so both are switched off here. Styled text
is a `Text` of parts with their styles. ruff refuses rich's own consoles elsewhere (pyproject.toml).
"""

from __future__ import annotations

import shlex
from pathlib import Path

from rich.console import Console
from rich.progress import TextColumn
from rich.text import Text

Terminal = Console
"""Type of what `terminal` returns."""


def terminal(*, stderr: bool = False, width: int | None = None) -> Terminal:
    """Open standard output, or standard error, for text and tables.

    Args:
        stderr: True opens standard error.
        width: Number of columns; None takes the terminal's.
    """
    return Console(stderr=stderr, width=width, markup=False, emoji=False)


def styled(*parts: str | tuple[object, str]) -> Text:
    """Return a text made of parts.

    Args:
        parts: Plain texts, or pairs of a value to show and its style, such as `bold` or `red`.
    """
    return Text.assemble(
        *(part if isinstance(part, str) else (str(part[0]), part[1]) for part in parts)
    )


def plain_column(template: str) -> TextColumn:
    """Return a column of a progress bar that shows fields of its task as plain text.

    Args:
        template: Text with fields in braces, such as `{task.description}`.
    """
    return TextColumn(template, markup=False)


def shell(*words: str | Path) -> str:
    """Return a command line that can be pasted into a shell, whatever its words hold."""
    return shlex.join(str(word) for word in words)
