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
"""In a command, and in a text of a file: the folder in which the files of the case lie."""


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
        """Write the files; returns the words of the command."""
        for name, content in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        return [word.replace(HERE, str(folder)) for word in self.command]


def changed(document: Any, way: str, value: Any) -> bytes:
    """A JSON document with one value changed; the way is such as `objects.0.bbox.p`."""
    copy = deepcopy(document)
    place = copy
    *steps, last = (int(step) if step.isdigit() else step for step in way.split("."))
    for step in steps:
        place = place[step]
    place[last] = value
    return json.dumps(copy).encode()


def packed(piece: bytes, count: int) -> bytes:
    """Gzip of a piece, again and again, made without unpacking it all."""
    most = max(1, (1 << 20) // max(1, len(piece)))
    whole, rest = divmod(count, most)
    return gzip.compress(piece * most, 1) * whole + gzip.compress(piece * rest, 1)
