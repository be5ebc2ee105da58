"""Programs as arrays for the writer's training: inputs after each element, and right choices."""

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
"""Target of elements after which a choice does not exist; the loss ignores it."""
N_WISHES = 6


@dataclass(frozen=True, eq=False)
class Lesson:
    """Elements of a program; targets belong to the token that comes next."""

    seen: Int[np.ndarray, "t 12"]
    """Numbers of each element: kind, kind of the parent, depth, place among siblings, 1 for a mark,
    member, host, array, coarse and fine objects left, number of objects too many, 1 in the fine
    part."""
    kin: Bool[np.ndarray, "t t"]
    """True for elements above an element, or children of the same parent."""
    wish: Float[np.ndarray, " 6"]
    depth: Int[np.ndarray, " t"]
    """Depth of the next token; 0 for the end of the part."""
    above: Int[np.ndarray, " t"]
    """Element that will be its parent."""
    recent: Int[np.ndarray, "t recent"]
    """Kinds of the latest children of that parent, the last one first; -1 for none."""
    n_siblings: Int[np.ndarray, " t"]
    kind: Int[np.ndarray, " t"]
    member: Int[np.ndarray, " t"]
    host: Int[np.ndarray, " t"]
    shape: Int[np.ndarray, " t"]

    def __len__(self) -> int:
        return len(self.seen)


def wish_numbers(wish: Wish) -> Float[np.ndarray, " 6"]:
    """Return a wish as numbers of order one: the domain, and logarithms of the counts."""
    domain = np.eye(len(DOMAINS))[DOMAINS.index(wish.domain)]
    counts = np.log1p([wish.n_coarse, wish.n_fine, wish.n_areas])
    # 34 coarse objects, 114 fine ones and 56 areas are the corpus' means: they become about 0.
    return np.concatenate([domain, 2 * counts - (7, 9.5, 8)]).astype(np.float32)


def seen_of(growth: Growth, element: Element) -> list[int]:
    """Return the numbers by which the network reads an element.

    Args:
        growth: The program.
        element: One of its elements.

    Returns:
        Twelve numbers, as `Lesson.seen`; counts are not in classes yet.
    """
    coarse, fine = element.remaining
    return [
        element.kind,
        growth.elements[element.parent].kind,
        min(element.depth, MAX_DEPTH - 1),
        min(element.ordinal, 63),
        int(element.is_mark),
        min(element.member, N_MEMBERS - 1),
        min(element.host, N_HOSTS - 1),
        element.shape,
        # Objects left and objects too many are separate, because classes of counts begin at 0.
        max(coarse, 0),
        max(fine, 0),
        max(-coarse, 0) + max(-fine, 0),
        # The column of the fine part is filled in by the caller.
        0,
    ]


def recent_of(growth: Growth, above: int) -> tuple[list[int], int]:
    """Return the latest children of an element.

    Args:
        growth: The program.
        above: Number of the element.

    Returns:
        Kinds of the latest children, the last one first, -1 for none; and the number of all.
    """
    children = growth.elements[above].children
    recent = children[-N_RECENT:][::-1]
    return recent + [-1] * (N_RECENT - len(recent)), len(children)


def lesson_of(growth: Growth, said: Sequence[tuple[int, Choice | None]], wish: Wish) -> Lesson:
    """Return the lesson of a grown program.

    Args:
        growth: The program at its end.
        said: Right choice after each element, see `replay`.
        wish: Wish that the network reads.
    """
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
    # Children are counted anew: at each element only those before it are known.
    children = [each.children[: each.n_given_children] for each in elements]
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
    """Mark for each element those above it, itself, and its earlier siblings."""
    kin = np.eye(len(parent), dtype=bool)
    for i in range(1, len(parent)):
        kin[i] |= kin[parent[i]]
        kin[i, 1:i] |= parent[1:i] == parent[i]
    return kin
