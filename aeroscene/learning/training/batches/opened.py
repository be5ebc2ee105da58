"""The batches of a training, open while it runs, and closed at its end."""

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
    """Batches, and their stream if there is one."""

    batches: Batches
    stream: StreamedBatches | None


@dataclass(frozen=True, kw_only=True)
class Supply:
    """Source of the batches of a part."""

    scenes: FirstStretch
    """The scenes that are there from the start."""
    encode: Encoder
    last_number: int | None
    """Number after which the grammar continues; None without a stream."""
    folder: Path
    """Folder of the training."""
    n_workers: int
    stage: str
    """Name of the part."""
    is_last: bool
    """True if no other part will need the same scenes."""


@contextmanager
def open_batches(
    supply: Supply, cfg: TrainCfg, device: torch.device, step: int, wants_stop: Callable[[], bool]
) -> Iterator[OpenBatches]:
    """Open batches from a step on, and close them at the end of the block.

    On a GPU a thread makes them ahead of the training.

    Args:
        supply: Source of the batches.
        cfg: Size of a batch, uses of a scene, seed.
        device: Device that computes.
        step: Step from which the training continues.
        wants_stop: Asked while batches wait for scenes.
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
            # The stack closes the thread before the stream that it reads.
            batches = stack.enter_context(Prefetched(batches, device))
        yield OpenBatches(batches, stream)


def stream_stage(part: str) -> str:
    """Return the name of the log's lines about the stream of a part."""
    return f"stream of {part}"
