"""`aeroscene new`: a starter file for a pilot, a vehicle, a scene or a recipe."""

from __future__ import annotations

import os
import re
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from keyword import iskeyword
from pathlib import Path
from typing import Annotated, Literal

import tyro

from aeroscene.files import replacing
from scenarios.cli.command_line import EXIT_DONE, fail

_PROG = "aeroscene new"
_BEGINNINGS = Path(__file__).parent / "beginnings"
_FILES = {
    "pilot": "pilot.py",
    "vehicle": "vehicle.toml",
    "scene": "scene.json",
    "recipe": "recipe.toml",
}
# A name must do for vehicles, scenes and Python modules. File systems limit its length.
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}")


@dataclass(frozen=True, kw_only=True)
class NewCfg:
    """Write a starter file: a pilot, a vehicle, a scene or a recipe of your own.

    The file runs as it is and explains itself in comments. Its first lines name the command that
    runs it. Existing files are never overwritten.
    """

    kind: tyro.conf.Positional[Literal["pilot", "vehicle", "scene", "recipe"]]
    """pilot is a Python class, vehicle and recipe are TOML files, scene is a JSON file."""
    name: tyro.conf.Positional[Annotated[str, tyro.conf.arg(metavar="NAME")]]
    """Its name: a letter, then up to 63 letters, digits and _; the file is NAME.py, .toml or
    .json."""
    out: Path = Path()
    """Folder to write to, which must exist."""


def run(cfg: NewCfg) -> int:
    """Write the file, and print its name and the command that runs it.

    Returns:
        0. A bad name, or a file that exists already, ends the process with status 2 and one line.
    """
    _check_name(cfg)
    beginning = _BEGINNINGS / _FILES[cfg.kind]
    path = cfg.out / f"{cfg.name}{beginning.suffix}"
    text = beginning.read_text("utf-8").replace(f"my_{cfg.kind}", cfg.name)
    # `lexists`, because a broken link is also something that would be written over.
    if os.path.lexists(path):
        fail(_PROG, f"file {str(path)!r} is there already; valid: another name")
    # Written under another name first, so that nobody sees half a file.
    with replacing(path) as file:
        file.write(text.encode())
    print(f"{path}\nRun it with: {command_of(text)}")
    return EXIT_DONE


def command_of(text: str) -> str:
    """Return the command that the head of a starter file names.

    Args:
        text: The file's content, which has a line with `Run: COMMAND`.

    Raises:
        ValueError: If it has no such line.
    """
    found = re.search(r'Run: ([^"\n]+)', text)
    if found is None:
        raise ValueError("a file to begin with names no command")
    return found[1].strip()


def _check_name(cfg: NewCfg) -> None:
    """Refuse a name that a file, a scene or a module cannot have."""
    if not _NAME.fullmatch(cfg.name):
        fail(
            _PROG,
            f"name {cfg.name!r} is not valid; valid: a letter, then up to 63 letters, digits and _",
        )
    if cfg.kind == "pilot" and (
        iskeyword(cfg.name) or cfg.name in sys.stdlib_module_names or find_spec(cfg.name)
    ):
        # Such a file would be taken for the module by everything that runs beside it.
        fail(_PROG, f"name {cfg.name!r} is that of a module; valid: one that no module has")
