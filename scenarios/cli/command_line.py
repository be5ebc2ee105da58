"""From the shell to a frozen configuration and back: parsing, errors in one line, exit status.

tyro parses a command line into a dataclass, and prints its errors as framed boxes of several lines.
Scripts and logs read single lines better, so `parse` catches each box and rewrites it as one line
that names the option, the value and what would be valid. The module also makes Ctrl-C reliable.
Python's own KeyboardInterrupt gets lost where a library catches every exception, so `interrupt`
raises it again until the command ends.
"""

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
EXIT_NEGATIVE = 1  # The command worked and its answer is no: a failed flight, a missed target.
EXIT_BAD_INPUT = 2

# One flag for each switch without a twin, `--speed` for `--bench.speed`, and no value "None".
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

    Args:
        command: Dataclass of the options, or a union of such.
        run: Function of the parsed options that does the work and returns the exit status.
        prog: Command that names itself in errors and `--help`.
        args: Words of the command line; None takes those of the process.

    Returns:
        The exit status; input that cannot be used ends the process with one line and status 2.
    """
    # Without a home folder, matplotlib would report at length where it puts its list of fonts.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    shown = logging.StreamHandler(sys.stderr)
    shown.setFormatter(_VisibleFormatter(f"{prog}: %(message)s"))
    logging.basicConfig(level=logging.WARNING, handlers=[shown])
    cfg = parse(command, prog, args)
    # From here on there may be files and ports to close, so Ctrl-C must unwind the stack. Before
    # this line `entry._leave` ends the process at once.
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
    """Run a command; an error of a file or of the machine ends it with one line and status 2."""
    try:
        return run()
    except BrokenPipeError:
        raise  # The reader of our output has closed the pipe: no fault.
    except Exception as error:
        raise_if_interrupted()  # A library may have turned the interrupt into its own exception.
        if (line := one_line(error)) is None:
            raise
        fail(prog, line)


def interrupt(number: int, _: FrameType | None = None) -> NoReturn:
    """Raise KeyboardInterrupt for a signal, again and again until the command ends because of it.

    Libraries swallow it: trimesh, for example, catches BaseException in 144 places, and an export
    that lost its Ctrl-C there ran to its end.
    """
    _interrupts.append(number)
    # An interval timer keeps firing even if the present exception is swallowed.
    signal.signal(signal.SIGALRM, _insist)
    signal.setitimer(signal.ITIMER_REAL, _INSIST_S, _INSIST_S)
    raise KeyboardInterrupt


def _insist(_number: int, _frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt, unless an earlier one is closing files and processes already.

    A signal handler sees the exception that the interrupted `finally`, `except` or `__exit__`
    handles as the present one. A KeyboardInterrupt in its chain means that closing is under way.
    """
    error = sys.exception()
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return
        error = error.__context__
    raise KeyboardInterrupt


def interrupt_is_answered() -> None:
    """Forget an interrupt, and stop raising it again.

    Call this once the command has ended because of it, or need not end: for example, when Ctrl-C
    only closes a viewer.
    """
    if _interrupts:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        _interrupts.clear()


def raise_if_interrupted() -> None:
    """Raise KeyboardInterrupt again if a library has swallowed it.

    Callbacks, destructors and imports of compiled libraries swallow it. Without this call, 2 of 50
    runs that got Ctrl-C in their first three seconds flew on.

    Raises:
        KeyboardInterrupt: If `interrupt` has raised, and nothing has answered it yet.
    """
    if _interrupts:
        raise KeyboardInterrupt


class _VisibleFormatter(logging.Formatter):
    """Shows control characters in a message as text, because names come from files of others."""

    def format(self, record: logging.LogRecord) -> str:
        return "\n".join(map(visible, super().format(record).split("\n")))


def parse(command: Any, prog: str, args: list[str] | None = None, description: str = "") -> Any:
    """Parse a command line into the dataclass `command`, or into one of a union of them.

    Args:
        command: Dataclass of the options, or a union of such.
        prog: Command that names itself in errors and `--help`.
        args: Words of the command line; None takes those of the process.
        description: First paragraph of the help; empty takes the dataclass's docstring.

    Returns:
        The parsed options.

    Raises:
        SystemExit: With status 2 and one line if the command line is malformed, a number is out of
            its range, or an output cannot be written. With status 0 after the help, if `--help` is
            asked for or the line is empty and a command is needed.
    """
    args = sys.argv[1:] if args is None else args
    if not {"-h", "--help"}.isdisjoint(args):
        flow_help(command)
    # tyro prints its box and exits. The box is caught, to be rewritten as one line.
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
    """Return the program's name, with the subcommand that was typed if there is one."""
    return f"{prog} {args[0]}" if args and args[0] in _subcommands(command) else prog


def _subcommands(command: Any) -> set[str]:
    """Return the names of the subcommands, empty for a command that has none."""
    # tyro has no public list of them; its complaint about an empty command line has one.
    errors = io.StringIO()
    with contextlib.redirect_stderr(errors), contextlib.suppress(SystemExit):
        tyro.cli(command, args=[], config=_CONFIG)
    wanted = _COMMAND_WANTED.search(errors.getvalue())
    return set(re.findall(r"[\w-]+", wanted[1])) if wanted else set()


def default_hint(says: str, metavar: str | None = None) -> Any:
    """Return a tyro mark that sets the text of an option's default in `--help`.

    It serves options whose own default explains nothing, such as None or an empty text.

    Args:
        says: Words after "default: ", such as "the campaign's".
        metavar: Placeholder of the value; None keeps tyro's.
    """
    return tyro.conf.arg(help_behavior_hint=f"(default: {says})", metavar=metavar)


def fail(prog: str, message: str) -> NoReturn:
    """Print one line on standard error and exit with status 2.

    Args:
        prog: Command that names itself at the start of the line.
        message: Fault and what would be valid. Line breaks become spaces, control characters become
            visible, and everything after 2,000 characters is cut.
    """
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
    """Print one JSON object on one line of standard output.

    Floats are rounded to three decimals, or to four significant digits where that keeps more. For
    example, 0.000123456 becomes 0.0001235 and 12.34567 becomes 12.346.
    """
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
    """Return the content of tyro's error box as one line: the fault, a suggestion, where help is.

    Args:
        tyro_box: Output of tyro, with frame.
        prog: Command whose `--help` the line names.
    """
    # The first and the last line are the frame; horizontal rules part it into compartments.
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
    # A message that no pattern knows, as after an update of tyro, is printed as it is.
    for pattern, words, valid in _IN_OUR_WORDS:
        if match := re.fullmatch(pattern, said):
            choices = re.findall(r"[^{}|,' ]+", match.expand(valid))
            named = ", ".join(
                str(_KINDS.get(choice, choice)) for choice in choices if choice != "None"
            )
            return match.expand(words) + (f" is not valid; valid: {named}" if named else "")
    return said
