"""A program that flies a trial: started with the task, ended with the trial.

Programs of others start further processes, never read, never end, or print without end. Each runs
in a session of its own, so that one signal reaches everything that it has started.
"""

from __future__ import annotations

import contextlib
import os
import shlex
import shutil
import signal
import subprocess
import sys
import threading
from typing import IO, Self

_LAST_BYTES = 4096
"""Bytes that are kept from the end of a program's standard error."""
_FAREWELL_S = 2.0
"""Time for a program to end when its trial is over."""

_running: Program | None = None
"""The program of this process; at most one trial is flown at a time."""


class ProgramError(ValueError):
    """There is no such program; one line says so, and what would be valid."""


def words_of(command: str) -> list[str]:
    """Return the words of a command line; no shell reads it.

    Raises:
        ProgramError: If it names no program that exists.
    """
    valid = "valid: a command such as 'python my_stack.py'"
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise ProgramError(f"program {command!r}: {str(error).lower()}; {valid}") from None
    if not words or shutil.which(words[0]) is None:
        raise ProgramError(f"program {command!r} is not there; {valid}")
    return words


class Program:
    """A running program, in a session of its own; leaving the context ends it and its children."""

    def __init__(self, command: str, brief: str, *, is_shown: bool) -> None:
        """Start it.

        Args:
            command: Command line.
            brief: One line for its standard input.
            is_shown: True to show its output; else only the end is kept, for a reason.

        Raises:
            ProgramError: If there is no such program.
            OSError: If it cannot be started.
        """
        global _running  # noqa: PLW0603 - a signal handler ends it
        self._is_shown = is_shown
        self._end = b""
        self._process = subprocess.Popen(  # noqa: S603 - it is the user's own
            words_of(command),
            stdin=subprocess.PIPE,
            stdout=None if is_shown else subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
        _running = self
        assert self._process.stdin is not None
        assert self._process.stderr is not None
        self._reader = threading.Thread(target=self._read, args=(self._process.stderr,))
        self._reader.daemon = True
        self._reader.start()
        # It may have ended, or may never read: neither must block or fail the trial.
        with contextlib.suppress(OSError):
            os.set_blocking(self._process.stdin.fileno(), False)
            os.write(self._process.stdin.fileno(), brief.encode() + b"\n")

    @property
    def status(self) -> int | None:
        """Exit status; None while it runs."""
        return self._process.poll()

    def wait(self, seconds: float) -> int | None:
        """Return the exit status; None if it still runs after some time."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            return self._process.wait(seconds)
        return None

    def last_line(self) -> str:
        """Return the last line of its standard error; empty if there is none."""
        if self.status is not None:
            self._reader.join(_FAREWELL_S)
        lines = self._end.decode(errors="replace").split("\n")
        return next((" ".join(line.split()) for line in reversed(lines) if line.strip()), "")

    def end(self, farewell_s: float = _FAREWELL_S) -> None:
        """End it and all processes that it has started; a second call is harmless.

        Args:
            farewell_s: Time for it to end by itself, and again after SIGTERM.
        """
        global _running  # noqa: PLW0603 - as above
        _running = None
        self.wait(farewell_s)
        # The process group may live on after its leader has ended.
        self._signal(signal.SIGTERM)
        if self.status is None:
            self.wait(farewell_s)
        self._signal(signal.SIGKILL)
        self._process.wait()
        self._close_pipes()

    def _close_pipes(self) -> None:
        """Close the pipes to it, unless a process that left its group still writes."""
        assert self._process.stdin is not None
        assert self._process.stderr is not None
        self._process.stdin.close()
        self._reader.join(_FAREWELL_S)
        if not self._reader.is_alive():
            self._process.stderr.close()

    def _signal(self, number: signal.Signals) -> None:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, number)

    def _read(self, pipe: IO[bytes]) -> None:
        """Keep the end of its output for as long as it writes."""
        while data := os.read(pipe.fileno(), 1 << 16):
            self._end = (self._end + data)[-_LAST_BYTES:]
            if self._is_shown:
                sys.stderr.write(data.decode(errors="replace"))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *exception: object) -> None:
        # After an error, nothing is worth waiting for.
        self.end(_FAREWELL_S if kind is None else 0.0)


def end_program() -> None:
    """End the program of this process at once, if there is one."""
    if _running is not None:
        _running._signal(signal.SIGKILL)
