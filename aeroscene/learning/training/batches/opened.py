"""The batches of a training, ready to be drawn, and closed at its end."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import torch

from aeroscene.learning.training.batches.prefetch import Prefetched
from aeroscene.learning.training.batches.source import Batches, drawn_from
from aeroscene.learning.training.batches.stream import StreamedBatches
from aeroscene.learning.training.config import TrainCfg
from aeroscene.learning.training.data import TrainingData


@dataclass(frozen=True)
class OpenBatches:
    """Batches, and the stream that they come from where there is one."""

    batches: Batches
    stream: StreamedBatches | None


@contextmanager
def open_batches(
    data: TrainingData,
    cfg: TrainCfg,
    device: torch.device,
    folder: Path,
    step: int,
    n_workers: int,
    wants_stop: Callable[[], bool],
) -> Iterator[OpenBatches]:
    """Batches from a step on; a thread makes them ahead where another device computes.

    Arguments are those of `StreamedBatches`.
    """
    with ExitStack() as stack:
        stream = None
        batches = drawn_from(data.train, cfg.batch_size, cfg.seed)
        if data.last_number is not None:
            stream = stack.enter_context(
                StreamedBatches(
                    data.train,
                    data.train.encoder,
                    data.last_number,
                    cfg,
                    folder,
                    step,
                    n_workers,
                    wants_stop,
                )
            )
            batches = stream
        if device.type != "cpu":
            batches = stack.enter_context(Prefetched(batches, device))
        yield OpenBatches(batches, stream)
