"""rerun's own program: its path, and an environment in which it sends no usage statistics."""

from __future__ import annotations

import os
from pathlib import Path


class RerunMissingError(RuntimeError):
    """rerun's program is not installed."""


def rerun_program() -> Path:
    """Return the path of rerun's executable, as its own launcher finds it.

    On macOS it is within an application bundle.

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
    """Return this process's environment, with rerun's usage statistics off.

    rerun sends statistics unless it believes that it runs in continuous integration (`rerun
    analytics details`). It has no other switch that leaves the user's own settings alone.
    """
    return {**os.environ, "CI": "1", "RERUN_APP_ONLY": "true"}
