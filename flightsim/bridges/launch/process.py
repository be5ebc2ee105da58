"""Process of an external flight stack: started in a folder of its own, and ended with the run."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
from pathlib import Path

from flightsim.bridges.launch.launch import Launch
from flightsim.bridges.physics.bridge import BridgeError

_PATIENCE_S = 0.5
"""Time that the processes have to end by themselves after a signal."""
_LOG = "output.txt"


class StackProcess:
    """A running binary, with its process group and the folder of its output."""

    def __init__(self, title: str, binary: Path, launch: Launch, folder: Path) -> None:
        """Start a binary.

        Args:
            title: Name of the flight stack for messages.
            binary: Its executable file.
            launch: Arguments and variables to start it with.
            folder: Existing folder, which becomes its working directory and keeps its output.

        Raises:
            BridgeError: If the file is not there, or cannot be run.
        """
        self._title = title
        self._log = folder / _LOG
        if not binary.is_file() or not os.access(binary, os.X_OK):
            raise BridgeError(
                f"autopilot-binary {str(binary)!r} is no program; valid: {title}'s, for simulation"
            )
        environment = {
            name: value.replace("$PATH", os.environ.get("PATH", ""))
            for name, value in launch.environment.items()
        }
        try:
            with self._log.open("wb") as log:
                self._process = subprocess.Popen(  # noqa: S603 - the user names the program
                    [str(binary.resolve()), *launch.arguments],
                    cwd=folder,
                    env={**os.environ, **environment},
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,  # so the children end with it
                )
        except OSError as error:
            raise BridgeError(
                f"autopilot-binary {str(binary)!r} does not start: {error.strerror}"
            ) from error

    def fault(self) -> str:
        """Return a line about how the process ended, with its last words; empty while it runs."""
        # Popen reports death by a signal as the signal's number with a minus sign.
        status = self._process.poll()
        if status is None:
            return ""
        how = (
            f"exit with status {status}"
            if status >= 0
            else f"end by {signal.Signals(-status).name}"
        )
        words = self._log.read_text(encoding="utf-8", errors="replace").split("\n")
        said = [word.strip() for word in words if word.strip()]
        return f"{self._title}'s {how}" + (f"; its last line: {said[-1]}" if said else "")

    def close(self) -> None:
        """End the process and those that it started, by force if it does not end when asked."""
        for number in (signal.SIGTERM, signal.SIGKILL):
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, number)
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(_PATIENCE_S)
                return
        self._process.wait()
