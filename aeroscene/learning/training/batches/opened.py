"""The batches of a training, ready to be drawn, and closed at its end."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import torch

from aeroscene.learning.training.batches.curation import Encoder
from aeroscene.learning.training.batches.prefetch import Prefetched
from aeroscene.learning.training.batches.source import Batches, drawn_from
from aeroscene.learning.training.batches.stream import FirstStretch, StreamedBatches
from aeroscene.learning.training.config import TrainCfg


@dataclass(frozen=True)
class OpenBatches:
    """Batches, and the stream that they come from where there is one."""

    batches: Batches
    stream: StreamedBatches | None


@dataclass(frozen=True, kw_only=True)
class Supply:
    """Where the batches of a part come from."""

    scenes: FirstStretch
    """The scenes that there are."""
    encode: Encoder
    last_number: int | None
    """Number after which the grammar goes on; None where it does not."""
    folder: Path
    """Folder of the training."""
    n_workers: int
    stage: str
    """Name of the part."""
    is_last: bool
    """Whether no other part will ask for the same scenes."""


@contextmanager
def open_batches(
    supply: Supply, cfg: TrainCfg, device: torch.device, step: int, wants_stop: Callable[[], bool]
) -> Iterator[OpenBatches]:
    """Batches from a step on; a thread makes them ahead where another device computes.

    Other arguments are those of `StreamedBatches`.
    """
    with ExitStack() as stack:
        stream = None
        batches = drawn_from(supply.scenes, cfg.batch_size, cfg.seed)
        if supply.last_number is not None:
            stream = stack.enter_context(
                StreamedBatches(
                    supply.scenes,
                    supply.encode,
                    supply.last_number,
                    cfg,
                    supply.folder,
                    step,
                    supply.n_workers,
                    wants_stop,
                    stage=stream_stage(supply.stage),
                    keeps_files=not supply.is_last,
                )
            )
            batches = stream
        if device.type != "cpu":
            batches = stack.enter_context(Prefetched(batches, device))
        yield OpenBatches(batches, stream)


def stream_stage(part: str) -> str:
    """Name of the log's lines about the stream of a part."""
    return f"stream of {part}"
