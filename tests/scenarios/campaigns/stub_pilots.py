"""Pilots that never fly, for what a campaign does about it."""

import os
import signal
import sys
import time
from pathlib import Path

import numpy as np

from aeroscene.scene import SceneError
from flightsim.world import WorldError
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


class Leaving(Idle):
    def update(self, _):
        os._exit(0)


class Troubled(Idle):
    """With an Iris it takes memory without end, with a Hummingbird it talks and then ends."""

    def update(self, _):
        if self.vehicle == "iris":
            machine_bytes = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
            hoard = [np.empty(1 << 28, np.uint8) for _ in range(2 * machine_bytes >> 28)]
            assert hoard
        sys.stdout.write("blah " * (1 << 20))
        sys.exit("enough")

    def __init__(self, aboard):
        super().__init__(aboard)
        self.vehicle = aboard.airframe.name


class RaisingOurs(Idle):
    """Raises what the testbench raises where a scene has no task, or a machine cannot fly."""

    errors = iter((WorldError("mine"), SceneError("mine")))

    def update(self, _):
        raise next(self.errors)


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
