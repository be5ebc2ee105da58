"""Files and folders that commands write, checked before a command begins its work.

A trained model, a campaign or an evaluation takes minutes to hours. A name that cannot be written
to should not cost that time. Options therefore carry a mark in their type, for example
`Annotated[Path, OutFolder()]`, which `option_faults` checks right after parsing.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class OutFolder:
    """Marks an option as a folder that a command writes into, and makes if it is missing."""

    def fault(self, name: str, path: Path) -> str | None:
        """Return the line that refuses a path, or None if it can be written.

        Args:
            name: Name of the option without its dashes, for the line.
            path: Folder that the user named.
        """
        if path.exists() and not path.is_dir():
            return f"{name} {str(path)!r} is a file; valid: a folder, which may be missing"
        return _closed(name, path, path)


@dataclass(frozen=True, slots=True)
class OutFile:
    """Marks an option as a file that a command writes; its folder is made if it is missing."""

    suffixes: tuple[str, ...] = ()
    """Suffixes that it may have, such as ".png"; empty allows all."""

    def fault(self, name: str, path: Path) -> str | None:
        """Return the line that refuses a path, or None if it can be written.

        Args:
            name: Name of the option without its dashes, for the line.
            path: File that the user named.
        """
        if self.suffixes and path.suffix not in self.suffixes:
            valid = ", ".join(f"NAME{suffix}" for suffix in self.suffixes)
            return f"{name} {str(path)!r} is no {' or '.join(self.suffixes)} file; valid: {valid}"
        if path.is_dir():
            return f"{name} {str(path)!r} is a folder; valid: a file, which may be missing"
        return _closed(name, path, path.parent)


def _closed(name: str, path: Path, folder: Path) -> str | None:
    """Return why nothing can be written to a folder or to its nearest existing parent."""
    # A missing folder will be made, so the nearest one that exists decides.
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    if not folder.is_dir():
        return f"{name} {str(path)!r}: {str(folder)!r} is a file; valid: a path through folders"
    if not os.access(folder, os.W_OK | os.X_OK):
        return f"{name} {str(path)!r}: {str(folder)!r} may not be written to; valid: another folder"
    return None
