"""Batches of scenes that the grammar makes without end, ahead of the training.

    symbol  meaning
    k       step, from 0
    B       scenes of a batch
    R       uses of a scene, on average, before it is renewed
    P       scenes in the pool: as many as the first stretch has
    o_k     scenes that have left the pool before step k: floor(k B / R)

A network memorises a fixed set of scenes, while new ones cost little. The stream is the first
stretch (the training split that is there, which also fixes vocabulary and statistics) and, after
it, the training numbers beyond. Batch k is drawn from the P places o_k, ..., o_k + P - 1 of the
stream, so it depends on the seed and on k alone, whatever the number of workers. A scene with an
object of a kind that the first stretch lacks leaves its place empty.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from functools import partial
from itertools import islice
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, Self

from aeroscene.learning.training.batches.curation import (
    Encoder,
    Fresh,
    fresh_example,
    numbers_after,
    scene_file,
)
from aeroscene.learning.training.batches.source import Batch, Scenes, StoppedError, batch_generator
from aeroscene.learning.training.config import TrainCfg, TrainingError
from aeroscene.learning.training.journal import append_line, forget_after, read_log
from aeroscene.processes import WorkerDiedError, Workers

_AHEAD = 64
"""Scenes made before they are needed."""
_LEAST_SHARE = 0.5
"""Share of the pool that must hold scenes; with less the grammar has become another."""


class FirstStretch(Scenes, Protocol):
    """The scenes before the stream, whose statistics standardise those of the stream."""

    @property
    def examples(self) -> tuple[Any, ...]:
        """Examples of the scenes, in the order of their numbers."""
        ...

    def with_examples(self, examples: tuple[Any, ...]) -> Scenes:
        """Return other examples with the same vocabulary and statistics."""
        ...


class StreamedBatches:
    """Batches of a stream from a step on; closing it ends its workers."""

    def __init__(
        self,
        first: FirstStretch,
        encode: Encoder,
        last: int,
        cfg: TrainCfg,
        folder: Path,
        step: int,
        n_workers: int,
        wants_stop: Callable[[], bool] = lambda: False,
        *,
        stage: str = "stream",
        keeps_files: bool = False,
    ) -> None:
        """Start the workers.

        Args:
            first: The first stretch.
            encode: Scene to example of the same vocabulary and statistics.
            last: Number after which the stream continues.
            cfg: Size of a batch, uses of a scene, seed.
            folder: Folder of the training: its log, and files of the scenes in the pool.
            step: Step from which the training continues.
            n_workers: Number of processes.
            wants_stop: Asked while batches wait for scenes.
            stage: Name of the log's lines about the stream.
            keeps_files: True keeps files of scenes that have left the pool, for another part's
                stream.
        """
        self._first, self._cfg, self._folder, self._wants_stop = first, cfg, folder, wants_stop
        self._stage, self._keeps_files = stage, keeps_files
        self._size = len(first.examples)
        begin = self._place(step)
        # A resumed stream leaves out the scenes that had left the pool before.
        n_passed = max(0, begin - self._size)
        self._pool: deque[Fresh] = deque(Fresh(-1, each) for each in first.examples[begin:])
        self._end = begin + len(self._pool)
        self._step = step
        self._scenes: Scenes = first
        self._is_stale = True
        self._waited_s = 0.0
        self._begin_log(step)
        work = partial(fresh_example, encode, folder)
        numbers = islice(numbers_after(last), n_passed, None)
        self._fresh: Workers[int, Fresh] = Workers(work, numbers, n_workers, _AHEAD)

    def __call__(self, step: int) -> Batch:
        """Return the batch of a step.

        Raises:
            StoppedError: If the user wants the training to end.
            TrainingError: If a worker process was killed, or most scenes are of unknown kinds.
        """
        self._move_to(step)
        generator = batch_generator(self._cfg.seed, step)
        return self._scenes.sample_batch(self._cfg.batch_size, generator)

    def __enter__(self) -> Self:
        """Return the batches themselves."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the workers."""
        self._fresh.close()

    def figures(self, step: int) -> dict[str, float]:
        """Return the number of scenes used before a step, their mean uses, and the time waited."""
        n_scenes = self._place(max(0, step - 1)) + self._size
        return {
            "scenes": n_scenes,
            "skipped": self._n_skipped,
            "uses": round(step * self._cfg.batch_size / n_scenes, 2),
            "waited_s": round(self._waited_s, 1),
        }

    def _place(self, step: int) -> int:
        """Return o_k of a step."""
        return step * self._cfg.batch_size // self._cfg.scene_uses

    def _move_to(self, step: int) -> None:
        if step < self._step:
            raise ValueError(f"step is {step}; valid: from {self._step} on, the pool has gone by")
        end = self._place(step) + self._size
        while self._end < end:
            self._take(step)
        while len(self._pool) > self._size:
            self._drop(self._pool.popleft())
        self._step = step
        # Rebuilding the set takes time, so it happens only if the pool has changed.
        if self._is_stale:
            self._scenes = self._first.with_examples(self._examples())
            self._is_stale = False

    def _take(self, step: int) -> None:
        if self._wants_stop():
            raise StoppedError
        before_s = time.perf_counter()
        try:
            fresh = next(self._fresh)
        except WorkerDiedError:
            raise TrainingError(
                "a process that makes scenes was ended from outside (too little memory?); "
                "valid: fewer --workers; --resume goes on from the last save"
            ) from None
        self._waited_s += time.perf_counter() - before_s
        self._pool.append(fresh)
        self._end += 1
        self._is_stale = True
        if fresh.example is None and self._end > self._logged_to:
            self._n_skipped += 1
            line = {"stage": self._stage, "step": step + 1, "skipped": fresh.number}
            append_line(self._folder, line | {"reason": fresh.reason})

    def _drop(self, fresh: Fresh) -> None:
        self._is_stale = True
        # Scenes of the first stretch have number -1 and no file here.
        if fresh.number >= 0 and not self._keeps_files:
            scene_file(self._folder, fresh.number).unlink(missing_ok=True)

    def _examples(self) -> tuple[Any, ...]:
        found = tuple(each.example for each in self._pool if each.example is not None)
        if len(found) < _LEAST_SHARE * self._size:
            reasons = {each.reason for each in self._pool if each.example is None}
            raise TrainingError(
                f"stream has {len(found)} scenes of known kinds among {self._size} ({min(reasons)}"
                "); valid: a first stretch of more scenes, aeroscene dataset build --scenes 0:N"
            )
        return found

    def _begin_log(self, step: int) -> None:
        """Log the stream's settings; scenes skipped before the step are in the log already."""
        forget_after(self._folder, self._stage, step)
        self._n_skipped = sum(
            line.get("stage") == self._stage and "reason" in line for line in read_log(self._folder)
        )
        # Step `step` is not taken yet, so its own scenes are logged when it is.
        self._logged_to = self._place(step - 1) + self._size if step else 0
        line = {"stage": self._stage, "step": step, "scene_uses": self._cfg.scene_uses}
        append_line(self._folder, line | {"pool": self._size})
