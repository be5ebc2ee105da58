"""Batches that a thread makes ahead of the training, and puts on its device."""

from __future__ import annotations

from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from types import TracebackType
from typing import Self

import torch

from aeroscene.learning.training.batches.source import Batch, Batches

_AHEAD = 2
"""Batches ahead: one that is being made while one waits."""


class Prefetched:
    """The same batches, made while the device computes; closing it ends the thread."""

    def __init__(self, batches: Batches, device: torch.device) -> None:
        self._batches = batches
        self._device = device
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="batches")
        self._pending: deque[tuple[int, Future[Batch]]] = deque()

    def __call__(self, step: int) -> Batch:
        """Return the batch of a step on the device; raises what making it raises."""
        # Another step than expected: batches that were made ahead are of no use.
        if not self._pending or self._pending[0][0] != step:
            self._pending.clear()
        begin = self._pending[-1][0] + 1 if self._pending else step
        for number in range(begin, step + _AHEAD + 1):
            self._pending.append((number, self._thread.submit(self._made, number)))
        return self._pending.popleft()[1].result()

    def __enter__(self) -> Self:
        """Return the batches themselves."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the thread, after the batch that it is making."""
        # Wait, because a stream under the thread must not be closed while it is read.
        self._thread.shutdown(wait=True, cancel_futures=True)

    def _made(self, step: int) -> Batch:
        batch = self._batches(step)
        if self._device.type == "cuda":
            return batch.pinned().to(self._device, non_blocking=True)
        return batch.to(self._device)
