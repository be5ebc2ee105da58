"""Errors of files and of the machine, as the one line in which a command ends because of them."""

from __future__ import annotations

import os
import sys
import tomllib
from types import ModuleType

import msgspec

from aeroscene.scene import SceneError


def one_line(error: Exception) -> str | None:
    """What to say of an error that a user can mend; None where the fault may be ours.

    Readers of files say which field is wrong. This is for what none of them has foreseen: a full
    disk in the middle of an export, a document that is nested without end, a world that MuJoCo
    refuses. `AEROSCENE_TRACEBACK=1` shows all of them with their traceback.
    """
    if os.environ.get("AEROSCENE_TRACEBACK") == "1":
        return None
    if isinstance(error, (SceneError, *_input_errors())):
        return str(error)
    if isinstance(error, OSError):
        return of_file(error)
    if isinstance(error, MemoryError):
        return "there is not enough memory; valid: a smaller scene or file"
    if isinstance(error, RecursionError):
        return "a file is nested too deeply; valid: one that a program of ours has written"
    if isinstance(error, (tomllib.TOMLDecodeError, msgspec.DecodeError)):
        return f"a file is damaged: {error}; valid: one that was written whole"
    if isinstance(error, _library_errors()):
        return f"{error}; valid: a whole file, and a world that can be built"
    return None


def of_file(error: OSError) -> str:
    """Which file cannot be read or written, and why."""
    reason = (error.strerror or str(error) or type(error).__name__).lower()
    if error.filename:
        return f"file {str(error.filename)!r}: {reason}, valid: a path that you may read or write"
    return reason


def _input_errors() -> tuple[type[Exception], ...]:
    """Errors that the simulator names itself; where it is not loaded it has raised none."""
    if "flightsim" not in sys.modules:
        return ()
    from scenarios.run.input_errors import INPUT_ERRORS  # noqa: PLC0415 - the whole simulator

    return INPUT_ERRORS


def _library_errors() -> tuple[type[Exception], ...]:
    """Errors of MuJoCo and pyarrow, as far as they are loaded."""
    found = [
        getattr(_loaded(module), name, None)
        for module, name in (
            ("mujoco", "FatalError"),
            ("mujoco", "UnexpectedError"),
            ("pyarrow", "ArrowException"),
        )
    ]
    return tuple(kind for kind in found if kind is not None)


def _loaded(module: str) -> ModuleType | None:
    return sys.modules.get(module)
