"""Entry points of the console scripts; Ctrl-C ends them silently from the first moment on.

These functions run before any heavy import, because some settings only work then: environment
variables that MuJoCo, OpenBLAS and Arrow read when they load, and the handler for Ctrl-C. This
module therefore imports nothing of the project but the command that is asked for.
"""

from __future__ import annotations

import atexit
import contextlib
import gc
import importlib
import io
import os
import signal
import sys
from collections.abc import Iterator
from types import FrameType
from typing import Any, NoReturn

EXIT_INTERRUPTED = 130  # Shells report 128 + 2 for a process that SIGINT ended.
_FLYING = {"sitl", "fly", "campaign"}
"""Commands that fly."""


def aeroscene() -> int:
    """Run the command `aeroscene`, and return its exit status."""
    return _start("main")


def aeroscene_sitl() -> int:
    """Run the command `aeroscene-sitl`, and return its exit status."""
    return _start("sitl")


def _start(module: str) -> int:
    # Answered without any command's imports, so that scripts can ask often.
    if sys.argv[1:] == ["--version"]:
        print(f"aeroscene {importlib.import_module('aeroscene').__version__}")
        return 0
    _print_anything()
    # Otherwise MuJoCo's import starts a process that looks for a window library we never use.
    os.environ.setdefault("MUJOCO_GL", "disable")
    if module == "sitl" or not _FLYING.isdisjoint(sys.argv[1:2]):
        # The matrices of a flight are so small that the threads of OpenBLAS only wait for each
        # other. That cost a fifth of the CPU time of a trial with a growing map.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Arrow's own pools keep some 30 MB of what a refused table has taken.
    os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")
    # KeyboardInterrupt during an import is unsafe: libraries turn it into exceptions of their own.
    signal.signal(signal.SIGINT, _leave)
    try:
        status = _import(f"scenarios.cli.{module}").main()
    except BrokenPipeError:
        os._exit(0)  # The reader of our output has closed the pipe.
    finally:
        signal.signal(signal.SIGINT, _leave)
    if status == EXIT_INTERRUPTED:
        _end_interrupted()
    return status


def _print_anything() -> None:
    """Print what the terminal's encoding lacks as a question mark instead of failing.

    Helps have frames and dots, and names of files may be in any encoding.
    """
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors == "strict":
        sys.stdout.reconfigure(errors="replace")


def _import(module: str) -> Any:
    """Import a module with all that it imports, and keep those objects from the collector."""
    with lasting():
        return importlib.import_module(module)


@contextlib.contextmanager
def lasting() -> Iterator[None]:
    """Exempt the objects made inside this context from garbage collection until the process ends.

    Use it for objects that live as long as the process, such as imported modules and the parts of a
    run. Otherwise the collector would look through a million objects of numba's again and again.
    That costs a tenth of a launch, and as much of every later collection.
    """
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def _end_interrupted() -> NoReturn:
    """End the process with status 130, whatever the interpreter noticed of the interrupt.

    The interpreter would end itself by SIGINT if KeyboardInterrupt passed through `exec`, which
    imports of dataclasses and named tuples call. Its own shutdown also takes up to half a second.
    """
    # Threads and processes that libraries have started end here.
    atexit._run_exitfuncs()
    with contextlib.suppress(OSError):
        sys.stdout.flush()
    with contextlib.suppress(OSError):
        sys.stderr.flush()
    os._exit(EXIT_INTERRUPTED)


def _leave(_number: int, _frame: FrameType | None) -> None:
    """End at once; nothing is open before a command runs, nor after it."""
    os._exit(EXIT_INTERRUPTED)
