"""A cached answer to a question that is asked often and may be a little old."""

from __future__ import annotations

import time
from collections.abc import Callable

_PERIOD_S = 0.1


class Lately:
    """Caches an answer for a tenth of a second of wall time.

    Asking a transport for its subscribers costs more than a tick should spend on each topic, and
    who subscribes changes seldom.
    """

    def __init__(self, ask: Callable[[], bool]) -> None:
        self._ask = ask
        self._due_s = 0.0
        self._answer = False

    def __call__(self) -> bool:
        """Return the answer, which is at most a tenth of a second old."""
        now_s = time.monotonic()
        if now_s >= self._due_s:
            self._due_s = now_s + _PERIOD_S
            self._answer = self._ask()
        return self._answer
