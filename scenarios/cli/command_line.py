"""From the shell to a frozen configuration and back: parsing, errors in one line, exit status."""

from __future__ import annotations

import contextlib
import io
import re
import sys
from typing import Any, NoReturn

import tyro

EXIT_DONE = 0
EXIT_NEGATIVE = 1
EXIT_BAD_INPUT = 2
EXIT_INTERRUPTED = 130

# tyro frames its errors with lines or, where the terminal knows none, with ASCII.
_SIDES = " │|"
_RULE = re.compile(r"^[─-]{3,}$")
# Where a configuration refuses itself, tyro names the dataclass, which tells a user nothing.
_DATACLASS = re.compile(r"^Error parsing \w+: ")


def parse(command: Any, prog: str, args: list[str] | None = None) -> Any:
    """Parse a command line into the dataclass `command`, or into one of a union of them.

    Prints one line and exits with status 2 where the command line is malformed.
    """
    errors = io.StringIO()
    try:
        with contextlib.redirect_stderr(errors):
            return tyro.cli(
                command,
                prog=prog,
                args=args,
                config=(tyro.conf.FlagCreatePairsOff, tyro.conf.OmitArgPrefixes),
            )
    except SystemExit as stop:
        if stop.code == EXIT_BAD_INPUT:
            fail(prog, f"{_one_line(errors.getvalue())}; see {prog} --help")
        raise


def fail(prog: str, message: str) -> NoReturn:
    """Say in one line on standard error what was wrong, and exit with status 2."""
    sys.stderr.write(f"{prog}: error: {' '.join(message.split())}\n")
    sys.exit(EXIT_BAD_INPUT)


def _one_line(tyro_box: str) -> str:
    """What tyro says inside the first compartment of its error box, on one line."""
    lines = [line.strip(_SIDES) for line in tyro_box.splitlines()[1:-1]]
    if lines and _RULE.match(lines[0]):
        del lines[0]
    end = next((i for i, line in enumerate(lines) if _RULE.match(line)), len(lines))
    return _DATACLASS.sub("", " ".join(lines[:end]).strip().rstrip("."))
