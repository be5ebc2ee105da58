"""A tiny language of skeletons: houses of roof and rooms, rooms with tables, a lawn with a pad."""

from __future__ import annotations

import numpy as np

from aeroscene.learning.skeleton.tree import Tree
from aeroscene.learning.tokens.kinds import DOMAINS, Kind, Vocabulary
from aeroscene.learning.tokens.skeleton import Skeleton, Wish


def _kind(category: str, **attributes: bool) -> Kind:
    return Kind(category, "outdoor", "top", is_aligned=True, attributes=tuple(attributes.items()))


_SITES = tuple(
    Kind("", "outdoor", "lift", is_aligned=True, attributes=(("domain", domain),))
    for domain in DOMAINS
)
_KINDS = (
    _kind("house"),
    _kind("lawn"),
    _kind("roof"),
    _kind("room"),
    _kind("chair"),
    _kind("cup"),
    _kind("landing_pad", is_start=True),
    _kind("table"),
    _kind("tree"),
)
VOCABULARY = Vocabulary((*_SITES, *_KINDS), ((),) * (len(_SITES) + len(_KINDS)), {})
HOUSE, LAWN, ROOF, ROOM, CHAIR, CUP, PAD, TABLE, TREE = range(3, 12)


def site(domain: str = "outdoor") -> Skeleton:
    """A site with nothing on it."""
    return Skeleton(domain, np.array([DOMAINS.index(domain)]), np.array([0]), 1)


def toy_skeleton(rng: np.random.Generator) -> Skeleton:
    """A lawn with the start pad and trees, one to three houses; each has a roof and rooms."""
    tree = Tree(site())
    tree.add(1, LAWN, is_coarse=True)
    lawn, rooms, n = 1, [], 1
    for _ in range(rng.integers(1, 4)):
        n_rooms = int(rng.integers(1, 4))
        for depth, kind in ((1, HOUSE), *[(2, ROOM)] * n_rooms, (2, ROOF)):
            tree.add(depth, kind, is_coarse=True)
            n += 1
            rooms += [n] if kind == ROOM else []
    tree.turn_to(lawn)
    for kind in (PAD, *[TREE] * int(rng.integers(1, 5))):
        tree.add(1, kind, is_coarse=False)
    for room in rooms:
        tree.turn_to(room)
        for depth, kind in ((1, TABLE), *[(2, CUP)] * int(rng.integers(0, 3)), (1, CHAIR)):
            tree.add(depth, kind, is_coarse=False)
    return tree.skeleton()


def wish_of(skeleton: Skeleton) -> Wish:
    """What a toy skeleton has."""
    return Wish(
        skeleton.domain,
        skeleton.n_coarse - 1,
        len(skeleton) - skeleton.n_coarse,
        len(skeleton) // 3,
    )


def toy_corpus(n: int, seed: int = 0) -> list[tuple[Skeleton, Wish]]:
    """Skeletons with their wishes."""
    rng = np.random.default_rng(seed)
    skeletons = [toy_skeleton(rng) for _ in range(n)]
    return [(skeleton, wish_of(skeleton)) for skeleton in skeletons]


def describe(skeleton: Skeleton) -> list[tuple[str, str]]:
    """Categories of each object and its parent."""
    names = [VOCABULARY.kinds[kind].category for kind in skeleton.kind_id]
    return [(names[p], name) for p, name in zip(skeleton.parent[1:], names[1:], strict=True)]
