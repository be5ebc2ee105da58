"""Errors of this program in answering a client: counted and reported, and none ends the flight."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import PurePath
from types import TracebackType

_MOST_TOLD = 64
"""Most distinct faults that are reported. A program has few, and no client can make this grow."""


class Faults:
    """Context that ends only the piece of work in which it fails.

    The same object guards one piece of work after the other: a message, a stream, a transfer. It
    catches errors of this program, because merely wrong input is refused before.

    Attributes:
        n_caught: Number of pieces of work that failed.
        last: The latest error in one line; None if there was none.
        has_failed: True if the latest piece of work failed.
    """

    def __init__(self, tell: Callable[[str], None]) -> None:
        """Guard work from now on.

        Args:
            tell: Gets one line for each distinct fault.
        """
        self.n_caught = 0
        self.last: str | None = None
        self.has_failed = False
        self._tell = tell
        self._told: set[tuple[int, ...]] = set()

    def attempt(self, work: Callable[[], None]) -> None:
        """Do a piece of work, guarded like any other; for work of each tick.

        An error is caught and reported, so that the flight goes on.

        Args:
            work: Function to call.
        """
        try:
            work()
        except Exception as error:  # noqa: BLE001 - whatever it is, the flight goes on
            self._catch(error)

    def __enter__(self) -> None:
        self.has_failed = False

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        _trace: TracebackType | None,
    ) -> bool:
        # Interrupts and exits are no errors: they must end the run.
        if not isinstance(error, Exception):
            return False
        self._catch(error)
        return True

    def _catch(self, error: Exception) -> None:
        self.has_failed = True
        self.n_caught += 1
        # The line numbers of the whole trace name the fault: the same line may fail by two callers.
        lines, file, trace = [], "", error.__traceback__
        while trace is not None:
            lines.append(trace.tb_lineno)
            file = PurePath(trace.tb_frame.f_code.co_filename).name
            trace = trace.tb_next
        what = " ".join(str(error).split())
        module = "" if type(error).__module__ == "builtins" else f"{type(error).__module__}."
        self.last = f"{module}{type(error).__name__} in {file}:{lines[-1]}: {what}"
        way = tuple(lines)
        if way not in self._told and len(self._told) < _MOST_TOLD:
            self._told.add(way)
            self._tell(f"MAVLink fault, a message is lost: {self.last}")
