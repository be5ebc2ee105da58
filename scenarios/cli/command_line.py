"""From the shell to a frozen configuration and back: parsing, errors in one line, exit status."""

from __future__ import annotations

import contextlib
import io
import json
import logging
import math
import re
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from types import FrameType
from typing import Any, NoReturn

import tyro

from aeroscene.files.visible import visible
from scenarios.cli.boundary import one_line
from scenarios.cli.entry import EXIT_INTERRUPTED
from scenarios.cli.help_text import flow_help
from scenarios.cli.option_faults import option_faults

EXIT_DONE = 0
EXIT_NEGATIVE = 1
EXIT_BAD_INPUT = 2

_CONFIG = (tyro.conf.FlagCreatePairsOff, tyro.conf.OmitArgPrefixes, tyro.conf.DisallowNone)
# tyro frames its errors with lines or, where the terminal knows none, with ASCII.
_SIDES = " │|"
_RULE = re.compile(r"^[─-]{3,}$")
_IN_OUR_WORDS = (
    (r"Error parsing (?:--)?(\S+): no type matching (\S+) .* from \[(.*?)\].*", r"\1 \3", r"\2"),
    (r"Error parsing (?:--)?(\S+): could not convert .*: (.*)", r"\1 \2", "FLOAT"),
    (r"Error parsing (?:--)?(\S+): invalid literal for int.*: (.*)", r"\1 \2", "INT"),
    (r"invalid choice (.*) for argument '(?:--)?(\S+)'\. .* \((.*)\)", r"\2 \1", r"\3"),
    (r"Missing value for argument '(--\S+)'.*", r"\1 has no value", ""),
    (r"Missing from [\w -]+: (\S+) .*", r"\1 is missing", ""),
    (r"Unrecognized(?: or misplaced)? options: (\S+?)(?:,| \(| |$).*", r"\1 is unknown", ""),
    # Where a configuration refuses itself, tyro names the dataclass, which tells a user nothing.
    (r"Error parsing \w+: (.*)", r"\1", ""),
)
"""Pattern of tyro's message, our message, and the valid values in it."""
_COMMAND_WANTED = re.compile(r"Expected one of \{([^}]*)\}")
_MOST_CHARACTERS = 2000
"""Longest error: a name or a value from a file may be as long as the file."""
_interrupts: list[int] = []
"""Signals that `interrupt` has raised for."""
_INSIST_S = 0.2
"""Time that an interrupt has to end the command, or to begin closing what is open."""
_KINDS = {"FLOAT": "a number", "INT": "a whole number"}


def execute(
    command: Any, run: Callable[[Any], int], prog: str, args: list[str] | None = None
) -> int:
    """Parse a command line and run the command.

    Returns:
        The exit status; input that cannot be used ends the process with one line and status 2.
    """
    # Without a home folder it would report at length where its list of fonts goes instead.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    shown = logging.StreamHandler(sys.stderr)
    shown.setFormatter(_VisibleFormatter(f"{prog}: %(message)s"))
    logging.basicConfig(level=logging.WARNING, handlers=[shown])
    cfg = parse(command, prog, args)
    # From here on there may be files and ports to close.
    before = signal.signal(signal.SIGINT, interrupt)
    hook_before, sys.unraisablehook = sys.unraisablehook, _tell_unless_interrupt
    try:
        return _run_within_boundary(prog, lambda: run(cfg))
    except KeyboardInterrupt:
        interrupt_is_answered()
        return EXIT_INTERRUPTED
    finally:
        interrupt_is_answered()
        signal.signal(signal.SIGINT, before)
        sys.unraisablehook = hook_before


