"""Pilots that never fly, for what a campaign does about it."""

import os
import signal
import time
from pathlib import Path

from scenarios import Verdict


class Idle:
    """Is done before it begins."""

    area = None
    is_done = True
    verdict = Verdict(success=True, reason="stayed")

    def __init__(self, aboard):
        self.area = aboard.area

    def update(self, _):
        pass


class Slow(Idle):
    """Takes a little wall time, so that a campaign of it can be killed in the middle."""

    def __init__(self, aboard):
        super().__init__(aboard)
        time.sleep(0.3)


class Raising(Idle):
    def update(self, _):
        raise ZeroDivisionError("no\nway")


class Hanging(Idle):
    def update(self, _):
        time.sleep(600)


class Dying(Idle):
    def update(self, _):
        os.kill(os.getpid(), signal.SIGKILL)


class DyingOnce(Idle):
    """Dies in the first process that flies it, as the file says that `DYING_ONCE` names."""

    def update(self, _):
        mark = Path(os.environ["DYING_ONCE"])
        if not mark.exists():
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
