"""Programs as arrays: what is seen after each element, and what is right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.learning.program.program import N_HOSTS, N_MEMBERS
from aeroscene.learning.wishes import Wish
from aeroscene.learning.writer.bucket import bucket
from aeroscene.learning.writer.growth import MAX_DEPTH, N_RECENT, Choice, Element, Growth
from aeroscene.scene import DOMAINS

IGNORE = -100
"""Target where nothing is to be said."""
N_WISHES = 6


@dataclass(frozen=True, eq=False)
class Lesson:
    """Elements of a program; the targets are those of the token that comes next."""

    seen: Int[np.ndarray, "t 12"]
    """Kind, kind of the parent, depth, place among siblings, whether it is a mark, member, host,
    array, coarse and fine objects left, how many too many, whether the part is fine."""
    kin: Bool[np.ndarray, "t t"]
    """Which elements are above an element, or children of the same."""
    wish: Float[np.ndarray, " 6"]
    depth: Int[np.ndarray, " t"]
    """Depth of the next token, 0 for the end of the part."""
    above: Int[np.ndarray, " t"]
    """Element that will be its parent."""
    recent: Int[np.ndarray, "t recent"]
    """Kinds of the latest children there, the last one first; -1 where there is none."""
    n_siblings: Int[np.ndarray, " t"]
    kind: Int[np.ndarray, " t"]
    member: Int[np.ndarray, " t"]
    host: Int[np.ndarray, " t"]
    shape: Int[np.ndarray, " t"]

    def __len__(self) -> int:
        return len(self.seen)


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
    """The lesson of a grown program."""
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
    kind, member, host, shape = targets
    return Lesson(
        seen=seen,
        kin=kin,
        wish=wish_numbers(wish),
        depth=depth,
        above=above,
        recent=recent,
        n_siblings=bucket(n_siblings),
        kind=kind,
        member=member,
        host=host,
        shape=shape,
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