def _tell_unless_interrupt(unraisable: sys.UnraisableHookArgs) -> None:
    """Print an error that a callback or a destructor could not raise, unless it is an interrupt.

    Python would print the KeyboardInterrupt of such a place as a fault. `interrupt` raises it again
    elsewhere, so nothing is lost.
    """
    if not issubclass(unraisable.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(unraisable)


def _run_within_boundary(prog: str, run: Callable[[], int]) -> int:
    """Run a command; an error of files or of the machine ends it with one line and status 2."""
    try:
        return run()
    except BrokenPipeError:
        raise  # The reader of our output has closed the pipe: no fault.
    except Exception as error:
        raise_if_interrupted()  # A library made an exception of its own of it.
        if (line := one_line(error)) is None:
            raise
        fail(prog, line)


def interrupt(number: int, _: FrameType | None = None) -> NoReturn:
    """Raise KeyboardInterrupt for a signal, again and again until the command ends because of it.

    Libraries swallow it: trimesh, for example, catches BaseException in 144 places, and an export
    that lost its Ctrl-C there ran to its end.
    """
    _interrupts.append(number)
    signal.signal(signal.SIGALRM, _insist)
    signal.setitimer(signal.ITIMER_REAL, _INSIST_S, _INSIST_S)
    raise KeyboardInterrupt


def _insist(_number: int, _frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt, unless files and processes are being closed because of an earlier.

    The error that a `finally`, an `except` or an `__exit__` handles is the present one to a signal
    handler, too.
    """
    error = sys.exception()
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return
        error = error.__context__
    raise KeyboardInterrupt


def interrupt_is_answered() -> None:
    """Forget an interrupt: the command has ended because of it, or needs not end."""
    if _interrupts:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        _interrupts.clear()


def raise_if_interrupted() -> None:
    """Raise KeyboardInterrupt again where a library has swallowed it.

    Callbacks, destructors and imports of compiled libraries do: 2 of 50 tries with Ctrl-C in the
    first three seconds of a run flew on.
    """
    if _interrupts:
        raise KeyboardInterrupt


class _VisibleFormatter(logging.Formatter):
    """Writes out what a terminal would obey in the names of a message, line by line."""

    def format(self, record: logging.LogRecord) -> str:
        return "\n".join(map(visible, super().format(record).split("\n")))


def parse(command: Any, prog: str, args: list[str] | None = None, description: str = "") -> Any:
    """Parse a command line into the dataclass `command`, or into one of a union of them.

    Prints one line and exits with status 2 where the command line is malformed, a number is out of
    its range, or an output cannot be written; prints the help and exits with status 0 where it is
    empty and a command is wanted.
    """
    args = sys.argv[1:] if args is None else args
    if not {"-h", "--help"}.isdisjoint(args):
        flow_help(command)
    errors = io.StringIO()
    try:
        with contextlib.redirect_stderr(errors):
            cfg = tyro.cli(
                command, prog=prog, args=args, description=description or None, config=_CONFIG
            )
    except SystemExit as stop:
        if stop.code != EXIT_BAD_INPUT:
            raise
        if not args and _COMMAND_WANTED.search(errors.getvalue()):
            return parse(command, prog, ["--help"], description)
        typed = _typed(command, prog, args)
        return fail(typed, _one_line(errors.getvalue(), typed))
    for fault in option_faults(cfg):
        fail(_typed(command, prog, args), fault)
    return cfg


def _typed(command: Any, prog: str, args: list[str]) -> str:
    """The program's name with the subcommand that was typed, where there is one."""
    return f"{prog} {args[0]}" if args and args[0] in _subcommands(command) else prog


def _subcommands(command: Any) -> set[str]:
    """Names of which tyro expects one after the program's."""
    errors = io.StringIO()
    with contextlib.redirect_stderr(errors), contextlib.suppress(SystemExit):
        tyro.cli(command, args=[], config=_CONFIG)
    wanted = _COMMAND_WANTED.search(errors.getvalue())
    return set(re.findall(r"[\w-]+", wanted[1])) if wanted else set()


def default_hint(says: str, metavar: str | None = None) -> Any:
    """Text of the default in the help of an option whose own default tells a user nothing."""
    return tyro.conf.arg(help_behavior_hint=f"(default: {says})", metavar=metavar)


def fail(prog: str, message: str) -> NoReturn:
    """Say in one line on standard error what was wrong, and exit with status 2."""
    line = visible(" ".join(message.split()))
    if len(line) > _MOST_CHARACTERS:
        line = f"{line[:_MOST_CHARACTERS]}..."
    sys.stderr.write(f"{prog}: error: {line}\n")
    sys.exit(EXIT_BAD_INPUT)


@contextlib.contextmanager
def handling_signals(handler: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    """Handle SIGINT and SIGTERM with a handler; afterwards restore the earlier ones."""
    before = {number: signal.signal(number, handler) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)


def print_json(facts: Mapping[str, Any]) -> None:
    """Print one object on standard output; figures keep four digits and three decimals."""
    print(json.dumps(_rounded(facts)), flush=True)


def _rounded(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {name: _rounded(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_rounded(item) for item in value]
    if isinstance(value, float) and math.isfinite(value) and value:
        return round(value, max(3, 3 - math.floor(math.log10(abs(value)))))
    return value


def _one_line(tyro_box: str, prog: str) -> str:
    """Content of tyro's error box in one line: the fault, a suggestion, and where help is."""
    compartments: list[list[str]] = [[]]
    for line in tyro_box.splitlines()[1:-1]:
        text = line.strip(_SIDES)
        if _RULE.match(text):
            compartments.append([])
        elif text:
            compartments[-1].append(text)
    first, *others = (" ".join(lines) for lines in compartments if lines)
    said = _in_our_words(first.rstrip("."))
    for other in others:
        if match := re.match(r"Available subcommands: (.*)", other):
            said += f"; valid: {match[1]}"
        elif match := re.match(r"(?:Perhaps you meant|Arguments similar to \S+): (--\S+)", other):
            said += f"; perhaps {match[1]}"
    return f"{said}; see {prog} --help"


def _in_our_words(said: str) -> str:
    for pattern, words, valid in _IN_OUR_WORDS:
        if match := re.fullmatch(pattern, said):
            choices = re.findall(r"[^{}|,' ]+", match.expand(valid))
            named = ", ".join(
                str(_KINDS.get(choice, choice)) for choice in choices if choice != "None"
            )
            return match.expand(words) + (f" is not valid; valid: {named}" if named else "")
    return said
