"""What a training has spent: FLOP, counted in some of its steps, and CPU seconds."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field

from torch.utils.flop_counter import FlopCounterMode

from aeroscene.learning.training.course import Watcher

_EVERY = 25
"""One step of so many is counted: counting makes a step half as long again."""


@dataclass
class Meter:
    """Watches a training for another watcher, and counts operations now and then.

    It is told after each step whether to go on, so the step that follows lies between two such
    calls. What is counted are multiplications and additions of matrix products, convolutions and
    attention, forwards and backwards.
    """

    watcher: Watcher
    counts: dict[str, list[int]] = field(default_factory=lambda: defaultdict(list))
    """FLOP of each step that was counted, by stage."""
    _stage: str = ""
    _n_seen: int = 0
    _mode: FlopCounterMode | None = None
    _begun_s: float = field(default_factory=time.process_time)

    def on_progress(self, stage: str, share: float, figures: Mapping[str, float]) -> None:
        """See `Watcher`."""
        self._stage = stage
        self.watcher.on_progress(stage, share, figures)

    def wants_stop(self) -> bool:
        """See `Watcher`."""
        self._leave()
        wants_stop = self.watcher.wants_stop()
        if not wants_stop and self._n_seen % _EVERY == 0:
            self._mode = FlopCounterMode(display=False)
            self._mode.__enter__()
        self._n_seen += 1
        return wants_stop

    def close(self) -> None:
        """Count no more; nothing is added for a step that did not end."""
        if self._mode is not None:
            self._mode.__exit__(None, None, None)
            self._mode = None

    @property
    def cpu_s(self) -> float:
        """CPU seconds of this process since the meter was made."""
        return time.process_time() - self._begun_s

    def flop(self, steps: Mapping[str, int]) -> float:
        """FLOP of so many steps of each stage, by those that were counted."""
        return sum(
            n * sum(self.counts[stage]) / len(self.counts[stage])
            for stage, n in steps.items()
            if self.counts.get(stage)
        )

    def _leave(self) -> None:
        if self._mode is not None:
            mode, self._mode = self._mode, None
            mode.__exit__(None, None, None)
            if mode.get_total_flops():
                self.counts[self._stage].append(mode.get_total_flops())
