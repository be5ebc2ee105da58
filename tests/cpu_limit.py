"""The limit of a test counts CPU time, so that a busy machine fails no test.

pytest-timeout reads the limits (`timeout` in pyproject.toml, `@pytest.mark.timeout`) and offers the
hook that this module answers. Wall time ends a test only if it takes so long that it must hang.
"""

import resource
import signal
import time
from typing import Any

import psutil
import pytest
from pytest_timeout import Settings, dump_stacks, is_debugging

WALL_PER_CPU = 5.0
"""Wall seconds that a test may take for each CPU second of its limit."""
SHORTEST_WAIT_S = 0.1
"""Between two looks at the clocks."""


def cpu_time_s(since_s: float) -> float:
    """CPU time of this process, of its children that ended, and of its newer descendants.

    Args:
        since_s: Unix time. Processes that are older belong to fixtures of earlier tests and are
            left out while they run.
    """
    measured_s = 0.0
    for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN):
        usage = resource.getrusage(who)
        measured_s += usage.ru_utime + usage.ru_stime
    for process in psutil.Process().children(recursive=True):
        try:
            if process.create_time() >= since_s:
                measured_s += sum(process.cpu_times()[:4])
        except psutil.Error:  # it ended meanwhile, and counts among the children that ended
            continue
    return measured_s


class Limit:
    """The clocks of one test, looked at by SIGALRM."""

    def __init__(self, item: pytest.Item, settings: Settings) -> None:
        self._item, self._settings = item, settings
        # The system rounds the time at which a process began to hundredths of a second.
        self._began_s = time.time() - 0.02
        self._wall_began_s = time.monotonic()
        own = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        self._cpu_before_s = sum(usage.ru_utime + usage.ru_stime for usage in own)

    def start(self) -> None:
        """Look for the first time when one busy thread would have used up the limit."""
        signal.signal(signal.SIGALRM, self._look)
        signal.setitimer(signal.ITIMER_REAL, self._settings.timeout)

    def stop(self) -> None:
        """Look no more."""
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)

    def _look(self, *_: Any) -> None:
        __tracebackhide__ = True
        cpu_s = cpu_time_s(self._began_s) - self._cpu_before_s
        wall_s = time.monotonic() - self._wall_began_s
        limit_s = self._settings.timeout
        left_s = min(limit_s - cpu_s, limit_s * WALL_PER_CPU - wall_s)
        if left_s > 0.0:
            signal.setitimer(signal.ITIMER_REAL, max(left_s, SHORTEST_WAIT_S))
            return
        if is_debugging() and not self._settings.disable_debugger_detection:
            return
        dump_stacks(self._item.config.get_terminal_writer())
        pytest.fail(
            f"over the limit of {limit_s:g} s of CPU time, or {limit_s * WALL_PER_CPU:g} s of wall "
            f"time: used {cpu_s:.1f} s of CPU time in {wall_s:.1f} s"
        )


def pytest_timeout_set_timer(item: pytest.Item, settings: Settings) -> bool:
    """Answer pytest-timeout's hook in place of its own timer."""
    limit = Limit(item, settings)
    item.cancel_timeout = limit.stop  # where it looks
    limit.start()
    return True
