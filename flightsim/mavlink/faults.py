"""Faults of our own in answering a client: each is counted and told once, none ends the flight."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import PurePath
from types import TracebackType

_MOST_TOLD = 64
"""Ways to a fault that are told; a program has few, and no client can make this grow."""


class Faults:
    """Context that ends what is done for one client where it fails, and nothing else.

    The same object guards one piece of work after the other: a message, a stream, a transfer. What
    it catches is an error of this program, for input that is merely wrong is refused before.

    Attributes:
        n_caught: Number of pieces of work that failed.
        last: The latest of them in one line; None if there was none.
        has_failed: Whether the latest piece of work failed.
    """

    def __init__(self, tell: Callable[[str], None]) -> None:
        """Guard work from now on; `tell` gets one line for each way in which the program fails."""
        self.n_caught = 0
        self.last: str | None = None
        self.has_failed = False
        self._tell = tell
        self._told: set[tuple[int, ...]] = set()

    def attempt(self, work: Callable[[], None]) -> None:
        """Do a piece of work, guarded like any other; for what is done in each tick."""
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
        if not isinstance(error, Exception):
            return False
        self._catch(error)
        return True

    def _catch(self, error: Exception) -> None:
        self.has_failed = True
        self.n_caught += 1
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
