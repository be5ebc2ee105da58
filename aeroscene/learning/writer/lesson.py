"""Programs as padded tensors: what is seen after each element, and what is right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from aeroscene.learning.skeleton.bucket import bucket
from aeroscene.learning.tokens.kinds import DOMAINS
from aeroscene.learning.tokens.skeleton import Wish
from aeroscene.learning.writer.growth import MAX_DEPTH, N_RECENT, Choice, Element, Growth

IGNORE = -100
"""Target where nothing is to be said."""
N_MEMBERS, N_HOSTS = 16, 32
N_SEEN = 12
"""Numbers that an element is told by."""
N_WISHES = 6


@dataclass(frozen=True)
class Lesson:
    """Elements of one program or of many; the targets are those of the token that comes next."""

    seen: Int[Tensor, "b t 12"]
    """Kind, kind of the parent, depth, place among siblings, whether it is a mark, member, host,
    array, coarse and fine objects left, how many too many, whether the part is fine."""
    kin: Bool[Tensor, "b t t"]
    """Which elements are above an element, or children of the same."""
    wish: Float[Tensor, "b 6"]
    depth: Int[Tensor, "b t"]
    """Depth of the next token, 0 for the end of the part."""
    above: Int[Tensor, "b t"]
    """Element that will be its parent."""
    recent: Int[Tensor, "b t recent"]
    """Kinds of the latest children there, the last one first; -1 where there is none."""
    n_siblings: Int[Tensor, "b t"]
    kind: Int[Tensor, "b t"]
    member: Int[Tensor, "b t"]
    host: Int[Tensor, "b t"]
    shape: Int[Tensor, "b t"]

    def to(self, device: torch.device) -> Lesson:
        """The same on a device."""
        return replace(self, **{f.name: getattr(self, f.name).to(device) for f in fields(self)})


def wish_numbers(wish: Wish) -> Float[np.ndarray, " 6"]:
    """A wish as numbers about one: the domain, and how much of each."""
    domain = np.eye(len(DOMAINS))[DOMAINS.index(wish.domain)]
    counts = np.log1p([wish.n_coarse, wish.n_fine, wish.n_areas])
    # 34 coarse objects, 114 fine ones and 56 areas are the means of the corpus.
    return np.concatenate([domain, 2 * counts - (7, 9.5, 8)]).astype(np.float32)


def seen_of(growth: Growth, element: Element) -> list[int]:
    """The numbers that an element is told by."""
    coarse, fine = element.left
    return [
        element.kind,
        growth.elements[element.parent].kind,
        min(element.depth, MAX_DEPTH - 1),
        min(element.ordinal, 63),
        int(element.is_mark),
        min(element.member, N_MEMBERS - 1),
        min(element.host, N_HOSTS - 1),
        element.shape,
        max(coarse, 0),
        max(fine, 0),
        max(-coarse, 0) + max(-fine, 0),
        0,
    ]


def recent_of(growth: Growth, above: int) -> tuple[list[int], int]:
    """Kinds of the latest children of an element, and how many it has."""
    children = growth.elements[above].children
    recent = children[-N_RECENT:][::-1]
    return recent + [-1] * (N_RECENT - len(recent)), len(children)


def lesson_of(growth: Growth, said: Sequence[tuple[int, Choice | None]], wish: Wish) -> Lesson:
    """The lesson of one grown program, as a batch of one."""
    elements = growth.elements
    n = len(elements)
    seen = np.array([seen_of(growth, each) for each in elements])
    is_mark = np.array([each.is_mark for each in elements])
    seen[:, 11] = np.maximum.accumulate(is_mark)
    seen[:, 8:11] = bucket(seen[:, 8:11])
    kin = kin_of(np.array([each.parent for each in elements]))
    depth = np.array([each for each, _ in said])
    targets = np.full((4, n), IGNORE)
    above = np.zeros(n, dtype=np.int64)
    recent = np.full((n, N_RECENT), -1)
    n_siblings = np.zeros(n, dtype=np.int64)
    path: list[int] = [0]
    children = [each.children[: each.n_given] for each in elements]
    for i, each in enumerate(elements):
        if each.is_mark:
            path = [i]
        elif i:
            path[each.depth :] = [i]
        step, choice = said[i]
        if choice is None:
            continue
        above[i] = path[step - 1]
        below = children[above[i]]
        some = below[-N_RECENT:][::-1]
        recent[i, : len(some)] = some
        n_siblings[i] = len(below)
        below.append(choice.kind)
        targets[:, i] = _targets(choice)
    return Lesson(
        seen=torch.from_numpy(seen)[None],
        kin=torch.from_numpy(kin)[None],
        wish=torch.from_numpy(wish_numbers(wish))[None],
        depth=torch.from_numpy(depth)[None],
        above=torch.from_numpy(above)[None],
        recent=torch.from_numpy(recent)[None],
        n_siblings=torch.from_numpy(bucket(n_siblings))[None],
        **{
            name: torch.from_numpy(row)[None]
            for name, row in zip(("kind", "member", "host", "shape"), targets, strict=True)
        },
    )


def _targets(choice: Choice) -> tuple[int, int, int, int]:
    member, host = min(choice.member, N_MEMBERS - 1), min(choice.host, N_HOSTS - 1)
    return choice.kind, member, host, choice.shape


def kin_of(parent: Int[np.ndarray, " t"]) -> Bool[np.ndarray, "t t"]:
    """Which elements are above each, itself included, or its earlier siblings."""
    kin = np.eye(len(parent), dtype=bool)
    for i in range(1, len(parent)):
        kin[i] |= kin[parent[i]]
        kin[i, 1:i] |= parent[1:i] == parent[i]
    return kin


def batched(lessons: Sequence[Lesson]) -> Lesson:
    """Lessons padded to one length; padding says nothing and sees itself alone."""
    n = max(lesson.seen.shape[1] for lesson in lessons)

    def padded(name: str, value: int) -> Tensor:
        parts = [getattr(lesson, name)[0] for lesson in lessons]
        found = parts[0].new_full((len(parts), n, *parts[0].shape[1:]), value)
        for row, part in enumerate(parts):
            found[row, : len(part)] = part
        return found

    kin = torch.eye(n, dtype=torch.bool).repeat(len(lessons), 1, 1)
    for row, lesson in enumerate(lessons):
        size = lesson.kin.shape[1]
        kin[row, :size, :size] = lesson.kin[0]
    said = ("depth", "kind", "member", "host", "shape")
    return Lesson(
        kin=kin,
        wish=torch.cat([lesson.wish for lesson in lessons]),
        recent=padded("recent", -1),
        **{name: padded(name, 0) for name in ("seen", "above", "n_siblings")},
        **{name: padded(name, IGNORE) for name in said},
    )
