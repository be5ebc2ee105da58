"""A hostile file, and the command that reads it."""

from __future__ import annotations

import gzip
import json
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

HERE = "{here}"
"""Placeholder for the folder of the files, in a command and in contents."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """A command that meets files which somebody else made."""

    kind: str
    name: str
    command: tuple[str, ...]
    """Words behind `aeroscene`."""
    files: Mapping[str, bytes] = field(default_factory=dict)
    """Contents by their paths."""

    def write(self, folder: Path) -> list[str]:
        """Write the files of the case.

        Args:
            folder: Folder to write in, made if it is missing.

        Returns:
            Words of the command, with the folder in the place of `HERE`.
        """
        for name, content in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content.replace(HERE.encode(), str(folder).encode()))
            # A program that was shared may be started: then the judge must see it.
            path.chmod(0o755)
        return [word.replace(HERE, str(folder)) for word in self.command]


def changed(document: Any, way: str, value: Any) -> bytes:
    """A JSON document with one value changed, as UTF-8; the document itself stays.

    Args:
        document: Document.
        way: Keys and indices down to the value, such as `objects.0.bbox.p`.
        value: New value; it need not be one that JSON knows, such as NaN.
    """
    copy = deepcopy(document)
    place = copy
    *steps, last = (int(step) if step.isdigit() else step for step in way.split("."))
    for step in steps:
        place = place[step]
    place[last] = value
    return json.dumps(copy).encode()


def packed(piece: bytes, count: int) -> bytes:
    """Gzip of a piece, repeated, made without unpacking it all.

    A gzip file may have several members, one after another, so that one compressed mebibyte serves
    for all of them.

    Args:
        piece: Piece to repeat.
        count: Number of times.
    """
    most = max(1, (1 << 20) // max(1, len(piece)))
    whole, rest = divmod(count, most)
    return gzip.compress(piece * most, 1) * whole + gzip.compress(piece * rest, 1)
