"""Lessons of the writer as padded tensors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from aeroscene.learning.writer.lesson import IGNORE, Lesson


@dataclass(frozen=True)
class LessonBatch:
    """Lessons of several programs, see `Lesson`.

    Padding has no targets, and attends to itself alone.
    """

    seen: Int[Tensor, "b t 12"]
    kin: Bool[Tensor, "b t t"]
    wish: Float[Tensor, "b 6"]
    depth: Int[Tensor, "b t"]
    above: Int[Tensor, "b t"]
    recent: Int[Tensor, "b t recent"]
    n_siblings: Int[Tensor, "b t"]
    kind: Int[Tensor, "b t"]
    member: Int[Tensor, "b t"]
    host: Int[Tensor, "b t"]
    shape: Int[Tensor, "b t"]

    def to(self, device: torch.device | str, *, non_blocking: bool = False) -> LessonBatch:
        """Copy the batch to another device."""
        return self._with_each(lambda value: value.to(device, non_blocking=non_blocking))

    def pinned(self) -> LessonBatch:
        """Copy the batch to page-locked memory, which a GPU reads while the processor goes on."""
        return self._with_each(lambda value: value.pin_memory())

    def _with_each(self, change: Callable[[Tensor], Tensor]) -> LessonBatch:
        return replace(
            self, **{each.name: change(getattr(self, each.name)) for each in fields(self)}
        )


_PADDING = {
    "seen": 0,
    "above": 0,
    "n_siblings": 0,
    # -1 selects the vector of "no kind".
    "recent": -1,
    "depth": IGNORE,
    "kind": IGNORE,
    "member": IGNORE,
    "host": IGNORE,
    "shape": IGNORE,
}


def lesson_batch(lessons: Sequence[Lesson]) -> LessonBatch:
    """Pad lessons to the length of the longest one."""
    n = max(map(len, lessons))
    # Every element sees itself, padding too: a row without any key would give NaN.
    kin = torch.eye(n, dtype=torch.bool).repeat(len(lessons), 1, 1)
    for row, lesson in enumerate(lessons):
        kin[row, : len(lesson), : len(lesson)] = torch.from_numpy(lesson.kin)
    wish = torch.stack([torch.from_numpy(lesson.wish) for lesson in lessons])
    padded = {name: _padded(lessons, name, n, value) for name, value in _PADDING.items()}
    return LessonBatch(kin=kin, wish=wish, **padded)


def _padded(lessons: Sequence[Lesson], name: str, n: int, value: int) -> Tensor:
    parts = [torch.from_numpy(getattr(lesson, name)) for lesson in lessons]
    found = parts[0].new_full((len(parts), n, *parts[0].shape[1:]), value)
    for row, part in enumerate(parts):
        found[row, : len(part)] = part
    return found
