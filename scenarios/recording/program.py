"""rerun's own program: its path, and an environment in which it sends no usage statistics."""

from __future__ import annotations

import os
from pathlib import Path


class RerunMissingError(RuntimeError):
    """rerun's program is not installed."""


def rerun_program() -> Path:
    """The executable, as rerun's own launcher finds it.

    Raises:
        RerunMissingError: If it is not installed.
    """
    import rerun_cli

    folder = Path(rerun_cli.__file__).parent
    for program in (folder / "Rerun.app/Contents/MacOS/Rerun", folder / "rerun"):
        if program.exists():
            return program
    raise RerunMissingError("rerun's program is not installed; valid: pip install rerun-sdk")


def quiet_environment() -> dict[str, str]:
    """This process's environment, with rerun's usage statistics off.

    rerun sends them unless it believes to run in continuous integration (`rerun analytics
    details`); it has no other switch that leaves the user's own settings alone.
    """
    return {**os.environ, "CI": "1", "RERUN_APP_ONLY": "true"}
